"""oracle: acts by an optimal policy with the truth in view; the ceiling of every study."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.students.student import Policy, Student


class _Policy(Policy["Optimal"]):
    """Has an oracle of its own."""

    def begin(self) -> None:
        """Engage the oracle."""
        self._oracle = self.family.oracle_class()(self.world.scratch)

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """The first step of the best plan; anything once there is nothing left to do."""
        moment = info["moment"]
        if moment.turn == 0:
            self._oracle.start(moment.after)
        plan = self._oracle.plan(moment.after, 1)
        return plan[0] if plan else self.world.sample_action(self.rng)


@dataclass(frozen=True)
class Optimal(Student):
    """Asks the family's oracle what to do."""

    reads = "truth"
    policy = _Policy
