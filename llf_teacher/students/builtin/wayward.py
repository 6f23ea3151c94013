"""wayward: acts by a habit that teachers may not expect, such as repetition; for audits."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.serialization import to_json
from llf_teacher.students.student import Policy, Student
from teachers.spec import unknown
from teachers.testing.habits import HABITS, Seen


class _Policy(Policy["Wayward"]):
    """Acts by its habit, and sees the truth."""

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """The action of the habit."""
        claims = [atom.claim for atom in info["atoms"]]
        listed = info.get(self.world.actions_key) or ()
        action = HABITS[self.spec.habit].act(Seen(self.world, info["moment"], claims, listed, self.rng))
        if not self.spec.text:
            return action
        return str(action) if isinstance(action, str) else to_json(action)


@dataclass(frozen=True)
class Wayward(Student):
    """Ignores the teacher, or does the opposite."""

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
        """True for the habit `garbling`, which garbles texts."""
        return self.habit == "garbling"

    @property
    def patience(self) -> int | None:
        """Number of turns after which it leaves; None: it stays."""
        return HABITS[self.habit].patience
