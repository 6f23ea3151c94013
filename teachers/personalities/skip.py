"""skip(eps): is silent when neither of the student's last two actions was good."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from teachers.batches import Kinds, Moments, OracleBatch
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Share
from worlds.batches import Bools, Floats, chosen, most


class _Worth(Stage["Skip"]):
    """Keeps the running mean of what was at stake, and the worth of the last action."""

    def begin(self) -> None:
        self._turns, self._total, self._worth = 0, 0.0, 0.0

    def speak(self, claims: Claims, view: View) -> Claims:
        values = view.past_values()
        if values is None:
            return claims
        self._turns, self._total = self._turns + 1, self._total + max(values) - min(values)
        earlier, self._worth = self._worth, values[view.moment.action] - min(values)
        margin = self.spec.eps * self._total / self._turns * _BELOW
        return () if max(earlier, self._worth) < margin else claims


@dataclass(frozen=True)
class Skip(Personality):
    """Says nothing if the last two actions both were worth less than eps times the running mean of what was at stake.

    The worth of an action is its value minus that of the worst action. The source skips a comparison if neither of its
    two options is good; here the options are the student's last two actions, or its only one in the first turn.
    """

    eps: Share = 0.1
    """Share of the scale below which an action is not good, 0 to 1."""

    source = "B-Pref eps_skip"
    needs = frozenset(("values",))
    stage = _Worth
    row_memory = 3

    def speak_rows(self, kinds: Kinds, memory: Floats, moments: Moments[Any], oracle: OracleBatch[Any]) -> Kinds:
        """`_Worth.speak` in arrays."""
        acted, values = moments.turn > 0, oracle.values(moments.before)
        turns, total, earlier = memory.T.copy()
        turns, total = turns + 1, total + most(values) + most(-values)
        worth = chosen(values, moments.action) + most(-values)
        memory[acted] = np.column_stack((turns, total, worth))[acted]
        silent: Bools = acted & (np.maximum(earlier, worth) < self.eps * total / turns * _BELOW)
        return kinds * ~silent


_BELOW = 1 - 1e-9  # equal within rounding is not below
