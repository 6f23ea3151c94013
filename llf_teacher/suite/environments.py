"""The environments of the experiments, with their options."""

from collections.abc import Mapping
from typing import Any

ARMS, HOUSE = "llf-bandits-BanditTenArmedRandomFixed-v0", "llf-gridworld-v0"
FILMS = "llf-reco-movie-v0"
"""Films, since the same list is right in every turn; in a house each room needs another move."""
OPTIONS: Mapping[str, Mapping[str, Any]] = {HOUSE: {"map": True}}
"""By id: in a house the instruction has the plan, so that praise and blame tell where the treasure can be."""
