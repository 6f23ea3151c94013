"""One file of phrases a family, named after its world."""
