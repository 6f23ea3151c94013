"""Every family's posterior passes the kit that ships, and the kit finds what is wrong with others."""

from functools import partial

import gymnasium
import numpy as np
import pytest
from design import amount, sampled
from sampling import ENTRIES
from towns import towns_of

from llf_teacher import Lesson
from llf_teacher.registry import entries, family
from pz_envs.family import all_families
from worlds.bandits import Bandit
from worlds.gridworld import Gridworld
from worlds.posteriors import NoWorldError, Posterior
from worlds.posteriors import testing as kit
from worlds.posteriors.bandits import BanditPosterior, Seen
from worlds.posteriors.gridworld import GridworldPosterior

ABLE = [each for each in ENTRIES if each.values[0].family.posterior]
DEAR = {"movies": amount(150, full=300)}  # histories, each with 19 worlds
TOWNS = [each for each in ABLE if towns_of(each.values[0])]

of_each_family = sampled(lambda entry: {entry.family.name})


@pytest.fixture
def many_histories(monkeypatch):
    """So many that fresh seeds find each liar: of 40 runs, the greatest p-value was 1e-27, with 400 histories 2e-5."""
    monkeypatch.setattr(kit, "HISTORIES", amount(700, full=1000))


def made(entry, **options):
    return partial(
        entry.family.make_world, **entry.options | dict(entry.family.posterior_needs) | options
    ), entry.family.make_posterior


@sampled(lambda entry, check: {entry.id, (entry.family.name, check)})
@pytest.mark.parametrize("check", kit.CHECKS[:-1], ids=lambda check: check.__name__)
@pytest.mark.parametrize("entry", ABLE)
def test_posteriors(entry, check):
    check(*made(entry))


@of_each_family
@pytest.mark.parametrize("entry", ABLE)
def test_posteriors_are_calibrated(entry, monkeypatch):
    if entry.family.name in DEAR:
        monkeypatch.setattr(kit, "HISTORIES", DEAR[entry.family.name])
    kit.check_calibration(*made(entry))


@sampled(lambda entry, check: {entry.id, (entry.family.name, check)})
@pytest.mark.parametrize("check", kit.CHECKS[:-1], ids=lambda check: check.__name__)
@pytest.mark.parametrize("entry", TOWNS)
def test_posteriors_in_towns(entry, check):
    check(*made(entry, town=3))


