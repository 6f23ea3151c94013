"""The oracle of the car park: who obeys it parks, from any state, and what it foresees is what happens."""

import math
import time

import numpy as np
import pytest

from pz_envs.family import all_families
from teachers.atoms import FN, FP, HN, HP, Moment
from teachers.oracles.parking import ParkingOracle
from teachers.oracles.parking.checks import effort_of, parks, stops
from teachers.oracles.parking.claims import (
    Crash,
    Crashed,
    Detour,
    Doomed,
    Drive,
    Hazards,
    Nearer,
    OnCourse,
    Parked,
    Strayed,
    Trap,
)
from teachers.oracles.parking.driving import solve
from teachers.oracles.parking.field import MARGIN, gain_of, turns_left
from teachers.oracles.parking.model import GAIN, STEPS, TOLERANCE, WHEEL, Ground, move
from teachers.testing import Pupil, check_honesty
from worlds.parking import Car, Parking, step_car

FAMILY = next(family for family in all_families() if family.oracle == ParkingOracle.__name__)


def engaged(world, seed=0):
    oracle = ParkingOracle(world.scratch)
    oracle.start(world.truth)
    return oracle


def opening(world):
    return Moment.opening(world.truth)


def turn(world, action):
    before, action = world.truth, world.legal(action)
    _, reward, over, _, info = world.advance(action)
    return Moment(before, action, reward, world.truth, info["success"], 1, over)


def at_random(world, rng):
    """Somewhere at up to 6 m/s, where nothing is touched and the car can be braked in time."""
    lab = world.scratch()
    while True:
        car = Car(rng.uniform(-30, 30), rng.uniform(-17, 17), rng.uniform(-7, 7), rng.uniform(-6, 6))
        truth = world.truth._replace(car=car)
        if stops(lab, truth):
            world.restore(truth)
            return


def obeyed(world, turns=100):
    """Whether a student that does what it is told parks within so many turns, and the number of turns."""
    oracle, moment = engaged(world), opening(world)
    for number in range(1, turns + 1):
        advice = [claim for claim in oracle.judge(moment, {FP}) if type(claim) is Drive]
        if not advice:
            return False, number
        assert all(share == round(share, 2) for share in advice[0].action)
        moment = turn(world, advice[0].action)
        if moment.over:
            return moment.success, number
    return False, turns


def sweep(start, count, seeds):
    """Share of parked cars."""
    world, parked, numbers = Parking(count), 0, []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        world.reset(seed=seed)
        while start == "ten" and any(world.step(world.sample_action(rng))[2] for _ in range(10)):
            world.reset()
        if start == "moving":
            at_random(world, rng)
        success, number = obeyed(world)
        parked += success
        numbers.append(number)
    print(f"{start}, {count} other cars: {parked} of {len(numbers)} parked, in {np.mean(numbers):.1f} turns")
    return parked / len(numbers)


@pytest.mark.parametrize("start", ["start", "ten", "moving"])
def test_who_obeys_parks(start):
    assert sweep(start, 0, range(200, 212)) == 1


def test_who_obeys_parks_among_other_cars():
    assert sweep("start", 10, range(200, 208)) == 1


@pytest.mark.full
@pytest.mark.parametrize(
    ("start", "count", "least"),
    [(start, 0, 0.99) for start in ("start", "ten", "moving")]
    + [(start, 10, 0.95) for start in ("start", "ten", "moving")],
)
def test_who_obeys_parks_on_two_hundred_seeds(start, count, least):
    assert sweep(start, count, range(200)) >= least


def test_the_model_is_the_simulator():
    """From random places a way ends where the model says, after as many actions."""
    world = Parking(6)
    rng = np.random.default_rng(1)
    for seed in range(10):
        world.reset(seed=seed)
        at_random(world, rng)
        oracle, car = engaged(world), world.truth.car[:4]
        ground = oracle._ground(world.truth)
        for action in solve(ground, car):
            car = move(ground, car, *(round(100 * share) for share in action))
            moment = turn(world, action)
            assert moment.after.car[:4] == pytest.approx(car, abs=1e-9)
        assert moment.success


def test_the_steps_of_the_model_are_those_of_the_world():
    """To the last bit, near an obstacle and far from it."""
    rng = np.random.default_rng(8)
    for parked in ((), ((0.0, 9.0),)):
        ground = Ground((28.0, 14.0, 0.0), TOLERANCE, parked, 34.5, 20.5)
        for _ in range(200):
            car = tuple(rng.uniform((-9, -3, -4, -4), (9, 3, 4, 4)).tolist())
            pedal, wheel = rng.integers(-100, 101, 2).tolist()
            there = car
            for _ in range(STEPS):
                course = there[2] + WHEEL[wheel + 100][0]
                there = step_car(*there, math.cos(course), math.sin(course), WHEEL[wheel + 100][1], GAIN[pedal + 100])
            assert move(ground, car, pedal, wheel) in (there, None if parked else there)


