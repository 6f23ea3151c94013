"""Raw simulators: numbers, state and reward. They know no language, no teacher and no agent.

What stays are the names that a package or a module lists in its `__all__`; `worlds.testing` is public as a whole. What
else a package's modules have is for the package itself.
"""
