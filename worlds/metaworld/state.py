"""The state of a world, as a value."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
ImageArray = npt.NDArray[np.uint8]
Pose = tuple[float, float, float, float]
"""x, y and z of the hand in metres, and the grip from -1 (open) to 1 (close)."""


class Episode(NamedTuple):
    """What stays the same for an episode; shared by reference between snapshots."""

    variation: tuple[float, ...]
    """metaworld's random vector: where things are."""
    bodies: bytes
    """`body_pos` of the MuJoCo model, which metaworld moves at reset."""
    sites: bytes
    """`site_pos` of the MuJoCo model."""
    attributes: tuple[tuple[str, Any], ...]
    """What metaworld's reset has written into its Python object; arrays as tuples."""


class Truth(NamedTuple):
    """The whole state."""

    observation: tuple[float, ...]
    """metaworld's 39 numbers: 18 of now, 18 of one low-level step before, the goal."""
    solved: bool
    """Whether the task has been solved in this episode."""
    physics: bytes
    """MuJoCo's integration state: positions, velocities, mocap, warm start, time and so on."""
    passing: tuple[Any, ...]
    """The attributes of metaworld's object that change in a step."""
    episode: Episode
