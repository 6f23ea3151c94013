"""The oracle of losses: its advice leads to the minimum and does not name it; its verdicts are about finite moves."""

import dataclasses
import math
import re

import numpy as np
import pytest
from design import amount
from hypothesis import given
from hypothesis import strategies as st

from pz_envs.family import all_families
from teachers.atoms import FN, FP, HN, HP, Moment
from teachers.batches.optimization import six_digits
from teachers.oracles.optimization import OptimizationOracle
from teachers.oracles.optimization.claims import (
    Answer,
    Area,
    Avoid,
    Cross,
    Fell,
    Helped,
    Hurt,
    Reached,
    Rose,
    Solution,
    Stay,
    Step,
)
from teachers.testing import Pupil, check_oracle
from worlds.optimization import LOSSES, TOLERANCE, Landscape, Optimization

VARIANTS = [(name, choice) for name, variants in LOSSES.items() for choice in range(1, len(variants) + 1)]
FAMILY = next(family for family in all_families() if family.oracle == OptimizationOracle.__name__)


def steep(x1, x2):
    return 1e4 * ((x1 - 0.3) ** 2 + x2**2) + 5 * math.cos(9 * x1)


def engaged(world, seed):
    world.reset(seed=seed)
    oracle = OptimizationOracle(world.scratch)
    oracle.start(world.truth)
    return oracle


def opening(world):
    return Moment.opening(world.truth)


def proposed(world, point, turn=1):
    before, action = world.truth, world.legal(point)
    _, reward, _, _, info = world.advance(action)
    return Moment(before, action, reward, world.truth, info["success"], turn, False)


@pytest.mark.parametrize(("name", "choice"), VARIANTS)
@pytest.mark.parametrize("shift", [False, True])
def test_advice_leads_to_success_and_never_names_a_minimiser(name, choice, shift):
    world = Optimization(name, shift, choice)
    lab = world.scratch()
    for seed in range(100):
        oracle = engaged(world, seed)
        minimisers = Landscape(world.loss, world.truth.shift).minimisers()
        moment = opening(world)
        for turn in range(1, 11):
            for claim in oracle.judge(moment, {FP, FN}):
                assert claim.holds(moment, lab)
                if type(claim) in (Step, Cross):
                    advised = claim.action
                    assert min(math.dist(advised, m) for m in minimisers) > 1e-6
            moment = proposed(world, advised, turn)
            if moment.success:
                break
        assert moment.success
        (stay,) = oracle.judge(moment, {FP})
        assert stay == Stay(action=advised)
        assert stay.target == f"[{advised[0]!r}, {advised[1]!r}]"


def test_a_ridge_is_crossed():
    """A mirror image of McCormick's valley is nearly as deep as the valley itself."""
    world = Optimization("McCormick", shift=True)
    lab = world.scratch()
    for seed in (33, 339):
        oracle = engaged(world, seed)
        moment, said = opening(world), []
        for turn in range(1, 11):
            (advice,) = oracle.judge(moment, {FP})
            assert advice.holds(moment, lab)
            assert not oracle.distort(advice, moment, np.random.default_rng(turn)).holds(moment, lab)
            said.append(type(advice))
            moment = proposed(world, advice.action, turn)
            if moment.success:
                break
        assert moment.success
        assert Cross in said


@pytest.mark.parametrize("name", LOSSES)
def test_practice_and_solution(name):
    world = Optimization(name, shift=True)
    lab = world.scratch()
    for seed in range(20):
        oracle = engaged(world, seed)
        practice = oracle.brief(world.truth, "p", np.random.default_rng(seed))[3:]
        assert practice
        assert all(claim.kind in (HP, HN) and claim.holds(opening(world), lab) for claim in practice)
        solution = oracle.brief(world.truth, "c")[-1]
        assert type(solution) is Solution
        assert solution.holds(opening(world), lab)
        assert proposed(world, solution.action).success


def test_verdicts_are_about_the_move_that_was_made():
    """A move along x1 across Booth's valley: downhill at first, and yet the loss rose."""
    world = Optimization("Booth")
    oracle = engaged(world, 0)
    proposed(world, (0.0, 3.0))
    assert world.loss.gradient(0.0, 3.0)[0] < 0
    moment = proposed(world, (9.0, 3.0))
    assert oracle.judge(moment, {HP, HN}) == (
        Rose(action=(9.0, 3.0), before=5.0, after=320.0),
        Hurt(name="x1", start=0.0, end=9.0, before=5.0, after=320.0),
    )
    moment = proposed(world, (1.0, 4.0))
    fell, helped, hurt = oracle.judge(moment, {HP, HN})
    assert fell == Fell(action=(1.0, 4.0), before=320.0, after=5.0)
    assert helped == Helped(name="x1", start=9.0, end=1.0, before=320.0, after=0.0)
    assert hurt == Hurt(name="x2", start=3.0, end=4.0, before=320.0, after=389.0)


