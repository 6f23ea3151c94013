"""obedient: does what the teacher's claims say."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from llf_teacher.students.advice import AdviceTaker, Believer
from llf_teacher.students.listening import ListeningPolicy
from teachers.atoms import ActionClaim, Atom, PlanClaim, unhedged


class _Policy(ListeningPolicy["Obedient"], AdviceTaker["Obedient"]):
    """Learns from atoms."""

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """Learn from the atoms, then act."""
        self._listen(self.heard(observation, info, self.arrive(observation)))
        action = self.decide()
        self.did(action)
        return action

    def finish(self, observation: dict[str, Any], info: dict[str, Any], terminated: bool) -> None:
        """Learn from the last atoms, for later episodes."""
        self._listen(self.heard(observation, info, len(self._states)))

    def _listen(self, atoms: Iterable[Atom]) -> None:
        for atom in atoms:
            claim = unhedged(atom.claim)
            if isinstance(claim, ActionClaim):
                self.hear(claim.kind, (claim.action,), atom.about_turn, endless=True)
            elif isinstance(claim, PlanClaim):
                self.hear(claim.kind, claim.actions, atom.about_turn)


@dataclass(frozen=True)
class Obedient(Believer):
    """Believes every claim about an action, hedged or not; it reads claims as data, so the wording has no effect."""

    follows_words: bool = False
    """Whether it also believes words of people and models without claims, as far as `pz_envs.text.claims` reads."""
    reads = "atoms"
    policy = _Policy
    batch = "ObedientBatch"
