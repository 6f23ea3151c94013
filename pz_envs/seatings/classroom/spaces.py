"""What the teacher of a class observes and does, as spaces; `ClassroomEnv` says what is in them."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces

from pz_envs.seatings.tutoring import TutoringEnv, words_space
from pz_envs.seats import STUDENT
from pz_envs.teacher_seat import CHOICES, CLAIMS, PROSE, TRAITS, mask_space
from teachers.atoms import KINDS
from worlds.spaces import Prose


def sayings(speech: str) -> int:
    """How many things there may be to choose from that can be said to a student."""
    count: int = CHOICES.get(speech, 1)
    return count - 1


def teachers_view(desks: Sequence[TutoringEnv], speech: str) -> spaces.Dict:
    """What the teacher observes."""
    count = len(desks)
    if speech == "message":
        return spaces.Dict({f"{STUDENT[:-1]}{i}": words_space() for i in range(count)})
    low, high = desks[0].seat.feature_bounds()
    more: dict[str, spaces.Space[Any]] = {}
    if speech == "claims":
        more["claims"] = spaces.Box(0, 1, (count, CLAIMS, len(TRAITS)), np.int8)
    if desks[0].ask_cost is not None:
        more["asking"] = spaces.MultiBinary(count)
    keep = [0, 1, 2, 4, 4, 4]  # presence and attendance have the bounds of `over`
    return spaces.Dict(
        {
            "students": spaces.Box(np.tile(low[keep], (count, 1)), np.tile(high[keep], (count, 1))),
            "available": spaces.MultiBinary((count, len(KINDS))),
            "purse": spaces.Box(0, 1, (2,), np.float32),
            "action_mask": mask_space(1 + sayings(speech) * count),
            **more,
        }
    )


def teachers_choice(students: int, speech: str) -> spaces.Space[Any]:
    """What the teacher does."""
    if speech == "message":
        return spaces.Dict({"student": spaces.Discrete(students + 1), "words": Prose(PROSE)})
    return spaces.Discrete(1 + sayings(speech) * students)
