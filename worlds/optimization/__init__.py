"""Optimization: find the least value of a loss of two numbers, one proposal a turn.

Eight test functions of the optimization literature with exact derivatives, and losses of the user's own.
"""

from worlds.optimization.functions import LOSSES
from worlds.optimization.loss import Gradient, Landscape, Loss, Point, Value
from worlds.optimization.world import SCALE, TOLERANCE, Optimization, Truth

__all__ = ["LOSSES", "SCALE", "TOLERANCE", "Gradient", "Landscape", "Loss", "Optimization", "Point", "Truth", "Value"]
