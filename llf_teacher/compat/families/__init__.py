"""Families whose observations, spaces or words LLF-Bench's users know: a `Surface` in a module of the family's name."""
