"""ALFWorld: household tasks in text, on the houses and rules of ALFWorld, without a download.

Shridhar et al. 2021, "ALFWorld: Aligning Text and Embodied Environments for Interactive Learning".
"""

from worlds.alfworld.games import SPLITS, TASKS, Fact, Game
from worlds.alfworld.world import ENGINES, MAX_LENGTH, ORACLES, SOURCES, Alfworld, Truth

__all__ = ["ENGINES", "MAX_LENGTH", "ORACLES", "SOURCES", "SPLITS", "TASKS", "Alfworld", "Fact", "Game", "Truth"]
