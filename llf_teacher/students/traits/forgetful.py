"""forgetful(half_life): forgets what it has heard and seen, with a half-life in turns."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from llf_teacher.students.scene import Floats, HeardTurn, Recovery, Scene, SceneBatch
from llf_teacher.students.trait import Trait
from teachers.spec import Range
from worlds.batches import Bools


@dataclass(frozen=True)
class Forgetful(Trait):
    """Forgets, before a turn, all that it has heard and seen, with probability 1 - 2 ** (-1 / half_life).

    So of what it heard k turns ago it still knows each thing with probability 2 ** (-k / half_life), all things
    together. It goes on like a new student of its kind: a learner without values, a model with an empty conversation.
    What remains is the instruction, without what that says of actions.
    """

    half_life: Annotated[float | None, Range(0.01, 1e6)] = 5
    """The half-life in turns, 0.01 to 1e6; None: it never forgets."""
    strength, absent = "half_life", None
    strengths = np.geomspace(0.1, 1000, 2001)
    recovery = Recovery(5, teacher="silent", instruction_type="c", feedback_type="n")

    def forgets(self, scene: Scene) -> bool:
        """Whether it does now."""
        return self.half_life is not None and not scene.happens(2 ** (-1 / self.half_life))

    def forgets_rows(self, scene: SceneBatch) -> Bools:
        """`forgets` in arrays."""
        every = np.ones(len(scene.rows), bool)
        return ~every if self.half_life is None else ~scene.happens(2 ** (-1 / self.half_life), every)

    def log_likelihood(self, strengths: Floats, steps: Sequence[HeardTurn]) -> Floats:
        """By the probability of the turn in which it forgot last, given what it did until then."""
        stays = 2 ** (-1 / strengths)
        forgot = [np.ones_like(strengths)]  # by turn, from 0: never
        total = np.zeros_like(strengths)
        for turn, step in enumerate(steps):
            if turn:
                forgot = [weight * stays for weight in forgot] + [1 - stays]
            if step.advised is None:
                continue
            known, unknown = float(step.followed), step.chance if step.followed else 1 - step.chance
            forgot = [weight * (known if at <= step.said else unknown) for at, weight in enumerate(forgot)]
            sums = np.sum(forgot, axis=0)
            with np.errstate(divide="ignore", invalid="ignore"):
                total += np.log(sums)
                forgot = [weight / sums for weight in forgot]
        return total
