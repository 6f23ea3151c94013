"""Meta-World: a robot arm with a gripper, one target pose a turn.

The simulator is metaworld's, on MuJoCo; its low-level steps are made cheaper here, with results that stay the same to
the last bit. A world holds its state as a value; the simulator that computes the next one is shared by all worlds of
the same task in a thread.
"""

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
