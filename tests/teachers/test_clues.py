"""Clues are true, say more and more, and are said one at a time by `ruler`."""

import math
from itertools import pairwise

import numpy as np
import pytest
from design import amount
from lessons import lab, rows
from sampling import fewer
from scipy.stats import norm
from shelf import FAMILIES

from teachers.atoms import Atom, Claim, Moment, Scope, claim, contradictions
from teachers.common import MayAsk, NotUnderstood, Reward, Right, TryAgain
from teachers.oracle import Oracle
from teachers.oracles.alfworld.claims import InTheOpen, Kept, NotKept, ShutIn, Treat
from teachers.oracles.bandits import NoMoreThan, OneOf
from teachers.oracles.gridworld.claims import (
    Avoid,
    Go,
    Goal,
    InRoom,
    NextTo,
    NotInRoom,
    NotTowards,
    Route,
    Within,
)
from teachers.oracles.movies.checks import NAMES
from teachers.oracles.movies.claims import About, WithinWishes
from teachers.oracles.optimization.claims import minima
from teachers.oracles.parking.claims import LineUp, TurnBy
from teachers.oracles.poem.claims import Total
from teachers.testing import Pupil, check_personality
from worlds.alfworld.house import house_of
from worlds.gridworld import DIRECTIONS, distances_from
from worlds.optimization import LOSSES, Landscape, Optimization

CLUED = [name for name, each in FAMILIES.items() if each.serves("ruler")]
MEASURED = [
    ("gridworld", {"map": True}, 40),
    ("bandits", {"problem": "TenArmedGaussian"}, 40),
    ("bandits", {"problem": "TenArmedRandomFixed"}, 40),
    ("movies", {}, 40),
    pytest.param("alfworld", {"games": "generated"}, 40, marks=pytest.mark.full),
]


def pupil(name, turns=60, **options):
    each = FAMILIES[name]
    options = each.environments[each.showcase[0]] | options
    turns = fewer(each, turns)
    return Pupil(lambda: each.make_world(**options), each.make_teacher, max_turns=each.max_turns, turns=turns)


@pytest.mark.parametrize("name", CLUED)
def test_clues_hold_with_other_options_of_the_world(name, rng):
    each = FAMILIES[name]
    world = each.make_world(**each.environments[each.showcase[0]])
    for _ in range(fewer(each, 6)):
        options = world.draw_options(rng)
        other = pupil(name, 10, **options)
        scratch = other.make_world()
        for oracle, moment in other.judged(int(rng.integers(2**31)), "garbling"):
            for clue in oracle.clues(moment.after):
                assert clue.holds(moment, scratch), (options, clue, moment)


@pytest.mark.parametrize(("name", "options", "episodes"), MEASURED)
def test_a_later_clue_says_no_less(name, options, episodes):
    """In the mean over the episodes that have both, each measured alone at the opening."""
    gains, all_bits = {}, []
    for seed in range(episodes):
        world = FAMILIES[name].make_world(**options)
        world.reset(seed=seed)
        information = FAMILIES[name].make_information(world, seed, 128)
        oracle = FAMILIES[name].make_teacher(world).oracle
        oracle.start(world.truth)
        information.see(Moment.opening(world.truth))
        clues = oracle.clues(world.truth)
        bits = [information.weigh(Atom(clue, "words", 0)).bits for clue in clues]
        for (vague, precise), (less, more) in zip(pairwise(clues), pairwise(bits), strict=True):
            gains.setdefault((type(vague), type(precise)), []).append(more - less)
        all_bits.append(bits)
    for pair, more in gains.items():
        assert len(more) < 5 or np.mean(more) > -norm.isf(1e-3) * np.std(more) / np.sqrt(len(more)), (pair, more)
    assert np.mean([bits[-1] for bits in all_bits if bits]) > np.mean([bits[0] for bits in all_bits if bits]) + 0.5


@pytest.mark.parametrize("name", ["bandits", "gridworld"])
def test_the_ruler_says_each_lasting_clue_once_and_nothing_else(name):
    said_at_all = 0
    for oracle, episode in rows(name, "ruler"):
        heard = []
        for moment, said, _ in episode:
            left = [c for c in oracle.clues(moment.after) if c.scope in (Scope.WORLD, Scope.FAMILY) and c not in heard]
            assert said == ([] if moment.over else left[:1])
            heard += said
        said_at_all += len(heard)
        assert len(set(heard)) == len(heard)
    assert said_at_all > 100


