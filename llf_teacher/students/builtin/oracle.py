"""oracle: acts by an optimal policy and sees the truth; the upper bound in every study."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.students.student import Policy, Student


class _Policy(Policy["Optimal"]):
    """Acts by the plans of its own oracle."""

    def begin(self) -> None:
        """Make a new oracle."""
        self._oracle = self.family.oracle_class()(self.world.scratch)

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """The first step of the best plan; a random action if the plan is empty."""
        moment = info["moment"]
        if moment.turn == 0:
            self._oracle.start(moment.after)
        plan = self._oracle.plan(moment.after, 1)
        return plan[0] if plan else self.world.sample_action(self.rng)


@dataclass(frozen=True)
class Optimal(Student):
    """Acts by the plan of the family's oracle."""

    reads = "truth"
    policy = _Policy
