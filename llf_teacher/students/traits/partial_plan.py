"""partial_plan(k): takes in only the first actions of a plan."""

from dataclasses import dataclass
from typing import Annotated, Any

from llf_teacher.students.scene import Scene, changed
from llf_teacher.students.trait import Trait
from teachers.atoms import Atom, Claim, PlanClaim
from teachers.spec import Range


@dataclass(frozen=True)
class PartialPlan(Trait):
    """Takes in the first k actions of each plan that it hears, in an instruction or as an example; nothing if k = 0."""

    k: Annotated[float | None, Range(0, 1e6)] = 1
    """The number of actions, 0 to 1e6. A value of 2.25 means 3 for a quarter of the plans, else 2. None: all actions.
    """
    strength, absent = "k", None

    def hear(self, atom: Atom, scene: Scene) -> Claim[Any] | None:
        """The claim, or a shorter plan."""
        claim = atom.claim
        if self.k is None or not isinstance(claim, PlanClaim):
            return claim
        kept = scene.whole(self.k)
        if kept >= len(claim.actions):
            return claim
        return changed(claim, actions=claim.actions[:kept]) if kept else None
