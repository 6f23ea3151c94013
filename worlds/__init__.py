"""Raw simulators: numbers, state and reward, without language, teaching or agents.

The public names are those in the `__all__` of a package or module, and everything in `worlds.testing`. All other names
are internal to their package.
"""
