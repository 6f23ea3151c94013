"""Teachers: oracles state typed claims about a world, personalities choose among them, voices word them."""
