"""The state of the world as a value."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
ImageArray = npt.NDArray[np.uint8]
Pose = tuple[float, float, float, float]
"""x, y and z of the hand in metres, and the grip from -1 (open) to 1 (close)."""


class Episode(NamedTuple):
    """The constant part of an episode, shared by its snapshots."""

    variation: tuple[float, ...]
    """metaworld's random vector: positions of objects and goal."""
    bodies: bytes
    """`body_pos` of the MuJoCo model, which metaworld changes at reset."""
    sites: bytes
    """`site_pos` of the MuJoCo model."""
    attributes: tuple[tuple[str, Any], ...]
    """Attributes of metaworld's object that its reset has set; arrays as tuples."""


class Truth(NamedTuple):
    """The complete state."""

    observation: tuple[float, ...]
    """metaworld's 39 numbers: 18 current ones, 18 of the low-level step before, the goal."""
    solved: bool
    """Whether the task has been solved in this episode."""
    physics: bytes
    """MuJoCo's integration state: positions, velocities, mocap, warm start, time and so on."""
    passing: tuple[Any, ...]
    """The attributes of metaworld's object that change in a step."""
    episode: Episode
