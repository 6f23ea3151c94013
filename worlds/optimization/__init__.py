"""Optimization: minimise a loss of two numbers, with a proposal per turn.

The losses are eight test functions from the literature with exact derivatives, and custom functions.
"""

from worlds.optimization.functions import LOSSES
from worlds.optimization.loss import Gradient, Landscape, Loss, Point, Value
from worlds.optimization.world import SCALE, TOLERANCE, Optimization, Truth

__all__ = ["LOSSES", "SCALE", "TOLERANCE", "Gradient", "Landscape", "Loss", "Optimization", "Point", "Truth", "Value"]
