"""Posteriors: the worlds that agree with all that a student has seen, one module per family.

A posterior draws worlds with their probability under the family's own generator, given the play so far. A student knows
the generator, the observations, its own actions, and the rewards that the teacher said.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import islice
from types import MappingProxyType
from typing import Any, ClassVar, Generic

import numpy as np
from typing_extensions import TypeVar

from worlds.world import TruthT, World, WorldTurn, plain

__all__ = ["Draw", "NoWorldError", "Posterior", "WorldT", "random_walk", "seen"]

WorldT = TypeVar("WorldT", bound=World[Any], default=Any)
"""The class of the world."""
Draw = tuple[WorldTurn[TruthT], ...]
"""The student's turns in a world, the opening first."""


class NoWorldError(ValueError):
    """No world, or too few worlds, agree with what a student saw."""


class Posterior(ABC, Generic[TruthT, WorldT]):
    """Draws the worlds of a family that a student cannot distinguish from its own.

    Args:
        lab: a scratch world with the options of the episode's world; the posterior may restore and step it.

    Raises:
        ValueError: worlds with these options have no posterior; the message gives the reason.
    """

    needs: ClassVar[Mapping[str, Any]] = MappingProxyType({})
    """Options that a world needs to have a posterior, beside the defaults."""
    exact: ClassVar[bool] = True
    """Whether every truth of `openings` agrees with what the student saw; if not, each is played and maybe rejected."""
    chancy: ClassVar[bool] = False
    """Whether the results of actions are random."""
    tries: ClassVar[int] = 2_000
    """Greatest number of rejected truths in a row."""

    def __init__(self, lab: WorldT) -> None:
        self.lab = lab

    @abstractmethod
    def openings(self, turns: Sequence[WorldTurn[TruthT]], rng: np.random.Generator) -> Iterator[TruthT]:
        """Truths at the opening, without end, each drawn independently given the turns; arguments as in `draws`."""

    def odds(self, turns: Sequence[WorldTurn[TruthT]]) -> Sequence[tuple[TruthT, float]]:
        """Every truth of `openings` with its probability, if they can be listed; empty if they must be drawn."""
        return ()

    @abstractmethod
    def quantities(self, turns: Sequence[WorldTurn[TruthT]]) -> dict[str, float]:
        """Numbers that depend on what is hidden, for calibration; some depend also on what was seen.

        With functions of the truth alone, a sampler that ignores the turns passes: Modrak et al. (2023),
        Simulation-based calibration checking for Bayesian computation.
        """

    def draws(
        self,
        turns: Sequence[WorldTurn[TruthT]],
        rng: np.random.Generator,
        beside: Sequence[WorldTurn[TruthT]] = (),
    ) -> Iterator[Draw[TruthT]]:
        """The same turns in other worlds, without end, each drawn independently with its probability given the turns.

        The actions and the known rewards are the same. Other rewards, and successes, are those of the drawn world.

        Args:
            turns: what happened, the opening first. Only what the student saw decides which worlds are drawn.
            rng: draws the worlds.
            beside: turns of another student in the same world, from the same opening; the drawn worlds agree with
                these, too. Then no reward of `turns` may be known if the world is `chancy`.

        Raises:
            NoWorldError: no world agrees, or `tries` worlds in a row were rejected.
        """
        fits = self._fitting(turns, rng, beside)
        known: dict[TruthT, Draw[TruthT]] = {}
        rejected = 0
        for opening in self.openings(beside or turns, rng):
            drawn = known.get(opening) if self.exact and not self.chancy else None
            if drawn is None:
                drawn = fits(opening)
                if drawn is None:
                    rejected += 1
                    if rejected == self.tries:
                        raise NoWorldError(f"{rejected:,} worlds in a row do not agree with what the student saw")
                    continue
                if self.exact and not self.chancy:
                    known[opening] = drawn
            rejected = 0
            yield drawn

    def every(
        self, turns: Sequence[WorldTurn[TruthT]], beside: Sequence[WorldTurn[TruthT]] = ()
    ) -> list[tuple[Draw[TruthT], float]]:
        """All worlds of `draws`, each with its probability, if `odds` lists them; empty if they must be drawn."""
        fits = self._fitting(turns, np.random.default_rng(0), beside)  # random results have no odds
        found = [(draw, odds) for opening, odds in self.odds(beside or turns) if (draw := fits(opening)) is not None]
        total = sum(odds for _, odds in found)
        return [(draw, odds / total) for draw, odds in found]

    def _fitting(
        self, turns: Sequence[WorldTurn[TruthT]], rng: np.random.Generator, beside: Sequence[WorldTurn[TruthT]]
    ) -> Callable[[TruthT], Draw[TruthT] | None]:
        """A function that gives the turns in the world of an opening, or None if it does not agree; as in `draws`."""
        played = turns, *([beside] if beside and not self.exact else [])
        checked = [(each, () if self.exact and not beside else self._shown(each)) for each in played]

        def fits(opening: TruthT) -> Draw[TruthT] | None:
            drawn = [self._play(opening, each, wanted, rng) for each, wanted in checked]
            return None if None in drawn else drawn[0]

        return fits

    def _shown(self, turns: Sequence[WorldTurn[TruthT]]) -> tuple[Any, ...]:
        """What the student sees in these turns."""
        return tuple(seen(self.lab, each.truth) for each in turns)

    def take(
        self,
        turns: Sequence[WorldTurn[TruthT]],
        rng: np.random.Generator,
        count: int,
        beside: Sequence[WorldTurn[TruthT]] = (),
    ) -> list[Draw[TruthT]]:
        """The first `count` worlds of `draws`.

        Raises:
            NoWorldError: fewer could be drawn; the message says how many.
        """
        found: list[Draw[TruthT]] = []
        try:
            found.extend(islice(self.draws(turns, rng, beside), count))
        except NoWorldError as error:
            raise NoWorldError(f"{error}; {len(found)} of {count} worlds were drawn") from None
        return found

    def _play(
        self, opening: TruthT, turns: Sequence[WorldTurn[TruthT]], wanted: Sequence[Any], rng: np.random.Generator
    ) -> Draw[TruthT] | None:
        """The same actions played from another opening; None as soon as the student would see something else."""
        lab = self.lab
        lab.restore(opening)
        lab.np_random = rng
        played = [turns[0]._replace(truth=opening)]
        success, outcome = turns[0].success, self.outcome
        if wanted and seen(lab) != wanted[0]:
            return None
        for i, (action, reward, _, _, known) in enumerate(turns[1:], 1):
            if action is not None:
                paid, success = outcome(action)
                if not known:
                    reward = paid
                elif not self.chancy and reward != paid:
                    return None
            if wanted and seen(lab) != wanted[i]:
                return None
            played.append(WorldTurn(action, reward, lab.truth, success, known))
        return tuple(played)

    def outcome(self, action: Any) -> tuple[float, bool]:
        """Take an action in the lab: its reward, and whether the world says that it succeeds."""
        _, reward, _, _, info = self.lab.advance(action)
        return reward, info["success"]


def random_walk(world: World[Any], steps: int, rng: np.random.Generator) -> Iterator[WorldTurn[Any]]:
    """At most `count` turns of random actions from the current state; no reward is known."""
    for _ in range(steps):
        action = world.legal(world.sample_action(rng))
        _, reward, terminated, truncated, info = world.advance(action)
        yield WorldTurn(action, reward, world.truth, info["success"])
        if terminated or truncated:
            return


def seen(lab: World[Any], truth: Any = None) -> Any:
    """What a student sees of a world, comparable with `==`: in the state of a truth, or in the current state."""
    if truth is not None:
        lab.restore(truth)
    observation = lab.observe()
    return plain(observation), lab.describe(observation)
