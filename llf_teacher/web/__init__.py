"""A page in the browser for one person: lessons with people in the seats, and a viewer of stored episodes.

`app` is the server, `open_lessons` has the lessons, `lesson` plays one, `plan` checks the choices of its form.
"""
