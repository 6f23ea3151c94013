"""The environments of the experiments, with their options."""

from collections.abc import Mapping
from typing import Any

ARMS, HOUSE = "llf-bandits-BanditTenArmedRandomFixed-v0", "llf-gridworld-v0"
FILMS = "llf-reco-movie-v0"
"""Where the same films are right in every turn, while in a house each room asks for another move."""
OPTIONS: Mapping[str, Mapping[str, Any]] = {HOUSE: {"map": True}}
"""By id: in a house the plan is in the instruction, so that what was good or bad tells where the treasure can be."""