def test_a_way_is_over_when_the_car_is_parked():
    """A car that brakes on its way to a path may come to stand in the spot."""
    world = Parking()
    rng = np.random.default_rng(2)
    world.reset(seed=2)
    spot, ground = world.truth.spot, engaged(world)._ground(world.truth)
    for _ in range(150):
        x, y, turn_by, speed = rng.uniform((-4, 0, -0.8, -6), (4, 4, 0.8, 6))
        car = Car(spot[0] + x, spot[1] - math.copysign(y, spot[1]), spot[2] + turn_by, speed)
        way, truth = solve(ground, car[:4]), world.truth._replace(car=car)
        assert not way or parks(world.scratch(), truth, way)


def test_a_way_is_kept_to_while_the_student_does():
    world = Parking()
    world.reset(seed=5)
    oracle, moment = engaged(world), opening(world)
    way, praised = oracle.plan(world.truth, 99), 0
    for left in range(len(way), 0, -1):
        (advice,) = oracle.judge(moment, {FP})
        assert (advice.action, *advice.rest) == way[-left:]
        moment = turn(world, advice.action)
        assert oracle.regret(moment) == 0
        hindsight = oracle.judge(moment, {HP, HN})
        praise = OnCourse(action=advice.action, way=(advice.action, *advice.rest))
        praised += praise in hindsight
        assert {type(claim) for claim in hindsight} <= ({Parked} if left == 1 else {OnCourse, Nearer})
        assert praise.effort == effort_of(left - 1)
    assert praised > 0.75 * len(way)
    assert oracle.judge(moment, {FP, FN}) == ()


@pytest.mark.parametrize("count", [0, 10])
def test_a_moment_has_praise_or_blame_whatever_the_way(count):
    """Of two ways from before an action, one of which begins with it, either verdict could choose."""
    world, rng = Parking(count), np.random.default_rng(count)
    lab, praised, blamed = world.scratch(), 0, 0
    for seed in range(40):
        world.reset(seed=seed)
        at_random(world, rng)
        oracle, action = engaged(world), tuple(rng.uniform(-1, 1, 2).round(2).tolist())
        way = oracle.plan(world.truth, 99)
        moment = turn(world, action)
        ways = way, (action, *solve(oracle._ground(moment.after), moment.after.car[:4]))
        good, bad = (
            any(verdict(action=action, way=each).holds(moment, lab) for each in ways) for verdict in (OnCourse, Strayed)
        )
        assert not (good and bad)
        praised, blamed = praised + good, blamed + bad
    assert min(praised, blamed) >= 5


def test_the_field_foresees_how_long_plans_are():
    """It knows no plans, but agrees with their lengths; and with what is plain near the spot."""
    world, rng = Parking(), np.random.default_rng(3)
    left, lengths = [], []
    for seed in range(60):
        world.reset(seed=seed)
        at_random(world, rng)
        left.append(turns_left(world.truth))
        lengths.append(len(engaged(world).plan(world.truth, 99)))
    assert np.corrcoef(left, lengths)[0, 1] > 0.95
    assert 0.8 < np.mean(left) / np.mean(lengths) < 1.25
    for seed in range(8):
        world.reset(seed=seed)
        x, y, heading = world.truth.spot
        before = Car(x, y - math.copysign(9.0, y), heading, 2.0)
        there = world.truth._replace(car=before)
        assert gain_of(there, there._replace(car=before._replace(speed=3.0))) > MARGIN
        assert gain_of(there, there._replace(car=before._replace(speed=1.0))) < -MARGIN
        aside, mirrored = (before._replace(x=x + side, heading=heading + side / 20) for side in (3.0, -3.0))
        assert gain_of(there._replace(car=aside), there) > MARGIN
        assert turns_left(there._replace(car=aside)) == pytest.approx(turns_left(there._replace(car=mirrored)))
        assert turns_left(there._replace(car=before._replace(heading=heading + math.pi))) > 2 * turns_left(there)


