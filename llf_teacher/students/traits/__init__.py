"""Traits of students, one per module, which has the name in spec strings."""
