"""The definition of a study: its lists, and further declarations."""
