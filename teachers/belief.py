"""What a student believes that can only see and hear: worlds that agree with what it saw, weighed by what was said.

The worlds are those by which `teachers.information` measures claims. A claim is taken as it is said, by `Claim.means`,
and a world in which it does not hold counts less. Nothing else is believed: neither rewards that were not said nor the
ground of a claim.
"""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from teachers.atoms import Atom, Claim, HedgedClaim, Moment, Scope
from teachers.common import Reward
from teachers.information import DrawnWorld, Information, PosteriorContext
from teachers.spec import check_range
from worlds.posteriors import NoWorldError

__all__ = ["DRAWS", "Belief", "Sealed"]

DRAWS = 8
"""Draws for each of the worlds that are asked for, at most."""
_ENOUGH = 0.25  # of the worlds have to count, as many equal weights would, or more are drawn


class Sealed:
    """A moment in the info of a student that draws worlds. Only `Belief.see` opens it, which draws from it."""

    __slots__ = ("_moment",)

    def __init__(self, moment: Moment[Any]) -> None:
        self._moment = moment


class Belief(Information):
    """Worlds that a student cannot distinguish from its own, each weighed by the claims that it has heard.

    In each turn, `see` what happened, then `learn` what was said.

    A world has the weight (1 - trust) ** n, where n claims do not hold in it and the fewest that do not hold in any
    drawn world are not counted. So a claim that holds in none of them changes nothing. Before it is ignored, more
    worlds are drawn, up to `DRAWS` for each of `worlds`; so are they where only few of them count. In worlds of
    chance, where hardly any two rewards are equal, a reward that is said is taken for that of the turn, at any trust
    above 0, unless no world pays it.

    Hedged claims are not among these n. Each has a factor: where a claim of probability p does not hold, a world counts
    1 - trust + trust * (1 - p) / p as much as where it does; for a flat claim, with p = 1, that would be 1 - trust.

    Args:
        context, worlds: as of `Information`; the oracle has values.
        rng: draws the worlds.
        trust: 0 to 1; 0: nothing that is said counts, 1: no world counts in which more is false than in others.

    Raises:
        ValueError: an argument is not allowed.
    """

    def __init__(
        self, context: PosteriorContext, rng: np.random.Generator, worlds: int | None = None, trust: float = 1.0
    ) -> None:
        super().__init__(context, rng, worlds)
        check_range("trust", trust, 0, 1)
        self._trust = trust
        self._first = 0  # the turn that was seen first
        self._since = 0  # the turn before which it last forgot what was said
        self._last: Moment[Any] | None = None
        self._read: set[Claim[Any]] = set()  # what was read in words of others
        self._refused = 0  # rewards that no world pays
        self._conflicts = 0  # claims, at least, that do not hold in a world
        self._weights: npt.NDArray[np.float64] = np.ones(0)

    @property
    def ignored(self) -> int:
        """Number of claims that are ignored now: as many do not hold in any world that counts."""
        return self._refused + self._conflicts

    def see(self, moment: "Moment[Any] | Sealed") -> None:
        """What has happened in the next turn; the first that is seen is taken for the opening."""
        moment = moment._moment if isinstance(moment, Sealed) else moment
        if moment == self._last:
            return  # it has asked, and hears more
        self._last = moment
        turn = moment.turn - self._first
        if not self._moments or turn <= 0:
            self._first, turn = moment.turn, 0
            moment = Moment.opening(moment.after)._replace(ask_cost=moment.ask_cost)
        self._since = min(self._since, turn)
        super().see(moment._replace(reward=0.0, success=False, turn=turn))  # it has not heard these

    def forget(self) -> None:
        """Forget all that was said, as if the next turn were the first; what was seen is part of the posterior."""
        self._heard.clear()
        self._rewards.clear()
        self._refused = self._conflicts = 0
        self._since = len(self._moments)

    @property
    def rules(self) -> tuple[Claim[Any], ...]:
        """The claims that it has heard about every world of a town, each once."""
        return tuple(dict.fromkeys(claim for claim, *_ in self._heard if claim.scope is Scope.FAMILY))

    def keep(self, rules: Iterable[Claim[Any]]) -> None:
        """Count claims that were heard in an earlier world of the town, as if they were said before the opening."""
        self._heard += [(rule, 0, -1) for rule in rules]

    def learn(self, atoms: Iterable[Atom], read: Sequence[Atom] = ()) -> None:
        """What was said, each of a turn that was seen; others are of another student's actions. Weigh worlds anew.

        Args:
            atoms: with their claims.
            read: those of them that were read in words of others. What they name need not be there in every world, and
                where they cannot be checked they are false.
        """
        now = len(self._moments) - 1
        self._read.update(atom.claim for atom in read)
        for claim, _, about, _ in atoms:
            about += self._since
            if not self._since <= about <= now or not self._trust:
                continue
            if isinstance(claim, Reward) and self._posterior.chancy:
                self._turns[about] = self._turns[about]._replace(reward=claim.reward)
                self._rewards[about] = now
            else:
                self._heard.append((claim, about, now))
        self._weigh()

    def weight(self, world: DrawnWorld) -> float:
        """The weight of a world beside those that were drawn."""
        fewest = min(self._conflicts, false := self._false(world))
        return float((1 - self._trust) ** (false - fewest)) * self._likelihood(world)

    def regrets(self) -> npt.NDArray[np.float64]:
        """What each action loses now in the mean, shape (actions,); infinite if it is best in no world that counts.

        An action that is best nowhere may lose least in the mean, such as to stay between two goals, and teach nothing.
        """
        counted = np.flatnonzero(self._weights)
        lost = np.array([self._regrets_in(self._pool[i]) for i in counted])
        means: npt.NDArray[np.float64] = np.average(lost, axis=0, weights=self._weights[counted])
        return np.where((lost <= 1e-9).any(axis=0), means, np.inf)

    def _is_true(self, claim: Claim, about: int, world: DrawnWorld) -> bool:
        try:
            return super()._is_true(claim, about, world)
        except Exception:
            if claim not in self._read:
                raise
            return False

    def _weigh(self) -> None:
        """Draw worlds, and weigh them."""
        while True:
            self._begin()
            self._left = DRAWS * self._worlds
            try:
                self._draw()
                break
            except NoWorldError:
                if not self._rewards:
                    raise
                self._rewards.popitem()  # the last that was said
                self._refused += 1
        self.rest()

    def _draw(self) -> None:
        """Draw until enough worlds count and some world agrees with all claims that were not ignored before."""
        known: dict[int, DrawnWorld] = {}  # the same draw is the same world
        false: list[int] = []
        while self._left:
            for _ in range(self._worlds):
                draw = self._next()
                world = known.get(id(draw)) or known.setdefault(id(draw), DrawnWorld(draw, self._moments))
                self._pool.append(world)
                # With full trust, a world in which more is false than in another does not count.
                false.append(self._false(world, min(false) if false and self._trust == 1 else math.inf))
            self._left -= self._worlds
            conflicts = np.array(false) - min(false)
            self._weights = np.power(1 - self._trust, conflicts.astype(float))
            if any(isinstance(claim, HedgedClaim) for claim, *_ in self._heard):
                counts = self._weights > 0
                self._weights[counts] *= [
                    self._likelihood(world) for world, counted in zip(self._pool, counts, strict=True) if counted
                ]
            counted = self._weights.sum() ** 2 / (self._weights**2).sum()
            if min(false) <= self._conflicts and counted >= _ENOUGH * self._worlds:
                break
        self._conflicts = min(false)

    def _likelihood(self, world: DrawnWorld) -> float:
        """How much a world counts by the hedged claims, beside those in which all of these hold."""
        if world.likelihood is None:
            world.likelihood = math.prod(
                self._doubt(claim)
                for claim, about, _ in self._heard
                if isinstance(claim, HedgedClaim) and not self._is_true(claim, about, world)
            )
        return world.likelihood

    def _false(self, world: DrawnWorld, limit: float = math.inf) -> int:
        """Number of flat claims that do not hold in a world; of more than `limit`, as many as are found."""
        if world.false is None:
            world.false = 0
            for i, (claim, about, _) in enumerate(self._heard):
                if not (isinstance(claim, HedgedClaim) or self._is_true(claim, about, world)):
                    world.false += 1
                    if world.false > limit:
                        self._heard.insert(0, self._heard.pop(i))  # of the next world it is asked first
                        break
        return world.false
