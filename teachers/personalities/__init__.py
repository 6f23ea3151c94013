"""One personality a module, named as in spec strings."""
