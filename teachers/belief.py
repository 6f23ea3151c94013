"""The belief of a student: worlds that agree with its observations, weighted by the claims that it heard.

It uses the worlds of `teachers.information`. `Claim.means` decides whether a claim holds in a world; a world where it
does not hold weighs less. The belief uses neither unstated rewards nor the context of claims.
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
"""Most draws per requested world."""
_ENOUGH = 0.25  # of the worlds have to count, as many equal weights would, or more are drawn


class Sealed:
    """A moment in the info of a student that draws worlds. Only `Belief.see` reads it."""

    __slots__ = ("_moment",)

    def __init__(self, moment: Moment[Any]) -> None:
        self._moment = moment


class Belief(Information):
    """Worlds that a student cannot distinguish from its own, each weighted by the claims that it has heard.

    In each turn, call `see` with what happened, then `learn` with what was said.

    A world has the weight (1 - trust) ** (n - m): n flat claims do not hold in it, and m is the least n of all drawn
    worlds. So a claim that holds in no drawn world changes nothing. Before it is ignored, more worlds are drawn, up to
    `DRAWS` for each of `worlds`; the same happens if few worlds have weight. If rewards are random, so that hardly any
    two are equal, a stated reward becomes the reward of its turn at any trust above 0, unless no world pays it.

    A hedged claim of probability p multiplies the weight of a world where it does not hold by
    1 - trust + trust * (1 - p) / p; for a flat claim, with p = 1, that is 1 - trust.

    Args:
        context, worlds: as in `Information`; the oracle has values.
        rng: draws the worlds.
        trust: 0 to 1. 0 ignores all claims; with 1, only worlds with the fewest false claims have weight.

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
        """Number of claims that the belief ignores: as many are false in every world with weight."""
        return self._refused + self._conflicts

    def see(self, moment: "Moment[Any] | Sealed") -> None:
        """Note the next turn; the first one becomes the opening."""
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
        """Forget all claims, as if the next turn were the first; the posterior keeps what was seen."""
        self._heard.clear()
        self._rewards.clear()
        self._refused = self._conflicts = 0
        self._since = len(self._moments)

    @property
    def rules(self) -> tuple[Claim[Any], ...]:
        """The claims that it has heard about every world of a town, each once."""
        return tuple(dict.fromkeys(claim for claim, *_ in self._heard if claim.scope is Scope.FAMILY))

    def keep(self, rules: Iterable[Claim[Any]]) -> None:
        """Add claims from an earlier world of the town, as if they were said before the opening."""
        self._heard += [(rule, 0, -1) for rule in rules]

    def learn(self, atoms: Iterable[Atom], read: Sequence[Atom] = ()) -> None:
        """Note what was said, and weigh worlds anew. Atoms about unseen turns are skipped: another student acted there.

        Args:
            atoms: what was said.
            read: the atoms among these that were read from text. They may name things that some worlds lack; a claim
                whose check raises an error in a world is false there.
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
        """The weight of any world, on the scale of the drawn worlds."""
        fewest = min(self._conflicts, false := self._false(world))
        return float((1 - self._trust) ** (false - fewest)) * self._likelihood(world)

    def regrets(self) -> npt.NDArray[np.float64]:
        """Mean regret of each action now, shape (actions,); infinite if the action is best in no world with weight.

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
        """Draw worlds and compute their weights."""
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
        """Draw until enough worlds have weight and one agrees with all claims that were not ignored before."""
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
        """The factor of a world by the hedged claims; 1 if all of them hold."""
        if world.likelihood is None:
            world.likelihood = math.prod(
                self._doubt(claim)
                for claim, about, _ in self._heard
                if isinstance(claim, HedgedClaim) and not self._is_true(claim, about, world)
            )
        return world.likelihood

    def _false(self, world: DrawnWorld, limit: float = math.inf) -> int:
        """Number of flat claims that do not hold in a world; counting stops above `limit`."""
        if world.false is None:
            world.false = 0
            for i, (claim, about, _) in enumerate(self._heard):
                if not (isinstance(claim, HedgedClaim) or self._is_true(claim, about, world)):
                    world.false += 1
                    if world.false > limit:
                        self._heard.insert(0, self._heard.pop(i))  # of the next world it is asked first
                        break
        return world.false
