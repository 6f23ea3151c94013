"""skip(eps): is silent when neither of the student's last two actions was good."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from teachers.batches import Kinds, Moments, StageBatch
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Share
from worlds.batches import Floats, Ints, chosen, most


class _Worth(Stage["Skip"]):
    """Keeps the running mean of what was at stake, and the worth of the last action."""

    def begin(self) -> None:
        self.turns, self.total, self.worth = 0, 0.0, 0.0

    def speak(self, claims: Claims, view: View) -> Claims:
        values = view.past_values()
        if values is None:
            return claims
        self.turns, self.total = self.turns + 1, self.total + max(values) - min(values)
        earlier, self.worth = self.worth, values[view.moment.action] - min(values)
        margin = self.spec.eps * self.total / self.turns * _BELOW
        return () if max(earlier, self.worth) < margin else claims


class _Acted(NamedTuple):
    turns: Ints
    total: Floats
    worth: Floats


class _WorthBatch(StageBatch["Skip"]):
    """`_Worth` in arrays."""

    def blank(self, rows: int) -> _Acted:
        return _Acted(np.zeros(rows, np.int64), np.zeros(rows), np.zeros(rows))

    def speak(self, kinds: Kinds, memory: _Acted, moments: Moments[Any]) -> tuple[Kinds, _Acted]:
        acted = moments.turn > 0
        values = self.oracle.values(moments.before)
        turns = memory.turns + acted
        total = np.where(acted, memory.total + most(values) + most(-values), 0.0)
        worth = np.where(acted, chosen(values, moments.action) + most(-values), 0.0)
        margin = self.spec.eps * total / np.maximum(turns, 1) * _BELOW
        return kinds * ~(np.maximum(memory.worth, worth) < margin), _Acted(turns, total, worth)


@dataclass(frozen=True)
class Skip(Personality):
    """Says nothing if the last two actions both were worth less than eps times the running mean of what was at stake.

    The worth of an action is its value minus that of the worst action. The source skips a comparison if neither of
    its two options is good; here these are the student's last two actions, of which the first turn has one.
    """

    eps: Share = 0.1
    """Share of the scale below which an action is not good, 0 to 1."""

    source = "B-Pref eps_skip"
    needs = frozenset(("values",))
    stage, batch = _Worth, _WorthBatch


_BELOW = 1 - 1e-9  # equal within rounding is not below
