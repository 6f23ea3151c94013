"""obedient: does what the teacher's atoms say."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.students.advice import AdviceTaker, Believer
from teachers.atoms import ActionClaim, PlanClaim, unhedged


class _Policy(AdviceTaker["Obedient"]):
    """Learns from atoms."""

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """Learn from the atoms, then act."""
        self.arrive(observation)
        self._listen(info)
        return self.decide()

    def finish(self, observation: dict[str, Any], info: dict[str, Any], terminated: bool) -> None:
        """Learn from the last atoms, for later episodes."""
        self._listen(info)

    def _listen(self, info: dict[str, Any]) -> None:
        for atom in info["atoms"]:
            claim = unhedged(atom.claim)
            if isinstance(claim, ActionClaim):
                self.hear(claim.kind, (claim.action,), atom.about_turn, endless=True)
            elif isinstance(claim, PlanClaim):
                self.hear(claim.kind, claim.actions, atom.about_turn)


@dataclass(frozen=True)
class Obedient(Believer):
    """Believes every claim about an action, hedged or flat; it reads claims as data, so the wording has no effect."""

    reads = "atoms"
    policy = _Policy
    batch = "ObedientBatch"
