"""The students that every teacher teaches, by spec, and their trait of limited attention."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.students.scene import Scene
from llf_teacher.students.trait import Trait
from teachers.atoms import Atom, Claim
from teachers.spec import Count

OBEDIENT, READER, REASONER, LEARNER = "obedient", "text_only", "reasoner(worlds=16)", "reward_only"
FORGETFUL, STUBBORN = "obedient | forgetful(half_life=3)", "random | stubborn(p=1.0)"
MISTRUSTFUL = "reasoner(worlds=16, trust=0.5)"
HEARERS = (OBEDIENT, READER, REASONER, MISTRUSTFUL)
"""Those that words can help."""
ALL = (*HEARERS, LEARNER, FORGETFUL, STUBBORN)
DEAF = "random"
"""A student that learns nothing."""
ATTENTIVE = tuple(f"obedient | forgetful(half_life={each}) | {__name__}:Attends" for each in (1, 1.5, 2))
"""Students that forget, and hear the teacher in three turns only."""
KEEPER = "reasoner(worlds=64, forget=False)"
"""One that keeps the rules of a town from world to world."""


@dataclass(frozen=True)
class Attends(Trait):
    """Hears the feedback of so many turns, the first in which something is said, and none after them."""

    times: Count | None = 3
    strength, absent = "times", None

    def hear(self, atom: Atom, scene: Scene) -> Claim[Any] | None:
        """The claim, or nothing."""
        heard = scene.memory.setdefault("heard", [])
        if self.times is None or atom.kind is None or scene.turn in heard:
            return atom.claim
        if len(heard) >= self.times:
            return None
        heard.append(scene.turn)
        return atom.claim
