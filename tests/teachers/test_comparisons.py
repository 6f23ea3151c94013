"""Comparisons hold where values say so, mean the same by their fields, and say what they say to a student."""

import itertools
import json

import pytest
from shelf import FAMILIES

from llf_teacher.registry import family
from teachers.atoms import FP, HN, HP, Atom, Moment, contradictions
from teachers.common import Better, BetterTurn, WorseTurn
from teachers.oracles.bandits import Avoid, Pull
from teachers.personality import parse_personality
from teachers.testing import Pupil
from teachers.view import View

VALUED = [name for name, each in sorted(FAMILIES.items()) if "values" in each.oracle_class().abilities()]
ROLLED = [name for name in sorted(FAMILIES) if name not in VALUED and FAMILIES[name].serves("comparing")]


def viewed(name, seed):
    """An oracle, a lab and views of growing episodes of random play, with all values known."""
    each = family(name)
    pupil = Pupil(each.make_world, each.make_teacher, max_turns=8, turns=40)
    session = pupil.session(pupil.make_world(), instructs=True)
    view = None
    for moment in pupil.play(session, seed):
        oracle = session.teacher.oracle
        if not moment.turn:
            view = View(oracle, lambda claim: 1.0)
        view.see(moment, frozenset((HP, HN, FP)))
        yield oracle, session.world.scratch(), view


@pytest.mark.parametrize("name", VALUED)
def test_of_two_actions_that_is_better_which_is_worth_more(name, rng):
    seed, said = int(rng.integers(2**31)), set()
    for oracle, lab, view in viewed(name, seed):
        if view.moment.over:
            continue
        values = oracle.values(view.moment.after)
        for this, that in itertools.permutations(map(lab.legal, range(len(values))), 2):
            claim = view.better(this, that)
            if claim is None:  # nothing is at stake any more, so that hindsight is silent
                assert min(values) == max(values)
                continue
            better = values[this] - values[that] > 1e-9
            assert claim.holds(view.moment, lab) is better is claim.means(view.moment, oracle), (seed, claim)
            said.add(better)
            (reverse,) = claim.counterparts(view.moment, lab)
            assert claim.excludes(reverse)
            assert (reverse.this, reverse.that) == (that, this)
    assert said == {True, False}


@pytest.mark.parametrize("name", ROLLED)
def test_without_values_that_is_better_after_which_the_task_is_solved_sooner(name, rng):
    seed, said = int(rng.integers(2**31)), set()
    for oracle, lab, view in itertools.islice(viewed(name, seed), 12):
        moment = view.moment
        if moment.over or moment.before is None or not (plan := view.plan(1)):
            continue
        left = []
        for action in (plan[0], moment.action):
            lab.restore(moment.after)
            for number in itertools.count(1):
                if lab.advance(action)[4]["success"] or number == 100:
                    break
                (action,) = oracle.plan(lab.truth, 1)
            left.append(number)
        claim, sooner = view.better(plan[0], moment.action), left[0] < left[1]
        if claim is None:  # no way solves the task
            assert left[0] == left[1]
            continue
        said.add(sooner)
        assert claim.holds(moment, lab) is sooner is claim.means(moment, oracle), (seed, claim)
        (reverse,) = claim.counterparts(moment, lab)
        assert reverse.holds(moment, lab) is (left[0] > left[1]) is reverse.means(moment, oracle)
        good, bad = claim._ground
        assert not Better.on((good, good), this=plan[0], that=moment.action).holds(moment, lab)  # no way of the other
        if good[1:2] != good[:1]:  # a ground that begins with another action
            assert not Better.on((good[1:], bad), this=plan[0], that=moment.action).holds(moment, lab)
        if not sooner and good:  # a ground that lies of the other way is found by the fields
            liar = Better.on((good, ()), this=plan[0], that=moment.action)
            assert liar.holds(moment, lab)
            assert not liar.means(moment, oracle)
    assert True in said


@pytest.mark.parametrize("name", VALUED)
def test_of_two_turns_that_was_better_which_lost_less(name, rng):
    seed, said = int(rng.integers(2**31)), set()
    for oracle, lab, view in viewed(name, seed):
        moments = view._moments
        for ago in range(1, view.turn):
            claim, (other, now) = view.better_turn(ago), (moments[-1 - ago], moments[-1])
            lost, earlier = oracle.regret(now), oracle.regret(other)
            if claim is None:  # they lost as much, or of one of them hindsight says nothing
                verdicts = [(next(iter(view._hindsight_on(each)), None), each) for each in (now, other)]
                assert lost == pytest.approx(earlier) or not all(v and view._tells(v, each) for v, each in verdicts)
                continue
            said.add(type(claim))
            assert isinstance(claim, BetterTurn) == (lost < earlier)
            assert claim.holds(now, lab), (seed, claim)
            (opposite,) = claim.counterparts(now, lab)
            assert not opposite.holds(now, lab)
            assert claim.excludes(opposite)
            for each, true in ((claim, True), (opposite, False)):
                assert each.within(moments.__getitem__, now.turn).means(now, oracle) is true
            assert not claim.within(moments.__getitem__, ago).means(moments[ago], oracle)  # there is no earlier turn
    assert said == {BetterTurn, WorseTurn}


