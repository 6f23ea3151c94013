"""Rules: claims about every world of a town, checked in sampled worlds of the town."""

from abc import abstractmethod
from collections.abc import Callable, Set
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from teachers.atoms import Claim, Moment, Scope, TruthT, WorldT, claim
from worlds.world import World

__all__ = ["WORLDS", "TownRule"]

WORLDS = 200
"""Number of worlds of a town that check a rule."""
_STREAM = 0x70305  # the seeds of these worlds, which are the same for all rules and towns


@claim
class TownRule(Claim[TruthT, WorldT]):
    """Base of claims about a town: true if some world of the town supports it and none contradicts it.

    Without a town it is false. `holds` does not read the law of the town but looks at worlds. `means` judges worlds
    that a student draws, each of a town of its own, so it reads the law in their truth.
    """

    scope = Scope.FAMILY

    @abstractmethod
    def fits(self, truth: TruthT) -> bool | None:
        """Whether one world supports it, given its truth but not the law in it; None if the world does not tell."""

    @abstractmethod
    def means(self, moment: Moment[TruthT], oracle: Any) -> bool:
        """Whether it is true of the town of the moment's world, by the law in the truth."""

    def holds(self, moment: Moment[TruthT], lab: WorldT) -> bool:
        """Look at worlds of the town."""
        shown = self.shown(moment, lab)
        return True in shown and False not in shown

    def shown(self, moment: Moment[TruthT], lab: WorldT) -> Set[bool | None]:
        """The results of `fits` in the moment's world and in `WORLDS` others of the town, which are cached."""
        if lab.options.get("town") is None:
            return set()
        return {self.fits(moment.after)} | _shown(self, _town_of(lab))


@dataclass(frozen=True)
class _Town:
    """What all worlds of a town share, as a cache key."""

    world: type[World[Any]]
    options: str
    scratch: Callable[[], World[Any]] = field(compare=False)


def _town_of(lab: World[Any]) -> _Town:
    return _Town(type(lab), repr(sorted(lab.options.items())), lab.scratch)


@lru_cache(maxsize=8)
def _openings(town: _Town) -> tuple[Any, ...]:
    """The truths at the opening of worlds of a town."""
    world, truths = town.scratch(), []
    for seed in np.random.SeedSequence(_STREAM).generate_state(WORLDS).tolist():
        world.reset(seed=seed)
        truths.append(world.truth)
    return tuple(truths)


@lru_cache(maxsize=4096)
def _shown(rule: TownRule[Any, Any], town: _Town) -> Set[bool | None]:
    return frozenset(map(rule.fits, _openings(town)))
