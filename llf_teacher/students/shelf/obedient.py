"""obedient: does what the teacher's atoms say."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.students.advice import AdviceTaker
from llf_teacher.students.student import Student


@dataclass(frozen=True)
class Obedient(Student):
    """Believes every claim about an action, and reads claims as data, so that wording does not matter."""

    reads = "atoms"

    class Policy(AdviceTaker):
        """Learns from atoms."""

        def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
            """Obey."""
            self.arrive(observation)
            for atom in info["atoms"]:
                claim = atom.claim
                if hasattr(claim, "action"):
                    if claim.kind is None:
                        self.follow((claim.action,), endless=True)
                    else:
                        self.learn(claim.kind, claim.action, atom.about_turn)
                elif hasattr(claim, "actions"):
                    self.follow(claim.actions)
            return self.decide()