def test_a_comparison_of_turns_is_taken_to_the_turns_of_another_world():
    """By its fields alone: what the earlier turn lost in the teacher's world does not matter."""
    arms = family("bandits")
    world = arms.make_world(problem="TwoArmedDeterministicFixed")
    world.reset(seed=0)
    best = world.truth.best[0]
    information = arms.make_information(world, 0, 2000)
    moments = [Moment.opening(world.truth)]
    information.see(moments[0])
    for turn, action in enumerate((1 - best, best), 1):
        _, reward, _, _, info = world.step(action)
        moments.append(Moment(moments[-1].after, action, reward, world.truth, info["success"], turn, False))
        information.see(moments[-1])
    claim = BetterTurn.on((moments[1], None, None), ago=1)
    bits, advice = information.hear([Atom(claim, "words", 2), Atom(Pull(action=best), "words", 2)])
    assert bits.bits == pytest.approx(1, abs=0.1)
    assert advice.bits == 0


def test_a_comparison_excludes_advice_of_what_is_worse_and_no_warning():
    claim = Better.on(None, this=1, that=2)
    said = [Atom(each, "", 0) for each in (claim, Pull(action=1), Pull(action=2), Avoid(action=1), Avoid(action=2))]
    clashes = {(one.claim, other.claim) for one, other in contradictions(said) if claim in (one.claim, other.claim)}
    assert clashes == {(claim, Pull(action=2))}


@pytest.mark.parametrize("name", [*VALUED, "alfworld", "movies"])
def test_comparing_says_only_comparisons_and_many(name):
    each = family(name)
    pupil = Pupil(each.make_world, each.make_teacher, max_turns=8)
    heard = [said for episode in pupil.taught(parse_personality("comparing"), 60) for said in episode]
    kinds = {type(atom.claim) for said in heard for atom in said.atoms}
    assert kinds == ({Better, BetterTurn, WorseTurn} if name in VALUED else {Better})
    assert name in ROLLED or sum(bool(said.atoms) for said in heard) > 0.8 * sum(bool(said.true) for said in heard)


@pytest.mark.parametrize("name", ["metaworld", "parking", "optimization"])
def test_numbers_of_a_comparison_are_written_as_a_student_writes_them_and_it_holds_of_these(name):
    """The student's numbers have 16 digits; a claim about an action that is said to four is about that action."""
    each = family(name)
    pupil = Pupil(each.make_world, each.make_teacher, max_turns=5)
    said = 0
    for episode in pupil.taught(parse_personality("comparing"), 25):
        for heard in episode:
            for atom in heard.atoms:
                lab = pupil.make_world().scratch()
                for action, text in ((atom.claim.this, atom.claim.first), (atom.claim.that, atom.claim.second)):
                    assert json.loads(text) == list(action) == [float(f"{number:.4g}") for number in action]
                    assert text in atom.text
                    assert lab.legal(action) == action
                assert atom.claim.holds(heard.moment, lab)
                said += 1
    assert said > 5


def test_lists_of_titles_are_compared_as_they_are_sent():
    each = family("movies")
    pupil = Pupil(each.make_world, each.make_teacher, max_turns=5)
    heard = [
        atom for episode in pupil.taught(parse_personality("comparing"), 20) for said in episode for atom in said.atoms
    ]
    assert heard
    for atom in heard:
        assert (atom.claim.first, atom.claim.second) == (atom.claim.this, atom.claim.that)
        assert f'"{atom.claim.first}"' not in atom.text
        assert isinstance(json.loads(atom.claim.first), list)


def test_a_car_is_not_said_to_park_sooner_by_a_single_action():
    """Plans of parking are not the shortest, and another plan from the same state can be one action shorter."""
    each = family("parking")
    pupil = Pupil(each.make_world, each.make_teacher, max_turns=4)
    said = [
        atom.claim
        for episode in pupil.taught(parse_personality("comparing"), 60)
        for heard in episode
        for atom in heard.atoms
    ]
    assert said
    assert min(claim.gain() for claim in said) >= each.oracle_class().least_gain == 2
