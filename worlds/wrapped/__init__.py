"""Worlds made of environments that others have written, current ones or those of the old Gym."""
