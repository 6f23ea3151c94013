"""The car park: highway-env's results to the last bit, exact restoring, and actions."""

import math

import gymnasium
import numpy as np
import pytest
from design import amount

from worlds.parking import Car, Parking
from worlds.testing import plain


def wild(rng, push):
    """Actions that drive about and into things."""
    return np.clip(push + rng.normal(0, 0.4, 2), -1, 1).astype(np.float32)


LONG = [pytest.param(*each, marks=pytest.mark.full) for each in ((0, 2000), (10, 80), (26, 40))]


@pytest.mark.parametrize(
    ("count", "steps"),
    [(0, 180), (10, 60), *LONG],
)
def test_results_are_highway_envs(count, steps):
    """Over many random steps, beyond crashes and parking, too."""
    theirs = gymnasium.make("highway_env:parking-v0", config={"vehicles_count": count}).unwrapped
    ours = Parking(count)
    rng = np.random.default_rng(count)
    done = seed = crashes = 0
    while done < steps:
        seed += 1
        assert plain(dict(theirs.reset(seed=seed)[0])) == plain(ours.reset(seed=seed)[0])
        push = rng.uniform(-1, 1, 2) * (seed % 2)
        for _ in range(60):
            action = wild(rng, push)
            seen, *outcome, info = theirs.step(action)
            our_seen, *our_outcome, our_info = ours.step(action)
            done += 1
            assert plain(dict(seen)) == plain(our_seen)
            assert outcome == our_outcome
            assert our_info.pop("success") == (info["is_success"] and not info["crashed"])
            assert info.keys() == our_info.keys()
            assert all(np.array_equal(info[key], our_info[key]) for key in info)
            crashes += info["crashed"]
            if outcome[1] and rng.random() < 0.1:
                break
    assert crashes > 0


@pytest.mark.parametrize("count", [0, 10])
def test_restoring_is_exact_at_any_moment(count):
    """Around crashes, too, when an impact is pending and other cars are pushed."""
    world = Parking(count)
    lab = world.scratch()
    rng = np.random.default_rng(0)
    pending = 0
    for seed in range(amount(6, full=12)):
        world.reset(seed=seed)
        push = rng.uniform(-1, 1, 2)
        for _ in range(70):
            truth, action = world.truth, wild(rng, push)
            pending += truth.car.impact is not None
            expected = plain(world.step(action)), world.truth
            lab.restore(truth)
            assert lab.truth == truth
            assert (plain(lab.step(action)), lab.truth) == expected
    assert pending > 0


def test_a_pending_impact_is_a_crash_whatever_is_done():
    world = Parking()
    world.reset(seed=0)
    world.restore(world.truth._replace(car=Car(31.9, 0.0, 0.0, 2.0)))
    world._lot._simulate(np.zeros(2, np.float32))
    truth = world.truth
    assert truth.car.crashed or truth.car.impact is not None
    for action in ((-1.0, 0.0), (-1.0, 1.0), (-1.0, -1.0)):
        world.restore(truth)
        assert world.step(action)[4]["crashed"]


def test_parking_takes_the_nose_and_no_crash():
    world = Parking()
    world.reset(seed=3)
    truth = world.truth
    x, y, heading = truth.spot
    for turn, speed, success in ((0.0, 0.0, True), (0.0, 5.0, True), (math.pi, 0.0, False)):
        world.restore(truth._replace(car=Car(x, y - math.copysign(1.0, y), heading + turn, speed)))
        _, _, terminated, _, info = world.step((0.0, 0.0))
        assert info["success"] == info["is_success"] == terminated == success
    world.restore(truth._replace(car=truth.car._replace(x=x, y=y, heading=heading, crashed=True)))
    _, reward, terminated, _, info = world.step((0.0, 0.0))
    assert (terminated, info["is_success"], info["success"]) == (True, True, False)
    assert reward == -5


def test_five_hundred_steps_truncate():
    world = Parking()
    world.reset(seed=0)
    world.restore(world.truth._replace(time=99.9))
    assert world.step((0.0, 0.0))[3]


@pytest.mark.parametrize("wrong", [(1.5, 0.0), (0.0, float("nan")), (0.0,), (True, 0.0), "0, 0", ("0", "1"), 3])
def test_bad_actions(wrong):
    world = Parking()
    world.reset(seed=0)
    truth = world.truth
    with pytest.raises(ValueError, match="two numbers from -1 to 1; the state is unchanged"):
        world.step(wrong)
    assert world.truth == truth


@pytest.mark.parametrize("count", [-1, 27, 1.5, True])
def test_bad_counts(count):
    with pytest.raises(ValueError, match="vehicles_count must be an integer from 0 to 26, got"):
        Parking(count)


def test_description_shows_other_cars():
    world = Parking(3)
    observation, _ = world.reset(seed=1)
    car, spot, others = world.describe(observation).splitlines()
    assert car.startswith("Car: x = 0.00 m, y = 0.00 m, heading")
    assert spot.startswith(f"Spot: x = {world.truth.spot.x:.2f} m")
    assert others.count("(") == 4  # "(x, y)" and three places
