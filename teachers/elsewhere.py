"""Lessons elsewhere: moments of other worlds of the same kind, and what is true of them."""

from collections import Counter, deque
from collections.abc import Callable, Set
from typing import Any, NamedTuple

import numpy as np

from teachers.atoms import Claim, FeedbackType, Moment
from teachers.oracle import Oracle

__all__ = ["Elsewhere", "MomentElsewhere"]

_TURNS = 10  # of a lesson, at most
_KEPT = 10  # moments
_RARE = 3  # moments for each kind
_PLANNED = 0.5  # share of optimal actions, so that there is something to praise and something to blame
_SEEDS = 2**31


class MomentElsewhere(NamedTuple):
    """A moment elsewhere, and what is true of it."""

    moment: Moment[Any]
    claims: tuple[Claim[Any], ...]
    kinds: Counter[FeedbackType | None]
    """The number of claims of each kind."""
    words: tuple[float, ...]
    """The mean number of words of each claim's paraphrases."""


class Elsewhere:
    """Lessons in other worlds of the taught world's class and options, moment by moment.

    The worlds are drawn by a seed, and their student takes an action of the plan or a random one. Nothing of the
    taught episode has an influence on them.

    Args:
        oracle: of the taught world; a twin of it judges the other worlds.
        kinds: the kinds of claims to make.
        words: counts the words of a claim.
        rng: draws worlds and actions.
        clues: whether the claims include the oracle's clues.
    """

    def __init__(
        self,
        oracle: Oracle[Any, Any],
        kinds: Set[FeedbackType],
        words: Callable[[Claim[Any]], float],
        rng: np.random.Generator,
        *,
        clues: bool = False,
    ) -> None:
        self._oracle, self._kinds, self._words, self._rng = oracle.twin(), kinds, words, rng
        self.clues = clues
        """Whether the claims include the oracle's clues."""
        self.moments: deque[MomentElsewhere] = deque(maxlen=_KEPT)
        """The last moments, the latest last."""
        self.reserve: dict[FeedbackType | None, deque[MomentElsewhere]] = {}
        """For each kind the last moments with most of its claims; they stay when `moments` are used up."""
        self._moment: Moment[Any] | None = None

    def go_on(self) -> None:
        """Add a moment: of another world if the last one is solved or has lasted for some turns."""
        oracle, moment = self._oracle, self._moment
        if moment is None or moment.success or moment.turn >= _TURNS:
            moment = self._opening()
        else:
            moment = oracle.try_out(moment, self._action(moment))
        self._moment = moment
        claims = oracle.judge(moment, self._kinds)
        if self.clues:
            claims += tuple(clue for clue in oracle.clues(moment.after) if clue.kind in self._kinds)
        kinds = Counter(claim.kind for claim in claims)
        said = MomentElsewhere(moment, claims, kinds, tuple(map(self._words, claims)))
        self.moments.append(said)
        for kind, number in kinds.items():
            kept = self.reserve.setdefault(kind, deque(maxlen=_RARE))
            if not kept or number >= kept[-1].kinds[kind]:
                kept.append(said)

    def _opening(self) -> Moment[Any]:
        truth = self._oracle.lab.elsewhere(int(self._rng.integers(_SEEDS)))
        self._oracle.start(truth)
        return Moment.opening(truth)

    def _action(self, moment: Moment[Any]) -> Any:
        plan = self._oracle.plan(moment.after, 1) if self._rng.random() < _PLANNED else ()
        if plan:
            return plan[0]
        lab = self._oracle.lab
        lab.restore(moment.after)
        return lab.sample_action(self._rng)
