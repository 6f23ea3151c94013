"""One way to seat teachers and students a module, named as in `raw_env(seating=...)`."""
