"""Clues are true, say more and more, and are said one at a time by `ruler`."""

from itertools import pairwise

import numpy as np
import pytest
from lessons import lab, rows
from sampling import fewer
from scipy.stats import norm
from shelf import FAMILIES

from teachers.atoms import Atom, Claim, Moment, Scope, claim, contradictions
from teachers.common import MayAsk, NotUnderstood, Reward, Right, TryAgain
from teachers.oracle import Oracle
from teachers.oracles.gridworld.claims import Avoid, Go, Goal, InRoom, NextTo, NotInRoom, Route
from teachers.testing import Pupil, check_personality

CLUED = [name for name, each in FAMILIES.items() if each.serves("ruler")]
MEASURED = [
    ("gridworld", {"map": True}, 60),
    ("bandits", {"problem": "TenArmedGaussian"}, 60),
    ("bandits", {"problem": "TenArmedRandomFixed"}, 60),
    ("movies", {}, 60),
    pytest.param("alfworld", {"games": "generated"}, 40, marks=pytest.mark.full),
]


def pupil(name, turns=60, **options):
    each = FAMILIES[name]
    options = each.environments[each.showcase[0]] | options
    turns = fewer(each, turns)
    return Pupil(lambda: each.make_world(**options), each.make_teacher, max_turns=each.max_turns, turns=turns)


@pytest.mark.parametrize("name", CLUED)
def test_clues_hold_with_other_options_of_the_world(name):
    each = FAMILIES[name]
    rng = np.random.default_rng()
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


def test_clues_that_differ_about_the_same_thing_exclude_each_other():
    hall, no_hall, kitchen = InRoom(room="hall"), NotInRoom(room="hall"), InRoom(room="kitchen")
    assert hall.excludes(no_hall)
    assert hall.excludes(kitchen)
    assert not hall.excludes(NotInRoom(room="kitchen"))
    assert len(contradictions([Atom(each, "", 0) for each in (hall, no_hall, kitchen, NextTo(room="hall-1"))])) == 2
