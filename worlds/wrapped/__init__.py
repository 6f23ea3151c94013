"""Worlds that wrap environments of other packages, of Gymnasium or the old Gym."""
