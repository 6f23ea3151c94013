"""The definition of a study: its lists, and what it may declare beside them."""