def test_warnings_in_front_of_a_wall():
    """A crash at once, then one that cannot be averted, then a way round."""
    world = Parking()
    world.reset(seed=0)
    lab = world.scratch()
    for x, expected in ((31.7, Crash), (28.5, Trap), (0.0, Detour)):
        world.restore(world.truth._replace(car=Car(x, 0.0, 0.0, 5.0 if x else 0.0)))
        (warning,) = engaged(world).judge(opening(world), {FN})
        assert type(warning) is expected
        assert warning.holds(opening(world), lab)


def test_a_crash_is_named_and_so_is_the_action_that_led_to_it():
    world = Parking()
    world.reset(seed=0)
    lab = world.scratch()
    said = []
    world.restore(world.truth._replace(car=Car(24.0, 0.0, 0.0, 6.0)))
    oracle, moment = engaged(world), opening(world)
    while not moment.after.car.crashed:
        moment = turn(world, (1.0, 0.0))
        said += oracle.judge(moment, {HP, HN})
        assert all(claim.holds(moment, lab) for claim in oracle.judge(moment, {HP, HN}))
    kinds = [type(claim) for claim in said]
    assert kinds.index(Doomed) < kinds.index(Crashed) == len(kinds) - 1
    assert oracle.judge(moment, {FP, FN}) == ()
    assert oracle.importance(moment.after) == 0
    assert oracle.plan(moment.after, 5) == ()


def test_whether_braking_helps_is_mostly_known_without_the_simulator(monkeypatch):
    asked = []

    def ask(lab, truth, wheels):
        asked.extend(wheels)
        return stops(lab, truth, wheels)

    monkeypatch.setattr("teachers.oracles.parking.stops", ask)
    rng, answers = np.random.default_rng(4), []
    for count in (0, 10):
        world = Parking(count)
        world.reset(seed=count)
        oracle, lab = engaged(world), world.scratch()
        for _ in range(100):
            car = Car(*rng.uniform((26, -17, -7, -7), (33, 17, 7, 8)))
            truth = world.truth._replace(car=car)
            answers.append(oracle._stops(truth))
            assert answers[-1] == stops(lab, truth)
    assert 50 < sum(answers) < 170
    assert 0 < len(asked) < 50  # of 1,000 ways to brake


def test_hints_are_true_and_say_less():
    world = Parking()
    lab = world.scratch()
    for seed in range(5):
        world.reset(seed=seed)
        moment = opening(world)
        (advice,) = engaged(world).judge(moment, {FP})
        hints = advice.coarser(moment, lab)
        assert len(hints) == 2
        for hint in hints:
            assert hint.kind is FP
            assert hint.holds(moment, lab)
            assert not hasattr(hint, "action")
            assert not any(false.holds(moment, lab) for false in hint.counterparts(moment, lab))


def test_claims_among_other_cars_hold():
    check_honesty(Pupil(lambda: Parking(10), FAMILY.make_teacher, max_turns=40, turns=40))


def test_advice_costs_few_steps():
    """In steps of the simulator, measured in the same run: a new plan takes less than 150 of them, on average."""
    world = Parking()
    planning = driving = 0.0
    for seed in range(30):
        world.reset(seed=1000 + seed)
        begin = time.process_time()
        engaged(world).judge(opening(world), {FP})
        planned = time.process_time()
        for _ in range(20):
            world.step((0.1, 0.3))
        planning, driving = planning + planned - begin, driving + (time.process_time() - planned) / 20
    print(f"a plan takes as long as {planning / driving:.0f} steps")
    assert planning < 150 * driving


def test_headings_may_be_of_any_number_of_turns():
    world = Parking()
    world.reset(seed=0)
    truth = world.truth
    ways = []
    for turns in (0, 1, -3):
        car = truth.car._replace(heading=truth.car.heading + turns * 2 * math.pi)
        world.restore(truth._replace(car=car))
        ways.append(len(engaged(world).plan(world.truth, 99)))
    assert min(ways) > 0
    assert max(ways) - min(ways) <= 2


@pytest.mark.parametrize("others", [0, 10, 20, 26])
def test_the_instruction_holds_among_other_cars(others):
    """Walls and cars are where they are said to be, wherever the others are parked; and nowhere else."""
    world = Parking(vehicles_count=others)
    lab = world.scratch()
    for seed in range(10):
        world.reset(seed=seed)
        moment = opening(world)
        assert all(claim.holds(moment, lab) for claim in engaged(world).brief(world.truth, "b"))
        for x, y in ((34.6, 20.5), (34.4, 20.5), (34.5, 20.6), (34.5, 20.4)):
            assert not Hazards(wall_x=x, wall_y=y).holds(moment, lab)
