"""A teacher's side of a lesson: which claims there are to say now, saying some of them, and what that costs."""

import math
from collections.abc import Callable, Sequence
from numbers import Integral, Real
from typing import Any

import numpy as np
from gymnasium import spaces

from teachers.atoms import KINDS, SILENCE, Claim, FeedbackType, Moment, Utterance
from teachers.teacher import Teacher
from worlds.spaces import Prose

SUBSETS = 2 ** len(KINDS)
"""Number of subsets of the kinds: bit i of a subset's number is kind i in the order r, hp, hn, fp, fn."""
PROSE = 65_536
"""Greatest length of a teacher's words, and of a world's description."""
FEATURES = ("turn", "reward", "importance", "budget", "over")
"""What the numbers of `TeacherSeat.features` are."""
SUBSET_BITS = np.array([[subset >> i & 1 for i in range(len(KINDS))] for subset in range(SUBSETS)], np.int8)
"""Per subset its members, 0 or 1 a kind, shape (32, 5)."""
LEGAL = np.array([[int(not said & ~true) for said in range(SUBSETS)] for true in range(SUBSETS)], np.int8)
"""Per subset of what is true the subsets that can be said, shape (32, 32); silence always can."""
_BITS, _MASKS = list(SUBSET_BITS), list(LEGAL)  # rows, which a list finds faster
_BIT = {kind: 1 << i for i, kind in enumerate(KINDS)}


def is_count(value: Any, most: float = math.inf) -> bool:
    """Whether a value is an integer, numpy's included, from 1 to `most`."""
    return isinstance(value, Integral) and not isinstance(value, bool) and 1 <= value <= most


def check_cost(name: str, value: Any) -> None:
    """Check what is charged for something.

    Raises:
        ValueError: it is not a finite number of at least 0.
    """
    if isinstance(value, bool) or not isinstance(value, Real) or not 0 <= value < math.inf:
        raise ValueError(f"{name} must be a finite number of at least 0, got {value!r}")


class Purse:
    """What a teacher may still say in an episode, and what saying it costs.

    Args:
        cost: paid per atom of feedback, or per text without atoms, at least 0.
        budget: atoms of feedback that may be said; what exceeds it is not said. None: any number.

    Raises:
        ValueError: an argument is not allowed.
    """

    def __init__(self, cost: float = 0.01, budget: int | None = None) -> None:
        check_cost("cost", cost)
        if budget is not None and not is_count(budget):
            raise ValueError(f"budget must be None or an integer of at least 1, got {budget!r}")
        self.cost, self.budget, self.spent = cost, budget, 0

    @property
    def left(self) -> int:
        """Atoms that can still be said; with no budget, more than there can be in a turn."""
        return SUBSETS if self.budget is None else max(self.budget - self.spent, 0)

    @property
    def share(self) -> float:
        """Share of the budget that is left, 0 to 1; 1 without a budget."""
        return self.left / self.budget if self.budget else 1.0

    def pay(self, atoms: int) -> float:
        """Spend; the teacher's reward for that."""
        self.spent += atoms
        return -self.cost * atoms


