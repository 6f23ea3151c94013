"""forgetful(half_life): forgets what it has heard and seen, with a half-life in turns."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from llf_teacher.students.scene import Scene, SceneBatch
from llf_teacher.students.trait import Trait
from teachers.spec import Range
from worlds.batches import Bools


@dataclass(frozen=True)
class Forgetful(Trait):
    """Forgets, before a turn, all that it has heard and seen, with probability 1 - 2 ** (-1 / half_life).

    So it still knows what it heard k turns ago with probability 2 ** (-k / half_life); it forgets everything at once.
    It goes on like a new student of its kind: a learner without values, a model with an empty conversation. The
    instruction remains, without its claims about actions.
    """

    half_life: Annotated[float | None, Range(0.01, 1e6)] = 5
    """The half-life in turns, 0.01 to 1e6; None: it never forgets."""
    strength, absent = "half_life", None

    def forgets(self, scene: Scene) -> bool:
        """Whether it forgets now."""
        return self.half_life is not None and not scene.happens(2 ** (-1 / self.half_life))

    def forgets_rows(self, scene: SceneBatch) -> Bools:
        """`forgets` in arrays."""
        every = np.ones(len(scene.rows), bool)
        return ~every if self.half_life is None else ~scene.happens(2 ** (-1 / self.half_life), every)
