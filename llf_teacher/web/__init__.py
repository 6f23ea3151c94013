"""A page in the browser: lessons with people in the seats, and stored episodes to look at.

`app` is the server, `open_lessons` keeps the lessons, `lesson` plays one, `plan` reads what was chosen for it.
"""
