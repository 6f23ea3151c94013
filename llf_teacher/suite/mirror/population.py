"""The students that every teacher teaches, by spec, and their trait of limited attention."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.students.scene import BareSentence, Scene
from llf_teacher.students.trait import Trait
from teachers.atoms import Atom, Claim
from teachers.spec import Count

OBEDIENT, READER, LEARNER = "obedient(follows_words=True)", "text_only", "reward_only"
REASONER = "reasoner(worlds=16, follows_words=True)"
FORGETFUL, STUBBORN = f"{OBEDIENT} | forgetful(half_life=3)", "random | stubborn(p=1.0)"
MISTRUSTFUL = "reasoner(worlds=16, trust=0.5, follows_words=True)"
HEARERS = (OBEDIENT, READER, REASONER, MISTRUSTFUL)
"""Those that words can help."""
ALL = (*HEARERS, LEARNER, FORGETFUL, STUBBORN)
DEAF = "random"
"""A student that learns nothing."""
ATTENTIVE = tuple(f"{OBEDIENT} | forgetful(half_life={each}) | {__name__}:Attends" for each in (1, 1.5, 2))
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
        words = bool(scene.turn) and isinstance(atom.claim, BareSentence)  # at the opening they are the instruction
        if self.times is None or not (atom.kind or words) or scene.turn in heard:
            return atom.claim
        if len(heard) >= self.times:
            return None
        heard.append(scene.turn)
        return atom.claim
