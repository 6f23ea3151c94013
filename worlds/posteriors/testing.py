"""A conformance kit for posteriors. For your own, run `check_posterior(MyWorld, MyPosterior)`.

Each check takes a factory of worlds and a function that makes the posterior of a world; it raises an AssertionError
that describes the error.
"""

from collections.abc import Callable, Iterator
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import stats

from worlds.posteriors import Draw, Posterior, random_walk, seen
from worlds.testing import require
from worlds.world import World, WorldTurn, plain

__all__ = [
    "CHECKS",
    "CONFIRMATION",
    "DRAWS",
    "HISTORIES",
    "THRESHOLD",
    "Ranks",
    "check_posterior",
    "history",
    "rank",
    "uniformity",
]

Make = Callable[[], World[Any]]
MakePosterior = Callable[[World[Any]], Posterior[Any]]
HISTORIES = 400
"""Number of histories in a check of a posterior."""
DRAWS = 19
"""Number of draws for each history, which gives 20 ranks."""
THRESHOLD = 1e-5
"""A p-value of ranks below it makes a posterior suspect."""
CONFIRMATION = 0.01
"""A suspect is rejected where the ranks of new histories have a p-value below this one."""
_TURNS = 12
_FEW = 8

Ranks = dict[str, npt.NDArray[np.int64]]
"""Per quantity the rank of the true world among the drawn ones in each history, 0 to the number of draws."""


class Calibration(NamedTuple):
    """The ranks of a quantity."""

    p: float
    """The p-value of a chi-square test that all ranks are equally likely."""
    counts: npt.NDArray[np.int64]
    """How often each rank was found, shape (draws + 1,)."""


def check_posterior(make: Make, make_posterior: MakePosterior) -> None:
    """Run every check."""
    for check in CHECKS:
        check(make, make_posterior)


def history(world: World[Any], rng: np.random.Generator) -> list[WorldTurn[Any]]:
    """A history without a teacher: a few random actions in a new episode. All, some or no rewards are known."""
    world.reset(seed=int(rng.integers(2**31)))
    said = rng.choice((0.0, 0.5, 1.0))
    opening = WorldTurn(None, 0.0, world.truth)
    walk = random_walk(world, int(rng.integers(_TURNS + 1)), rng)
    return [opening, *(turn._replace(reward_known=bool(rng.random() < said)) for turn in walk)]


def rank(
    make: Make,
    make_posterior: MakePosterior,
    rng: np.random.Generator,
    histories: int,
    draws: int = DRAWS,
) -> Ranks:
    """The ranks of simulation-based calibration: if the posterior is correct, all are equally likely.

    Ties are broken at random. Talts et al. (2018), Validating Bayesian inference algorithms with simulation-based
    calibration; for quantities that depend on what was seen, see `Posterior.quantities`. If the world is in a town,
    each history has another town, since a student does not know its law.
    """
    world = make()
    posterior = make_posterior(world)
    found: dict[str, list[int]] = {}
    for _ in range(histories):
        if _has_town(world):
            world = _elsewhere(world, rng)
            posterior = make_posterior(world)
        turns = history(world, rng)
        others = [posterior.quantities(each) for each in posterior.take(turns, rng, draws)]
        for name, value in posterior.quantities(turns).items():
            less = sum(other[name] < value for other in others)
            equal = sum(other[name] == value for other in others)
            found.setdefault(name, []).append(less + int(rng.integers(equal + 1)))
    return {name: np.array(ranks) for name, ranks in found.items()}


def _has_town(world: World[Any]) -> bool:
    return world.options.get("town") is not None


def _elsewhere(world: World[Any], rng: np.random.Generator) -> World[Any]:
    """Another such world; if it is in a town, in another town."""
    return type(world)(**world.options | ({"town": int(rng.integers(2**31))} if _has_town(world) else {}))


def uniformity(ranks: npt.NDArray[np.int64], draws: int = DRAWS) -> Calibration:
    """Whether ranks are equally likely."""
    counts = np.bincount(ranks, minlength=draws + 1)
    return Calibration(float(stats.chisquare(counts).pvalue), counts)


