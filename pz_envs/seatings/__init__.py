"""The ways to seat teachers and students, one module each, named as in `raw_env(seating=...)`."""
