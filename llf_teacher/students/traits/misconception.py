"""misconception(p): holds one false belief, and acts on it until words correct that belief."""

import dataclasses
from dataclasses import dataclass
from typing import Any

from llf_teacher.students.scene import BareSentence, Scene
from llf_teacher.students.trait import Trait
from teachers import common
from teachers.atoms import FN, HN, ActionClaim, Atom, Claim, unhedged
from teachers.common import Better
from teachers.oracle import claims_of
from teachers.spec import Share


@dataclass(frozen=True)
class Misconception(Trait):
    """Believes that one action a is right in every state, and takes it, until a claim corrects this belief.

    The belief is "arm 3 is the best", "go east", "the minimum is at (1.5, -2)". While it is held, the student takes a
    with probability p in each turn, whatever it chooses. A claim corrects the belief, for the rest of the episode, if

    - it blames a (hn) or warns of a (fn): an `ActionClaim` whose action is a, also late, hedged or from the practice
      of an instruction; or
    - it says that another action is better than a: a `common.Better` with `that` equal to a; or
    - it blames (hn) a turn in which the student took a, in a family where no blame has an action (movies, poem); if the
      claim has texts, such as titles, one of them must be part of a.

    Nothing else does: no advice of another action, true or not; no praise, reward, clue or plan; no blame of another
    action; no claim that fits every task, such as "that was not it, try again"; no words without a claim. The student
    hears every claim unchanged, so that it has learned from all of them when the belief ends.

    An action that is drawn may happen to be right, as one arm of ten is. Then nothing true corrects it.
    """

    p: Share = 1.0
    """The probability of acting on the belief while it is held, independent for each turn, 0 to 1; 0: never."""
    action: Any = None
    """The action a, such as 3 or 'north', in any form that the world takes; None: drawn at the start of each episode,
    from the listed actions where the world lists those that have an effect."""
    strength = "p"

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.action, list):
            object.__setattr__(self, "action", tuple(self.action))

    def hear(self, atom: Atom, scene: Scene) -> Claim[Any]:
        """The claim; the belief ends if it is corrected."""
        if not isinstance(atom.claim, BareSentence) and self._corrects(atom, scene):
            scene.memory["corrected"] = True
        return atom.claim

    def act(self, action: Any, scene: Scene) -> Any:
        """The believed action, or this one."""
        believed = self._belief(scene)
        if not scene.memory.get("corrected") and scene.happens(self.p):
            taken = scene.meant(action) == believed
            action = action if taken else scene.as_given(believed)
        if scene.meant(action) == believed:
            scene.memory.setdefault("turns", set()).add(scene.turn + 1)  # feedback on it is about the next turn
        return action

    def _belief(self, scene: Scene) -> Any:
        """The action a in canonical form."""
        if "belief" not in scene.memory:
            drawn = self.action
            if drawn is None and scene.listed:
                drawn = scene.listed[int(scene.rng.integers(len(scene.listed)))]
            elif drawn is None:
                drawn = scene.world.sample_action(scene.rng)
            elif isinstance(drawn, str):
                drawn = scene.world.action_words.get(drawn, drawn)
            scene.memory["belief"] = scene.world.legal(drawn)
        return scene.memory["belief"]

    def _corrects(self, atom: Atom, scene: Scene) -> bool:
        """Whether a claim rejects the belief; see this class."""
        claim = unhedged(atom.claim)
        believed = self._belief(scene)
        if isinstance(claim, Better):
            return bool(claim.that == believed)
        if isinstance(claim, ActionClaim):
            return claim.kind in (HN, FN) and bool(claim.action == believed)
        if claim.kind is not HN or atom.about_turn not in scene.memory.get("turns", ()) or _is_general(claim):
            return False
        texts = [text for field in dataclasses.fields(claim) if isinstance(text := getattr(claim, field.name), str)]  # type: ignore[arg-type]
        return not texts or any(text in str(believed) for text in texts)


def _is_general(claim: Claim[Any]) -> bool:
    """Whether a claim fits every task, or its family has blame with an action."""
    if type(claim) in common.CLAIMS or claim.tried:
        return True
    return any(issubclass(each, ActionClaim) and each.kind is HN for each in claims_of(type(claim).__module__))