def _drawn(
    world: World[Any], make_posterior: MakePosterior, seed: int
) -> Iterator[tuple[list[WorldTurn[Any]], Draw[Any]]]:
    """A few histories, each with two draws."""
    rng, posterior = np.random.default_rng(seed), make_posterior(world)
    for _ in range(_FEW):
        turns = history(world, rng)
        yield from ((turns, other) for other in posterior.take(turns, rng, 2))


def check_alike(make: Make, make_posterior: MakePosterior) -> None:
    """A student sees the same in a drawn world: observations, its own actions, the known rewards."""
    world = make()
    for turns, other in _drawn(world, make_posterior, 0):
        require(len(other) == len(turns), f"a draw must have as many turns, got {len(other)} for {len(turns)}")
        for mine, theirs in zip(turns, other, strict=True):
            same = plain(mine.action) == plain(theirs.action) and mine.reward_known == theirs.reward_known
            same &= not mine.reward_known or mine.reward == theirs.reward
            require(
                same and seen(world, mine.truth) == seen(world, theirs.truth),
                "a student can distinguish a drawn world from its own",
            )


def check_worlds(make: Make, make_posterior: MakePosterior) -> None:
    """A drawn world is one of the family's: its actions have the results that the draw says."""
    world = make()
    for _, other in _drawn(world, make_posterior, 1):
        world.restore(other[0].truth)
        for turn in other[1:]:
            _, _, _, _, info = world.step(turn.action)
            found = plain((world.truth, info["success"]))
            require(found == plain((turn.truth, turn.success)), "a drawn world does not follow its own rules")


def check_repetition(make: Make, make_posterior: MakePosterior) -> None:
    """Equal turns and random streams give equal draws, whatever was drawn before, and the world does not change."""
    rng = np.random.default_rng(2)
    world = make()
    first, second = make_posterior(world), make_posterior(world)
    turns = history(world, rng)
    before, given = plain(world.save()), plain(turns)
    first.take(history(make(), rng), rng, 2)
    one, two = (plain(each.take(turns, np.random.default_rng(3), 4)) for each in (first, second))
    require(one == two, "equal turns and random streams give different draws")
    require(plain(world.save()) == before, "drawing has changed the world: use the lab")
    require(plain(turns) == given, "drawing has changed the turns")
    later = list(islice(first.draws(turns, np.random.default_rng(3)), 4))
    require(plain(later) == one, "draws depend on what was drawn before")


def check_hidden(make: Make, make_posterior: MakePosterior) -> None:
    """Draws do not depend on the hidden truth: they are the same with a drawn world, of another town, in its place."""
    rng = np.random.default_rng(4)
    world = make()
    for _ in range(_FEW):
        world, other = _elsewhere(world, rng), _elsewhere(world, rng)
        posterior, turns = make_posterior(world), history(world, rng)
        (swapped,) = posterior.take(turns, rng, 1)
        draws = posterior.take(turns, np.random.default_rng(5), 4)
        same = plain(draws) == plain(make_posterior(other).take(swapped, np.random.default_rng(5), 4))
        require(same, "draws depend on what a student cannot see: they differ where a drawn world is the true one")


def check_calibration(make: Make, make_posterior: MakePosterior) -> None:
    """Worlds are drawn with the probability that the generator gives them.

    Seeds are fresh. A quantity whose ranks are improbable is rejected only if new histories confirm it, since the
    chi-square test is too strict where few histories give each rank.
    """
    suspects = {name for name, (p, _) in _calibrations(make, make_posterior, _entropy()).items() if p < THRESHOLD}
    if not suspects:
        return
    entropy = _entropy()
    for name, (p, counts) in _calibrations(make, make_posterior, entropy).items():
        require(
            name not in suspects or p >= CONFIRMATION,
            f"the posterior is not calibrated: the ranks of {name!r}, {counts.tolist()}, have probability {p:.2g}, "
            f"below {CONFIRMATION}, with the seed {entropy}, and had one below {THRESHOLD} before",
        )


def _entropy() -> int:
    return int(np.random.SeedSequence().generate_state(1)[0])


def _calibrations(make: Make, make_posterior: MakePosterior, entropy: int) -> dict[str, Calibration]:
    ranks = rank(make, make_posterior, np.random.default_rng(entropy), HISTORIES)
    return {name: uniformity(each) for name, each in ranks.items()}


CHECKS = (check_alike, check_worlds, check_repetition, check_hidden, check_calibration)
"""Every check of a posterior."""
