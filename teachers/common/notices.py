"""Parts of instructions that belong to no family, and notices of the environment."""

from typing import Any

import numpy as np

from teachers.atoms import Claim, Moment, Scope, claim
from worlds.world import World

_TRIES = 5


@claim
class NotUnderstood(Claim[Any]):
    """True if the student's text was no action, and `expected` is what the world understands; `why` says what is wrong.

    A notice of the environment, not feedback of the teacher: no personality and no feedback type withholds it.
    """

    scope = Scope.ACTION
    got: str
    expected: str
    why: str

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Compare with the turn's parse failure."""
        return moment.action == (self.got, self.expected, self.why) and self.expected == lab.action_syntax


@claim
class MayAsk(Claim[Any]):
    """True if the student may ask for advice in place of acting, once a turn, and pays `cost` for it."""

    scope = Scope.STATE  # that is the only moment with the price
    cost: float

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Compare with the price in the opening moment."""
        return moment.ask_cost == self.cost


@claim
class Maximize(Claim[Any]):
    """True of every world, if nothing but its rewards counts: how reinforcement learning is put as an instruction."""

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Always."""
        return True


@claim
class Syntax(Claim[Any]):
    """True if `expected` is what the world understands as an action."""

    expected: str

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Compare with the world's syntax; the world must accept its own random actions, and refuse `...`."""
        lab.restore(moment.after)
        rng = np.random.default_rng(moment.turn)
        drawn = [lab.sample_action(rng) for _ in range(_TRIES)]
        return self.expected == lab.action_syntax and all(_is_legal(a, lab) for a in drawn) and not _is_legal(..., lab)


def _is_legal(action: Any, lab: World[Any]) -> bool:
    try:
        lab.legal(action)
    except ValueError:
        return False
    return True