@pytest.mark.parametrize("kinds", ["fp", "fn"])
def test_the_ruler_says_clues_of_the_wanted_kinds_one_in_each_turn(kinds):
    for _, episode in rows("gridworld", "ruler", feedback_type=kinds):
        expected = {"fp": [InRoom, NextTo], "fn": [NotInRoom]}[kinds]
        assert [[type(each) for each in said] for _, said, _ in episode[:3]] == (
            [[cls] for cls in expected] + [[], []]
        )[: len(episode[:3])]


@pytest.mark.parametrize("spec", ["ruler | delayed(turns=2)", "ruler | mistake(eps=0.3)"])
def test_the_ruler_composes(spec):
    check_personality(spec, pupil("gridworld", 200))
    turns = [turn for _, episode in rows("gridworld", spec) for turn in episode]
    true = [clue.holds(moment, lab("gridworld")) for moment, said, _ in turns for clue in said]
    assert len(true) > 100
    assert all(true) == ("mistake" not in spec)


def test_a_family_without_clues_has_no_ruler():
    assert Oracle.clues(None, None) == ()
    assert "clues" not in Oracle.abilities()


@claim
class _Base(Claim):
    pass


def test_claims_know_how_far_they_reach():
    assert [cls.scope for cls in (Goal, Go, Avoid, Route, InRoom)] == ["world", "action", "action", "action", "world"]
    assert [cls.scope for cls in (Reward, Right, TryAgain, NotUnderstood)] == ["action"] * 4
    assert MayAsk.scope is Scope.STATE
    assert _Base.scope is Scope.STATE
    assert not Scope.ACTION.lasts
    assert Scope.FAMILY.lasts


@pytest.mark.parametrize("arms", [6, 7])
def test_where_three_arms_are_the_better_half_they_are_named_once(arms):
    oracle, moment = next(pupil("bandits", 1, arms=arms).judged())
    assert [clue.arms for clue in oracle.clues(moment.after) if isinstance(clue, OneOf)] == [
        tuple(sorted(np.argsort(moment.after.means)[-3:].tolist()))
    ]


def test_no_words_of_a_clue_say_that_a_way_is_short_or_a_thing_the_only_one():
    """The way may lead north to what lies no farther north, and another mug may lie in the open."""
    for name, clue in (("gridworld", NotTowards(side=DIRECTIONS[0])), ("alfworld", ShutIn(thing="mug"))):
        said = FAMILIES[name].phrasebook().sentences(clue)
        assert not [each for each in said if "need not go" in each or "have to open" in each]


def test_clues_that_differ_about_the_same_thing_exclude_each_other():
    hall, no_hall, kitchen = InRoom(room="hall"), NotInRoom(room="hall"), InRoom(room="kitchen")
    assert hall.excludes(no_hall)
    assert hall.excludes(kitchen)
    assert not hall.excludes(NotInRoom(room="kitchen"))
    assert len(contradictions([Atom(each, "", 0) for each in (hall, no_hall, kitchen, NextTo(room="hall-1"))])) == 2


# What clues say, worked out from the truth a second time.


def moments(name, turns=40, **options):
    """Moments of random play, with a lab."""
    other = pupil(name, turns, **options)
    lab = other.make_world()
    for _, moment in other.judged(3):
        yield moment, lab


def test_clues_of_a_house_are_true_of_its_plan():
    for moment, scratch in moments("gridworld"):
        room, found, layout = moment.after
        away = distances_from(layout.treasure, layout.doors)
        at = {room: (0, 0)}
        for here in (queue := [room]):
            for direction, behind in zip(DIRECTIONS, layout.doors[here], strict=True):
                if behind >= 0 and behind not in at:
                    (x, y), (dx, dy) = at[here], ((0, 1), (1, 0), (-1, 0), (0, -1))[direction]
                    at[behind] = x + dx, y + dy
                    queue.append(behind)
        x, y = at[layout.treasure]
        no_farther = dict(zip(DIRECTIONS, (y <= 0, x <= 0, x >= 0, y >= 0), strict=True))
        for side in DIRECTIONS:
            assert NotTowards(side=side).holds(moment, scratch) == (not found and no_farther[side])
        for moves in range(8):
            assert Within(moves=moves).holds(moment, scratch) == (not found and away[room] <= moves)
        for other, name in enumerate(layout.names):
            kind = name.split("-")[0]
            assert InRoom(room=kind).holds(moment, scratch) == layout.names[layout.treasure].startswith(kind)
            assert NextTo(room=name).holds(moment, scratch) == (layout.treasure in layout.doors[other])
        assert not NotInRoom(room="ballroom").holds(moment, scratch)
        assert not NextTo(room="ballroom-1").holds(moment, scratch)


