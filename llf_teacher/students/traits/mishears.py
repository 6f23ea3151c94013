"""mishears(p): hears a wrong claim."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from llf_teacher.students.scene import (
    BareSentence,
    HeardBatch,
    Scene,
    SceneBatch,
    changed,
)
from llf_teacher.students.trait import Trait
from teachers.atoms import FN, FP, HN, HP, ActionClaim, Atom, Claim, EditClaim, PlanClaim, R, Verdict
from teachers.common import Right, Wrong
from teachers.feedback import BIT
from teachers.spec import Share


@dataclass(frozen=True)
class Mishears(Trait):
    """With probability p mishears a claim of feedback.

    It hears praise as the blame that is its opposite, and blame as praise, without a reason where the claim has no
    opposite; advice or a warning with another action, drawn at random; an example with another first action. It misses
    any other claim, such as a reward or a verdict without an action, and a sentence of a person or a model that carries
    no claim. Instructions are read, and are not misheard. The wrong claim is worded in plain words, so that atoms and
    text agree.
    """

    p: Share = 0.1
    """The probability, independent for each claim, 0 to 1; 0: never."""
    strength = "p"

    def hear(self, atom: Atom, scene: Scene) -> Claim[Any] | None:
        """The claim, or the misheard one."""
        claim = atom.claim
        if (atom.kind is None and not isinstance(claim, BareSentence)) or claim.tried or not scene.happens(self.p):
            return claim
        if isinstance(claim, Verdict):
            return claim.opposing()
        if isinstance(claim, PlanClaim):
            first = scene.another(claim.actions[0])
            return None if first is None else changed(claim, actions=(first, *claim.actions[1:]))
        if isinstance(claim, ActionClaim) and claim.action_slot and not isinstance(claim, EditClaim):
            if claim.kind in (HP, HN):
                return (Wrong if claim.kind is HP else Right)(action=claim.action)
            other = scene.another(claim.action)
            return None if other is None else changed(claim, action=other)
        return None

    def hear_rows(self, heard: HeardBatch, scene: SceneBatch) -> HeardBatch:
        """`hear` in arrays, for claims about actions and rewards."""
        kinds = heard.kinds
        kinds = kinds - BIT[R] * scene.happens(self.p, heard.kinds & BIT[R] > 0)
        for kind, opposite in ((HP, HN), (HN, HP)):
            kinds = kinds + (BIT[opposite] - BIT[kind]) * scene.happens(self.p, heard.kinds & BIT[kind] > 0)
        named = []
        for kind, action in ((FP, heard.advised), (FN, heard.warned)):
            wrong = scene.happens(self.p, heard.kinds & BIT[kind] > 0)
            other = scene.another(action, wrong)
            kinds = kinds - BIT[kind] * (wrong & (other < 0))
            named.append(np.where(wrong, other, action))
        return HeardBatch(kinds, *named)