@of_each_family
@pytest.mark.parametrize("entry", TOWNS)
def test_posteriors_are_calibrated_in_towns(entry, monkeypatch):
    monkeypatch.setattr(kit, "HISTORIES", DEAR.get(entry.family.name, kit.HISTORIES) // 2)
    kit.check_calibration(*made(entry, town=3))


@pytest.mark.full
@pytest.mark.parametrize("entry", TOWNS)
def test_posteriors_are_calibrated_in_many_towns(entry, monkeypatch):
    monkeypatch.setattr(kit, "HISTORIES", 10_000)
    kit.check_calibration(*made(entry, town=3))


@pytest.mark.full
@pytest.mark.parametrize("entry", ABLE)
def test_posteriors_are_calibrated_over_many_long_histories(entry, monkeypatch):
    monkeypatch.setattr(kit, "HISTORIES", 10_000)
    monkeypatch.setattr(kit, "_TURNS", 15)
    kit.check_calibration(*made(entry))


class FromThePrior(BanditPosterior):
    """Ignores the rewards that were said; parameters alone do not show it."""

    def _seen(self, turns):
        return Seen(*np.zeros((len(Seen._fields), self.lab.arms)))


class WithWrongWeights(BanditPosterior):
    """Counts each reward twice."""

    def _seen(self, turns):
        seen = super()._seen(turns)
        return seen._replace(pulls=2 * seen.pulls, paid=2 * seen.paid)


class WithNearRooms(GridworldPosterior):
    """Forgets that the treasure is far from the start."""

    def openings(self, turns, rng):
        start = turns[0].truth
        been = {turn.truth.room for turn in turns}
        layout = start.layout
        rooms = [layout.treasure] if layout.treasure in been else [r for r in range(len(layout.doors)) if r not in been]
        while True:
            yield start._replace(layout=layout._replace(treasure=rooms[rng.integers(len(rooms))]))


@pytest.mark.parametrize(
    ("make", "liar"),
    [
        (partial(Bandit, problem="TenArmedRandomFixed"), FromThePrior),
        (partial(Bandit, problem="TenArmedRandomFixed"), WithWrongWeights),
        (partial(Gridworld, map=True), WithNearRooms),
    ],
)
def test_only_calibration_rejects_wrong_probabilities(make, liar, rejects, many_histories):
    lying = lambda world: liar(world.scratch())  # noqa: E731
    assert rejects(kit.CHECKS, make, lying) == ["check_calibration"]


class AnyLaw(GridworldPosterior):
    """Draws the law without regard to the room of the treasure."""

    def openings(self, turns, rng):
        for truth in super().openings(turns, rng):
            law = self.lab.options["room_types"][rng.integers(7)]
            yield truth._replace(layout=truth.layout._replace(law=law))


class Local(BanditPosterior):
    """Knows the law by the number of the town."""

    def openings(self, turns, rng):
        yield from (truth for truth in super().openings(turns, rng) if truth.law == self.lab.law)


@pytest.mark.parametrize(
    ("make", "liar", "check"),
    [
        (partial(Gridworld, map=True, town=3), AnyLaw, "check_calibration"),
        (partial(Bandit, town=3), FromThePrior, "check_calibration"),
        (partial(Bandit, town=3), Local, "check_hidden"),
    ],
)
def test_one_check_rejects_what_is_wrong_of_laws(make, liar, check, rejects, many_histories):
    assert rejects(kit.CHECKS, make, lambda world: liar(world.scratch())) == [check]


def test_parameters_alone_do_not_show_that_data_are_ignored(rng):
    make = partial(Bandit, problem="TenArmedRandomFixed")
    ranks = kit.rank(make, lambda world: FromThePrior(world.scratch()), rng, 400)
    assert kit.uniformity(ranks["mean of arm 0"]).p > kit.THRESHOLD
    assert kit.uniformity(ranks["greatest mean"]).p > kit.THRESHOLD


class Elsewhere(GridworldPosterior):
    """Lets the treasure be where the student has been."""

    def openings(self, turns, rng):
        start = turns[0].truth
        while True:
            yield start._replace(layout=start.layout._replace(treasure=turns[-1].truth.room))


class Lawless(BanditPosterior):
    """Has successes that do not follow from the arms."""

    def draws(self, turns, rng, beside=()):
        for draw in super().draws(turns, rng):
            yield tuple(turn._replace(success=not turn.success) if turn.action is not None else turn for turn in draw)


class Tired(BanditPosterior):
    """Draws from a stream of its own."""

    def draws(self, turns, rng, beside=()):
        self.count = getattr(self, "count", 0) + 1
        return super().draws(turns, np.random.default_rng(self.count))


@pytest.mark.parametrize(
    ("make", "liar", "check"),
    [
        (partial(Gridworld, map=True), Elsewhere, "check_alike"),
        (Bandit, Lawless, "check_worlds"),
        (Bandit, Tired, "check_repetition"),
    ],
)
def test_the_kit_finds_what_else_is_wrong(make, liar, check, rejects):
    assert check in rejects(kit.CHECKS, make, lambda world: liar(world.scratch()))


def test_families_without_a_posterior_say_so():
    able = [each.name for each in all_families() if each.posterior]
    assert able == ["bandits", "gridworld", "movies"]
    for each in all_families():
        if each.name not in able:
            with pytest.raises(ValueError, match="has no posterior; families with one: bandits, gridworld"):
                each.make_posterior(None)
    with pytest.raises(ValueError, match=r"only where the student knows the plan of the house.*option map=True"):
        family("gridworld").make_posterior(Gridworld())


class Picky(Posterior):
    """Draws worlds without regard to what was seen."""

    exact, tries = False, 50

    def openings(self, turns, rng):
        while True:
            yield self.lab.draw(rng)

    def quantities(self, turns):
        return {}


def test_a_sampler_that_does_not_come_far_says_so():
    world = Gridworld()
    turns = kit.history(world, np.random.default_rng(0))
    with pytest.raises(NoWorldError, match=r"50 worlds in a row do not agree .* 0 of 9 worlds were drawn"):
        Picky(world.scratch()).take(turns, np.random.default_rng(0), 9)


@pytest.mark.parametrize("id", ["llf-bandits-BanditTwoArmedDeterministicFixed-v0", "llf-reco-movie-v0"])
def test_rewards_that_no_world_pays_are_refused(id):
    entry = entries()[id]
    make, make_posterior = made(entry)
    world = make()
    world.reset(seed=0)
    action = world.legal(world.sample_action(np.random.default_rng(0)))
    before = kit.WorldTurn(None, 0.0, world.truth)
    world.step(action)
    turns = [before, kit.WorldTurn(action, 0.123, world.truth, False, True)]
    with pytest.raises(NoWorldError, match="pays these rewards; 0 of 3 worlds"):
        make_posterior(world).take(turns, np.random.default_rng(0), 3)


def test_deterministic_arms_are_known_after_one_reward():
    world = Bandit("TwoArmedDeterministicFixed")
    world.reset(seed=1)
    _, reward, *_ = world.step(0)
    opening = kit.WorldTurn(None, 0.0, world.truth)
    heard = [opening, kit.WorldTurn(0, reward, world.truth, False, True)]
    posterior = BanditPosterior(world.scratch())
    rng = np.random.default_rng(0)
    assert {draw[0].truth for draw in posterior.take(heard, rng, 50)} == {world.truth}
    unheard = [opening, kit.WorldTurn(0, reward, world.truth)]
    assert len({draw[0].truth for draw in posterior.take(unheard, rng, 50)}) == 2


def test_a_lesson_of_a_users_own_has_none():
    lesson = Lesson(lambda: gymnasium.make("FrozenLake-v1"))
    with pytest.raises(ValueError, match=r"the lesson '.*' has no posterior"):
        lesson.make_posterior(lesson.make_world())
