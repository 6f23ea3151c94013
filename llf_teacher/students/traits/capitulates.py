"""capitulates(after): gives in to advice after not following it several times in a row."""

from dataclasses import dataclass
from typing import Annotated, Any

from llf_teacher.students.scene import Scene
from llf_teacher.students.trait import Trait
from teachers.atoms import FP, Atom, Claim, action_of
from teachers.spec import Range


@dataclass(frozen=True)
class Capitulates(Trait):
    """Takes the advised action once it has heard advice, and done something else, `after` times in a row.

    Turns without advice do not count. When it takes the advice, by choice or because it gives in, the count restarts.
    If there are several pieces of advice for a turn, the last one counts.
    """

    after: Annotated[float | None, Range(0, 1e6)] = 2
    """The number of times, 0 to 1e6, 0: it always takes advice. A value of 2.25 means 3 in a quarter of cases, else 2,
    drawn whenever the count restarts. None: it never gives in.
    """
    strength, absent = "after", None

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
