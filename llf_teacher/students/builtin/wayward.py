"""wayward: has a habit that its teacher does not expect, such as repeating itself; for audits."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.serialization import to_json
from llf_teacher.students.student import Policy, Student
from teachers.spec import unknown
from teachers.testing.habits import HABITS, Seen


class _Policy(Policy["Wayward"]):
    """Acts by its habit, with the truth in view."""

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """What the habit comes up with."""
        claims = [atom.claim for atom in info["atoms"]]
        listed = info.get(self.world.actions_key) or ()
        action = HABITS[self.spec.habit].act(Seen(self.world, info["moment"], claims, listed, self.rng))
        if not self.spec.text:
            return action
        return str(action) if isinstance(action, str) else to_json(action)


@dataclass(frozen=True)
class Wayward(Student):
    """Does not care what is said, or does the contrary."""

    habit: str = "repeating"
    """One of `teachers.testing.habits.HABITS`."""
    reads = "truth"
    policy = _Policy

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.habit not in HABITS:
            raise ValueError(unknown("habit", self.habit, tuple(HABITS)))

    @property
    def text(self) -> bool:
        """Only a text can be garbled."""
        return self.habit == "garbling"

    @property
    def patience(self) -> int | None:
        """Turns after which it leaves, if it does."""
        return HABITS[self.habit].patience
