"""obedient: does what the teacher's atoms say."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.students.advice import AdviceTaker, Believer
from teachers.atoms import ActionClaim, PlanClaim


class _Policy(AdviceTaker["Obedient"]):
    """Learns from atoms."""

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """Obey."""
        self.arrive(observation)
        self._listen(info)
        return self.decide()

    def finish(self, observation: dict[str, Any], info: dict[str, Any], terminated: bool) -> None:
        """Hear the last words, for the episodes to come."""
        self._listen(info)

    def _listen(self, info: dict[str, Any]) -> None:
        for atom in info["atoms"]:
            claim = atom.claim
            if isinstance(claim, ActionClaim):
                self.hear(claim.kind, (claim.action,), atom.about_turn, endless=True)
            elif isinstance(claim, PlanClaim):
                self.hear(claim.kind, claim.actions, atom.about_turn)


@dataclass(frozen=True)
class Obedient(Believer):
    """Believes every claim about an action, and reads claims as data, so that wording does not matter."""

    reads = "atoms"
    policy = _Policy
