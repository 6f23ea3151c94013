"""Traits that each take one ability away, to check what `llf suite` measures; their strength is `p`, from 0 to 1."""

from dataclasses import dataclass
from functools import cache
from typing import Any

from llf_teacher.students.scene import Scene
from llf_teacher.students.trait import Trait
from pz_envs.family import all_families
from teachers.atoms import FN, FP, Atom, Claim, PlanClaim, Scope, action_of
from teachers.phrasebook import Phrasebook
from teachers.spec import Share


@dataclass(frozen=True)
class Defect(Trait):
    """Base of these traits: with probability p nothing is heard where it `lacks` an ability."""

    p: Share = 1.0
    strength = "p"

    def hear(self, atom: Atom, scene: Scene) -> Claim[Any] | None:
        """The claim, or nothing."""
        return None if self.lacks(atom, scene) and scene.happens(self.p) else atom.claim

    def lacks(self, atom: Atom, scene: Scene) -> bool:
        """Whether what is said needs the ability."""
        raise NotImplementedError


class MissesHints(Defect):
    """Does not hear advice and warnings that name no action."""

    def lacks(self, atom: Atom, scene: Scene) -> bool:
        """Whether it is a hint."""
        names = action_of(atom.claim) is not None or isinstance(atom.claim, PlanClaim)
        lasts = atom.claim.scope is Scope.FAMILY
        return atom.kind in (FP, FN) and not (atom.claim.placebo or names or lasts)


class MissesRules(Defect):
    """Does not hear rules of a town."""

    def lacks(self, atom: Atom, scene: Scene) -> bool:
        """Whether it is one."""
        return atom.claim.scope is Scope.FAMILY


class MissesTone(Defect):
    """Does not hear sentences that are not those of the plain voice."""

    def lacks(self, atom: Atom, scene: Scene) -> bool:
        """Whether no plain sentence of the claim is in the text."""
        return atom.kind is not None and not any(
            each in atom.text for each in _plain(type(scene.world)).sentences(atom.claim)
        )


class ForgetsInSilence(Defect):
    """Forgets in the turn after one in which no feedback was given."""

    def hear(self, atom: Atom, scene: Scene) -> Claim[Any] | None:
        """The claim; that feedback was given is kept."""
        if atom.kind is not None:
            scene.memory["said"] = scene.turn
        return atom.claim

    def forgets(self, scene: Scene) -> bool:
        """Whether it does."""
        return scene.memory.get("said", -1) < scene.turn - 1 and scene.happens(self.p)


class ForgetsLessons(Defect):
    """Knows nothing of earlier episodes: acts at random until the first feedback of this one."""

    def hear(self, atom: Atom, scene: Scene) -> Claim[Any] | None:
        """The claim; that feedback was given is kept."""
        scene.memory["taught"] = scene.memory.get("taught", False) or atom.kind is not None
        return atom.claim

    def act(self, action: Any, scene: Scene) -> Any:
        """The action, or a random one."""
        lost = not scene.memory.get("taught") and scene.happens(self.p)
        return scene.as_given(scene.world.sample_action(scene.rng)) if lost else action


class Distracted(Defect):
    """Acts at random in a turn in which a truism was said."""

    def hear(self, atom: Atom, scene: Scene) -> Claim[Any] | None:
        """The claim; a truism is kept in mind."""
        if atom.claim.placebo:
            scene.memory["truism"] = scene.turn
        return atom.claim

    def act(self, action: Any, scene: Scene) -> Any:
        """The action, or a random one."""
        distracted = scene.memory.get("truism") == scene.turn and scene.happens(self.p)
        return scene.as_given(scene.world.sample_action(scene.rng)) if distracted else action


@cache
def _plain(world: type) -> Phrasebook:
    """The plain phrases of the family of a world, whose module or package has its name."""
    names = world.__module__.split(".")
    return next(each.phrasebook() for each in all_families() if each.name in names)
