"""One student a module, named as in spec strings."""