class TeacherSeat:
    """One teacher in front of one student.

    Args:
        tutor: the teacher whose oracle sees the truth, and whose claims can be said.
        purse: what it may say; several seats can share one.
        max_cycles: turns of the student in an episode.
        reward_range: least and greatest reward of one turn.
    """

    def __init__(self, tutor: Teacher, purse: Purse, max_cycles: int, reward_range: tuple[float, float]) -> None:
        self.tutor, self.purse, self.max_cycles = tutor, purse, max_cycles
        self.low, self.high = reward_range
        self.moment: Moment
        self._claims: tuple[Claim, ...] | None = None
        self._kinds = -1  # as a subset's number, once it has been asked for

    def see(self, moment: Moment) -> None:
        """Take note of what there is to speak of now."""
        self.moment = moment
        self._claims = None
        self._kinds = -1

    def claims(self) -> tuple[Claim, ...]:
        """The claims of this moment, notices included; asked for once a moment, and only if somebody wants to know."""
        if self._claims is None:
            moment, tutor = self.moment, self.tutor
            said = tutor.judge(moment)
            self._claims = said if moment.before is not None or not moment.turn else tutor.notice(moment) + said
        return self._claims

    def available(self) -> int:
        """The kinds that can be said now, as a subset's number."""
        if self._kinds < 0:
            kinds = 0
            for claim in self.claims():
                if claim.kind is not None:
                    kinds |= _BIT[claim.kind]
            self._kinds = kinds
        return self._kinds if self.purse.budget is None or self.purse.left else 0

    def features(self) -> tuple[float, float, float, float, float]:
        """Turn / max_cycles, the last reward, importance of the next action, share of the budget left, 1 if over."""
        _, _, reward, after, _, turn, over = self.moment
        oracle, purse = self.tutor.oracle, self.purse
        importance, most = oracle.importance(after), oracle.max_importance
        if not self.low <= reward <= self.high:
            reward = self.low if reward < self.low else self.high
        return (
            turn / self.max_cycles,
            reward,
            importance if importance <= most else most,
            1.0 if purse.budget is None else purse.share,
            over,
        )

    def feature_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Least and greatest values of the features, float32 arrays of shape (5,)."""
        low, high = (0, self.low, 0, 0, 0), (1, self.high, self.tutor.oracle.max_importance, 1, 1)
        return np.array(low, np.float32), np.array(high, np.float32)

    def kinds_space(self, **more: spaces.Space) -> spaces.Dict:
        """The space of `observe`, with more entries."""
        return spaces.Dict(
            {
                "available": spaces.MultiBinary(len(KINDS)),
                "features": spaces.Box(*self.feature_bounds()),
                **more,
                "action_mask": spaces.Box(0, 1, (SUBSETS,), np.int8),
            }
        )

    def observe(self, acts: bool) -> dict[str, Any]:
        """What a teacher who chooses kinds sees; `acts`: whether it is its turn, else only silence is legal."""
        available = self.available()
        return {
            "available": _BITS[available].copy(),
            "features": np.array(self.features(), np.float32),
            "action_mask": _MASKS[available if acts else 0].copy(),
        }

    def say(self, subset: Any) -> Utterance:
        """The claims of some kinds in words, as many as the budget allows; notices are always said.

        Raises:
            ValueError: it is no subset's number.
        """
        # Gymnasium's own check takes twenty times as long: it is asked about unusual types only.
        if not (type(subset) is int and 0 <= subset < SUBSETS) and not _DISCRETE.contains(subset):
            raise ValueError(f"the teacher's action must be an integer from 0 to {SUBSETS - 1}, got {subset!r}")
        said: Sequence[Claim] = self.claims()
        if subset & self._kinds != self._kinds:  # or it says all that there is, as it mostly does
            said = [claim for claim in said if claim.kind is None or subset & _BIT[claim.kind]]
        if self.purse.budget is not None:
            said = within(self.purse.left, said, _kind)
        return self.tutor.say(tuple(said), self.moment.turn)

    def allow(self, said: Any) -> str:
        """A message, as much of it as the budget allows.

        Raises:
            ValueError: it is no text, or too long.
        """
        if not isinstance(said, str) or len(said) > PROSE:
            raise ValueError(f"the teacher must say a string of at most {PROSE} characters, got {said!r:.80}")
        if self.purse.budget is None:
            return said
        left = self.purse.left
        if type(said) is Utterance:
            return Utterance.of(within(left, said.atoms, _kind))
        return said if left else SILENCE

    def feedback(self, said: Any) -> str:
        """A message to a student who has the instruction already: what is no feedback at the opening is left out."""
        if type(said) is Utterance and not self.moment.turn:
            said = Utterance.of([atom for atom in said.atoms if atom.kind is not None])
        return self.allow(said)


_DISCRETE = spaces.Discrete(SUBSETS)


def message_space() -> Prose:
    """The space of what a teacher says in its own words."""
    return Prose(PROSE)


def price(said: str) -> int:
    """Atoms of feedback in what is said; 1 for a text without atoms, 0 for silence."""
    atoms = said.atoms if type(said) is Utterance else ()
    return sum(atom.kind is not None for atom in atoms) if atoms else int(said != "")


def within(left: int, items: Sequence[Any], kind: Callable[[Any], FeedbackType | None]) -> list[Any]:
    """The first `left` items that are feedback, and all that are not."""
    kept = []
    for item in items:
        if kind(item) is None or left > 0:
            kept.append(item)
            left -= kind(item) is not None
    return kept


def _kind(item: Any) -> FeedbackType | None:
    return item.kind
