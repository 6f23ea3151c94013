"""Meta-World: a robot arm with a gripper, with a target pose per turn.

The simulator is metaworld's, on MuJoCo, with faster low-level steps whose results are the same to the last bit. A world
holds its state as a value; all worlds of the same task in a thread share a simulator.
"""

from importlib.util import find_spec

if find_spec("metaworld") is None:  # imported only where it is needed, as that takes seconds; it is missed at once
    raise ModuleNotFoundError("No module named 'metaworld'", name="metaworld")

from worlds.metaworld.script import Aim, Script
from worlds.metaworld.simulator import Simulator
from worlds.metaworld.state import Episode, Pose, Truth
from worlds.metaworld.tasks import TASKS
from worlds.metaworld.world import (
    ARRIVED,
    CONTROLS,
    LONGEST,
    LONGEST_BY_EVENT,
    NEW_AIM,
    NEW_GRIP,
    REACH,
    SHORTEST,
    TRAVEL,
    MetaWorld,
)

__all__ = [
    "ARRIVED",
    "CONTROLS",
    "LONGEST",
    "LONGEST_BY_EVENT",
    "NEW_AIM",
    "NEW_GRIP",
    "REACH",
    "SHORTEST",
    "TASKS",
    "TRAVEL",
    "Aim",
    "Episode",
    "MetaWorld",
    "Pose",
    "Script",
    "Simulator",
    "Truth",
]
