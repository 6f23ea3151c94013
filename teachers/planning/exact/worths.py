"""Values of the states of a small Markov decision process."""

from collections.abc import Callable, Hashable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import sparse

from teachers.planning.transitions import Transitions

_Floats = npt.NDArray[np.float64]

_CLOSE = 1e-12  # of discounted values, relative to what is still to come
_EQUAL = 1e-9  # of the greatest reward: sums that differ by less are equal
_SILENT = 1e-3  # of the greatest difference between actions
_NOTED = 0.05  # actions sooner or later that are worth a word
_SOONER = 1e-6  # actions: lengths that differ by less are equal


class Worth(NamedTuple):
    """The expected result of an action, if best actions follow."""

    earned: float
    """The sum of rewards."""
    length: float
    """The number of actions until the episode is over, this one included; 0 with a discount."""


NOTHING = Worth(0.0, 0.0)
Lost = tuple[tuple[float, float] | None, ...]
"""The `Worth` that each action loses, as plain tuples; None for losses too small to mention."""


class Worths:
    """The value of each action in each state: the greatest sum of rewards, and the fewest actions for it.

    Computed by backward induction over the actions that are left or, with a discount, by value iteration until nothing
    changes (Puterman 1994, Markov Decision Processes, sections 4.5 and 6.3).

    Args:
        transitions: the environment's transitions; each state has the same number of actions.
        horizon: most actions of an episode; the sum counts no reward after these. None with `gamma`.
        gamma: discount for each action, below 1, without a horizon. None: rewards count alike.
        fading: the factor of a reward after so many actions, for environments that pay less with time; only with a
            horizon. None: 1.
    """

    def __init__(
        self,
        transitions: Transitions,
        horizon: int | None,
        gamma: float | None = None,
        fading: Callable[[int], float] | None = None,
    ) -> None:
        self.transitions, self.horizon, self.gamma, self._fading = transitions, horizon, gamma, fading
        self._index = {state: i for i, state in enumerate(transitions)}
        self.actions = len(next(iter(transitions.values())))
        """Number of actions."""
        moves, paid = self._arrays()
        self._equal = _EQUAL * max(1e-300, float(np.abs(paid).max()))
        self._earned, self._lengths = self._solve(moves, paid)
        self._last = len(self._earned) - 1
        self.spread = float(max((earned.max(axis=1) - earned.min(axis=1)).max() for earned in self._earned))
        """The greatest difference between the sums of two actions in any state."""
        self.margin = _SILENT * self.spread
        """The smallest difference of sums that claims mention."""
        self.price = 0.0 if horizon is None else (self.margin or 1.0) / (2 * horizon)
        """The price of an action in `ranked`, so that time breaks ties."""
        self._listed: dict[tuple[int, int], tuple[Worth, ...]] = {}

    def _arrays(self) -> tuple[list[Any], _Floats]:
        """The probabilities of next states by action, and the expected rewards by state and action."""
        count = len(self._index)
        paid = np.zeros((count, self.actions))
        moves = []
        for action in range(self.actions):
            rows, columns, chances = [], [], []
            for state, row in self._index.items():
                for chance, after, reward in self.transitions[state][action]:
                    paid[row, action] += chance * reward
                    if after is not None:
                        rows.append(row)
                        columns.append(self._index[after])
                        chances.append(chance)
            moves.append(sparse.csr_array((chances, (rows, columns)), shape=(count, count)))
        return moves, paid

    def _solve(self, moves: list[Any], paid: _Floats) -> tuple[list[_Floats], list[_Floats]]:
        """Sums and lengths with one action left, two, and so on, until they no longer change."""
        if self.gamma is not None:
            return [self._discounted(moves, paid, self.gamma)], [np.zeros_like(paid)]
        sums: list[_Floats] = []
        lengths: list[_Floats] = []
        best, fewest = np.zeros(len(paid)), np.zeros(len(paid))
        for turn in range(self.horizon - 1, -1, -1):  # type: ignore[operator]  # without a discount there is one
            earned = self.share(turn) * paid + np.stack([move @ best for move in moves], axis=1)
            length = 1.0 + np.stack([move @ fewest for move in moves], axis=1)
            if sums and self._fading is None and (earned == sums[-1]).all() and (length == lengths[-1]).all():
                break
            sums.append(earned)
            lengths.append(length)
            best = earned.max(axis=1)
            fewest = np.where(earned >= best[:, None] - self._equal, length, np.inf).min(axis=1)
        return sums, lengths

    def _discounted(self, moves: list[Any], paid: _Floats, gamma: float) -> _Floats:
        earned = paid
        while True:
            best = earned.max(axis=1)
            new = paid + gamma * np.stack([move @ best for move in moves], axis=1)
            change, earned = np.abs(new - earned).max(), new
            if change <= _CLOSE * (1 - gamma) * max(1.0, np.abs(new).max()):
                return earned

    @property
    def fades(self) -> bool:
        """Whether the environment pays less with each action."""
        return self._fading is not None

    def share(self, turn: int) -> float:
        """The factor of a reward after so many actions."""
        return 1.0 if self._fading is None else self._fading(turn)

    def worths(self, state: Hashable, turn: int) -> tuple[Worth, ...]:
        """The value of each action in a state after `turn` actions; zeros if no action is left or none is known."""
        at = self.stage(turn)
        if at < 0 or state not in self._index:
            return (Worth(0.0, 0.0),) * self.actions
        key = at, self._index[state]
        if key not in self._listed:
            self._listed[key] = tuple(map(Worth, *self._row(*key)))
        return self._listed[key]

    def _row(self, at: int, row: int) -> tuple[list[float], list[float]]:
        """The sums of rewards and the lengths of a state's actions."""
        return self._earned[at][row].tolist(), self._lengths[at][row].tolist()

    def stage(self, turn: int) -> int:
        """The index of the worths after so many actions; -1 if no action is left."""
        last = self._last
        if self.horizon is None or self.horizon - turn > last:
            return last
        return max(self.horizon - turn, 0) - 1

    def compared(self, state: Hashable, turn: int) -> tuple[Lost, list[float]]:
        """`all_lost` and `ranked` of a state, without making its `worths`: most turns need no more."""
        at = self.stage(turn)
        if at < 0 or state not in self._index:
            return ((0.0, 0.0),) * self.actions, [0.0] * self.actions
        sums, lengths = self._row(at, self._index[state])
        most = max(sums)
        pairs = list(zip(sums, lengths, strict=True))
        fewest = min([length for earned, length in pairs if earned >= most - self._equal])
        return (
            tuple([self._lost(most - earned, length - fewest) for earned, length in pairs]),
            [earned - self.price * length for earned, length in pairs],
        )

    def expected(self, state: Hashable, turn: int) -> tuple[Worth, ...]:
        """`worths` by Bellman's equation for this one state, from the values of the next states."""
        if self.stage(turn) < 0 or state not in self._index:
            return (Worth(0.0, 0.0),) * self.actions
        share, discount, found = self.share(turn), 1.0 if self.gamma is None else self.gamma, []
        for transitions in self.transitions[state]:
            earned, length = 0.0, 0.0 if self.horizon is None else 1.0
            for chance, after, reward in transitions:
                then = Worth(0.0, 0.0) if after is None else self.best(self.worths(after, turn + 1))
                earned += chance * (share * reward + discount * then.earned)
                length += chance * then.length
            found.append(Worth(earned, length))
        return tuple(found)

    def best(self, worths: tuple[Worth, ...]) -> Worth:
        """The greatest sum, with the fewest actions that earn it."""
        most = max(worths).earned
        least = most - self._equal
        return Worth(most, min([length for earned, length in worths if earned >= least]))

    def equals(self, one: float, other: float) -> bool:
        """Whether two sums differ by rounding only."""
        return bool(abs(one - other) <= self._equal)

    def ranked(self, worths: tuple[Worth, ...]) -> tuple[float, ...]:
        """One number for each action: its sum minus a small price of time that breaks ties."""
        price = self.price
        return tuple([earned - price * length for earned, length in worths])

    def exactly(self, worths: tuple[Worth, ...]) -> tuple[tuple[bool, float], ...]:
        """A rank for each action: by its sum, and among equal sums by its length, the shortest first."""
        best = self.best(worths)
        return tuple((self.equals(worth.earned, best.earned), -worth.length) for worth in worths)

    def _lost(self, earned: float, later: float) -> tuple[float, float] | None:
        if earned > self._equal:
            return (earned, 0.0) if earned > self.margin else None
        if later > _SOONER:
            return (0.0, later) if later > _NOTED else None
        return (0.0, 0.0)

    def all_lost(self, worths: tuple[Worth, ...]) -> list[Worth | None]:
        """How much less than the best each action earns, or how much later it earns as much; zeros for a best action.

        None for an action that is not best but loses too little to mention.
        """
        best = self.best(worths)
        lost = [self._lost(best.earned - earned, length - best.length) for earned, length in worths]
        return [None if each is None else Worth(*each) for each in lost]

    @property
    def certain(self) -> bool:
        """Whether all transitions are deterministic."""
        return all(len(transitions) <= 1 for row in self.transitions.values() for transitions in row)