def test_clues_of_arms_are_true_of_their_means():
    for moment, scratch in moments("bandits"):
        means = moment.after.means
        for arm, mean in enumerate(means):
            assert OneOf(arms=(arm,)).holds(moment, scratch) == (mean == max(means))
            assert NoMoreThan(most=mean).holds(moment, scratch) == (mean == max(means))


def test_clues_of_a_user_are_true_of_the_wish_that_was_not_said():
    for moment, scratch in moments("movies"):
        profile, unsaid, *_ = moment.after
        wish = tuple(profile.words(unsaid).split(" or "))
        for attribute in NAMES:
            assert About(attribute=attribute).holds(moment, scratch) == (attribute == unsaid)
            assert WithinWishes(attribute=attribute, wishes=wish).holds(moment, scratch) == (attribute == unsaid)
        assert not WithinWishes(attribute=unsaid, wishes=wish[1:]).holds(moment, scratch)


def test_clues_of_a_household_are_true_of_what_lay_where():
    for moment, scratch in moments("alfworld", 20):
        game = moment.after.game
        house = house_of(game)
        held = [(house.type[f[1]][:-4], f[2]) for f in game.start if f[0] == "inreceptacle"]
        for kind in {house.type[place][:-4] for place in house.place}:
            there = any((thing, house.type[place][:-4]) == (game.target, kind) for thing, place in held)
            assert Kept(thing=game.target, place=kind).holds(moment, scratch) == there
            assert NotKept(thing=game.target, place=kind).holds(moment, scratch) != there
        opens = {place in house.openable for thing, place in held if thing == game.target}
        assert ShutIn(thing=game.target).holds(moment, scratch) == (True in opens)
        assert InTheOpen(thing=game.target).holds(moment, scratch) == (False in opens)
        for verb in ("heat", "cool", "clean"):
            assert Treat(thing=game.target, verb=verb).holds(moment, scratch) == (f"pick_{verb}_" in game.task)


@pytest.mark.parametrize("loss", LOSSES)
def test_proposals_alone_find_every_point_of_least_loss(loss, rng):
    """And no other, also where the loss is shifted and reflected, so that a minimum may lie at the border."""
    world = Optimization(loss, shift=True)
    lab = world.scratch()
    for seed in (*rng.integers(2**31, size=amount(0, full=1)).tolist(), 1099128569):
        world.reset(seed=seed)
        known, found = Landscape(lab.loss, world.truth.shift).minimisers(), minima(lab, world.truth)
        side = max(high - low for low, high in zip(lab.lows, lab.highs, strict=True))
        assert all(min(math.dist(point, other) for other in found) < 1e-4 * side for point in known)
        assert all(min(math.dist(point, other) for other in known) < 1e-4 * side for point in found)


def test_clues_of_a_car_park_are_true_of_its_spots():
    for moment, scratch in moments("parking", 6, vehicles_count=14):
        x, y, heading = moment.after.spot
        degrees = math.degrees(heading)
        assert LineUp(x=x, y=y - 9 * math.sin(heading), degrees=degrees).holds(moment, scratch)
        assert not LineUp(x=x, y=y - 9 * math.sin(heading), degrees=degrees + 40).holds(moment, scratch)
        turn = math.degrees(heading - moment.after.car.heading) % 360
        for step in range(0, 181, 30):
            assert TurnBy(side="right", degrees=step).holds(moment, scratch) == (
                abs((turn - step + 180) % 360 - 180) <= 15
            )


def test_clues_of_a_poem_are_true_of_its_pattern():
    for moment, scratch in moments("poem"):
        pattern = moment.after.pattern
        for number in range(1, sum(pattern) + 2):
            assert Total(syllables=number).holds(moment, scratch) == (number == sum(pattern))
