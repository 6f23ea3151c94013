"""capitulates(after): gives in to advice that it has not taken several times in a row."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from llf_teacher.students.scene import Floats, HeardTurn, Recovery, Scene
from llf_teacher.students.trait import Trait
from teachers.atoms import FP, Atom, Claim, action_of
from teachers.spec import Range


@dataclass(frozen=True)
class Capitulates(Trait):
    """Takes the advised action once it has heard advice, and done something else, `after` times in a row.

    Turns without advice do not count. When it takes the advice, of itself or because it gives in, it begins to count
    anew. Of several pieces of advice for a turn the last counts.
    """

    after: Annotated[float | None, Range(0, 1e6)] = 2
    """The number of times, 0 to 1e6, 0: it always takes advice. Of 2.25 it is 3 in a quarter of cases, else 2, drawn
    whenever it begins to count. None: it never gives in."""
    strength, absent = "after", None
    strengths = np.linspace(0, 20, 2001)
    recovery = Recovery(2.4, student="tamer")

    def hear(self, atom: Atom, scene: Scene) -> Claim[Any]:
        """The claim; the advice for this turn is kept."""
        if atom.kind is FP and atom.about_turn == scene.turn and (action := action_of(atom.claim)) is not None:
            scene.memory["advice"] = scene.turn, action
        return atom.claim

    def act(self, action: Any, scene: Scene) -> Any:
        """The action, or the advised one."""
        turn, advised = scene.memory.get("advice", (None, None))
        if self.after is None or turn != scene.turn:
            return action
        unheeded, patience = scene.memory.get("count") or (0, scene.whole(self.after))
        heeds = scene.meant(action) == advised
        gives_in = unheeded >= patience
        scene.memory["count"] = None if heeds or gives_in else (unheeded + 1, patience)
        return scene.as_given(advised) if gives_in and not heeds else action

    def log_likelihood(self, strengths: Floats, steps: Sequence[HeardTurn]) -> Floats:
        """By the number of times that it did not take advice before, of a student that else acts at random."""
        least = np.floor(strengths)
        total, unheeded = np.zeros_like(strengths), 0
        for step in steps:
            if step.now:
                gives_in = np.where(unheeded < least, 0.0, np.where(unheeded == least, 1 - strengths % 1, 1.0))
                follows = gives_in + (1 - gives_in) * step.chance
                with np.errstate(divide="ignore"):
                    total += np.log(follows if step.followed else 1 - follows)
                unheeded = 0 if step.followed else unheeded + 1
        return total
