"""Students, one per module, which has the name in spec strings."""
