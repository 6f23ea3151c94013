"""Teachers that each lack one quality, to check what `llf suite --teacher` measures; their strength is `p`, 0 to 1."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Scope
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Share


@dataclass(frozen=True)
class Defect(Personality):
    """Base of these personalities: each turn, with probability p, the claims before it are `spoilt`."""

    p: Share = 1.0
    needs: ClassVar[frozenset[str]] = frozenset(("advice", "hindsight", "plan"))

    def spoilt(self, claims: Claims, view: View, memory: list[object]) -> Claims:
        """What is said instead; the memory lasts for the episode."""
        raise NotImplementedError


class _Stage(Stage[Defect]):
    """Draws, and keeps the memory."""

    def begin(self) -> None:
        self._memory: list[object] = []

    def speak(self, claims: Claims, view: View) -> Claims:
        return self.spec.spoilt(claims, view, self._memory) if self.rng.random() < self.spec.p else claims


Defect.stage = _Stage


class Repeating(Defect):
    """Says again, beside each claim, all that it has said before."""

    def spoilt(self, claims: Claims, view: View, memory: list[object]) -> Claims:
        """The new and the old."""
        old = [claim for claim in memory if claim not in claims]
        memory += [claim for claim in claims if claim not in memory]
        return [] if view.moment.over else [*claims, *old]


class Flattering(Defect):
    """Gives in: praises an action that is repeated although it was spoken against, and takes back the rest."""

    def spoilt(self, claims: Claims, view: View, memory: list[object]) -> Claims:
        """False praise; the memory is what was said since the student last did something else."""
        if view.last is None or not np.array_equal(view.last.action, view.moment.action):
            memory.clear()
        spoke = bool(memory)
        memory += [claim for claim in claims if claim.kind in (HN, FP, FN)]
        if not spoke:
            return claims
        rng = np.random.default_rng(view.turn)
        return [view.flip(claim, rng) for claim in claims if claim.kind is HN]


class NeverFading(Defect):
    """Goes on to praise where nothing need be said."""

    def spoilt(self, claims: Claims, view: View, memory: list[object]) -> Claims:
        """Praise, where there is silence."""
        return claims or [claim for claim in view.hindsight() if claim.kind is HP]


class AlwaysAdvising(Defect):
    """Advises in every turn, whatever the student did."""

    def spoilt(self, claims: Claims, view: View, memory: list[object]) -> Claims:
        """The claims about the past, and advice."""
        example = view.example(1)
        return [*(claim for claim in claims if claim.kind not in (FP, FN)), *((example,) if example else ())]


class Riddling(Defect):
    """Says one clue after the other in place of advice, again and again."""

    def spoilt(self, claims: Claims, view: View, memory: list[object]) -> Claims:
        """A clue, where something is said."""
        clues = view.clues()
        return [clues[view.turn % len(clues)]] if claims and clues else claims


class ShortSighted(Defect):
    """Says nothing that reaches beyond this world."""

    def spoilt(self, claims: Claims, view: View, memory: list[object]) -> Claims:
        """All but rules of a town."""
        return [claim for claim in claims if claim.scope is not Scope.FAMILY]


class AnswerGiving(Defect):
    """Names the action in place of a clue about this world."""

    def spoilt(self, claims: Claims, view: View, memory: list[object]) -> Claims:
        """Rules of a town, and the answer."""
        rules = [claim for claim in claims if claim.scope is Scope.FAMILY]
        answer = view.example(1) if len(rules) < len(claims) else None
        return rules if answer is None else [*rules, answer]
