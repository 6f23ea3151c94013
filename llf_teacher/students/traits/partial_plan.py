"""partial_plan(k): takes in only the first actions of a plan."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from llf_teacher.students.scene import Floats, HeardTurn, Recovery, Scene, changed
from llf_teacher.students.trait import Trait
from teachers.atoms import Atom, Claim, PlanClaim
from teachers.spec import Range


@dataclass(frozen=True)
class PartialPlan(Trait):
    """Takes in the first k actions of each plan that it hears, in an instruction or as an example; of none, nothing."""

    k: Annotated[float | None, Range(0, 1e6)] = 1
    """The number of actions, 0 to 1e6. Of 2.25 it is 3 for a quarter of the plans, else 2. None: all of them."""
    strength, absent = "k", None
    strengths = np.linspace(0, 20, 2001)
    recovery = Recovery(1.4, teacher="silent", instruction_type="c", feedback_type="n")

    def hear(self, atom: Atom, scene: Scene) -> Claim[Any] | None:
        """The claim, or a shorter plan."""
        claim = atom.claim
        if self.k is None or not isinstance(claim, PlanClaim):
            return claim
        kept = scene.whole(self.k)
        if kept >= len(claim.actions):
            return claim
        return changed(claim, actions=claim.actions[:kept]) if kept else None

    def log_likelihood(self, strengths: Floats, steps: Sequence[HeardTurn]) -> Floats:
        """By the number of the plan's actions that are certainly known, and the probability of one more."""
        plan = [step for step in steps if step.planned]
        if not plan:
            return 0.0 * strengths
        # Per number of actions that are known the likelihood of what was done.
        known = np.cumprod([1.0] + [float(step.followed) for step in plan])
        luck = [step.chance if step.followed else 1 - step.chance for step in plan]
        guessed = np.append(np.cumprod(luck[::-1])[::-1], 1.0)
        least = np.minimum(np.floor(strengths).astype(int), len(plan))
        by_count = known * guessed
        with np.errstate(divide="ignore"):
            more = strengths % 1
            return np.asarray(np.log((1 - more) * by_count[least] + more * by_count[np.minimum(least + 1, len(plan))]))