def test_ties_and_staying_are_passed_over():
    world = Optimization("RotatedHyperEllipsoid")
    oracle = engaged(world, 0)
    proposed(world, (1.0, 2.0))
    assert oracle.judge(proposed(world, (1.0, 2.0)), {HP, HN}) == ()
    assert oracle.judge(proposed(world, (-1.0, -2.0)), {HP, HN}) == ()


def test_success_is_praised_and_kept():
    world = Optimization("Booth")
    oracle = engaged(world, 0)
    moment = proposed(world, (1.0, 3.0))
    said = oracle.judge(moment)
    assert Reached(action=(1.0, 3.0), loss=0.0) in said
    assert Stay(action=(1.0, 3.0)) in said
    (warning,) = (claim for claim in said if type(claim) is Avoid)
    assert warning.loss > warning.now == 0.0


def test_nothing_to_warn_of_where_the_loss_is_greatest():
    world = Optimization("Booth")
    oracle = engaged(world, 0)
    assert oracle.judge(proposed(world, (-10.0, -10.0)), {FN}) == ()


@pytest.mark.parametrize(
    "options",
    [{"shift": True}, {"loss": steep, "domain": (-1, 1)}, {"loss": steep, "domain": ((-2, 1), (-1, 1)), "shift": True}],
    ids=("shift", "own", "own and shift"),
)
def test_the_kit_accepts_shifts_and_own_losses(options):
    check_oracle(
        Pupil(lambda: FAMILY.make_world(**options), FAMILY.make_teacher, max_turns=10, turns=amount(20, full=60))
    )


def test_advice_for_a_loss_of_ones_own():
    world = Optimization(steep, domain=(-1, 1))
    for seed in range(50):
        oracle = engaged(world, seed)
        moment = opening(world)
        for turn in range(1, 11):
            moment = proposed(world, oracle.judge(moment, {FP})[0].action, turn)
        assert moment.after.y - world.minimum <= TOLERANCE


NUMBERS = (
    st.floats(-1e6, 1e6)
    | st.floats(-100, 100)
    | st.integers(-(10**8), 10**8).map(lambda i: i / 1e7)
    | st.floats(-1e-20, 1e-20)
)
TIES = st.builds(lambda i, power: (i + 0.5) * 10.0**power, st.integers(100_000, 999_999), st.integers(-12, 3))


@given(st.lists(NUMBERS | TIES, min_size=1, max_size=30))
def test_six_digits_are_those_of_pythons_format(numbers):
    expected = [float(f"{number:.6g}") for number in numbers]
    assert six_digits(np.array(numbers, float)).tolist() == expected


@pytest.mark.parametrize(
    "domain",
    [((-1 / 3, 2 / 3),) * 2, (1e-5 / 3, 2e9 / 3), (1 + 1e-7, 1 + 3e-7), ((-2 / 3, -1 / 3), (0.1, 0.7)), (-10, 10)],
)
def test_bounds_that_are_said_can_be_played(domain):
    world = Optimization(bowl, domain=domain)
    oracle = engaged(world, 0)
    (said,) = (claim for claim in oracle.brief(world.truth, "b") if isinstance(claim, Answer))
    assert said.holds(opening(world), world.scratch())
    texts = [*FAMILY.phrasebook().sentences(said), world.action_syntax]
    claims = oracle.judge(opening(world))
    areas = [area for each in claims for area in each.coarser(opening(world), world.scratch()) if type(area) is Area]
    for area in areas:
        assert area.holds(opening(world), world.scratch())
        texts += FAMILY.phrasebook().sentences(area)
    for text in texts:
        low1, high1, low2, high2 = _bounds_in(text)
        assert world.legal([low1, low2]) == (low1, low2)
        assert world.legal(f"x = [{high1!r}, {high2!r}]") == (high1, high2)
    width = world.highs[0] - world.lows[0]
    assert (said.low1, said.high1) == pytest.approx((world.lows[0], world.highs[0]), rel=1e-5, abs=width / 100)
    for name in ("low1", "high1", "low2", "high2"):
        for change in (-0.1 * width, 0.1 * width):
            false = dataclasses.replace(said, **{name: getattr(said, name) + change})
            assert not false.holds(opening(world), world.scratch())


def _bounds_in(text):
    """The numbers after x1 and x2 in a text."""
    found = re.findall(
        r"x([12]) (?:from |is |is from |may be |lies between |within |between )?(\S+) (?:to|and) (\S+)", text
    )
    assert [number for number, _, _ in found] == ["1", "2"], text
    return [float(bound.rstrip(".,;)")) for _, low, high in found for bound in (low, high)]


def bowl(x1, x2):
    return x1**2 + x2**2
