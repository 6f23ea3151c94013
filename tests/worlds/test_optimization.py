"""The losses and their derivatives, the shift, own losses, rewards and text forms."""

import copy
import math
import pickle
from itertools import product

import numpy as np
import pytest

from worlds.optimization import LOSSES, TOLERANCE, Landscape, Optimization

VARIANTS = [(name, choice) for name, variants in LOSSES.items() for choice in range(1, len(variants) + 1)]
PUBLISHED = {  # minima as the literature gives them; McCormick's on LLF-Bench's square lies at its edge
    "Booth": 0.0,
    "McCormick": -1.9105,
    "Rosenbrock": 0.0,
    "SixHumpCamel": -1.0316,
    "Bohachevsky": 0.0,
    "RotatedHyperEllipsoid": 0.0,
    "Matyas": 0.0,
    "ThreeHumpCamel": 0.0,
}


def bowl(x1, x2):
    return (x1 - 0.5) ** 2 + 3 * (x2 + 0.25) ** 2 + 2


def bowl_gradient(x1, x2):
    return 2 * (x1 - 0.5), 6 * (x2 + 0.25)


def two_wells(x1, x2):
    return (x1**2 - 1) ** 2 + x2**2


def started(*args, seed=0, **kwargs):
    world = Optimization(*args, **kwargs)
    world.reset(seed=seed)
    return world


def points(world, count=200, seed=0):
    rng = np.random.default_rng(seed)
    return [tuple(world.sample_action(rng).tolist()) for _ in range(count)]


@pytest.mark.parametrize(("name", "choice"), VARIANTS)
@pytest.mark.parametrize("shift", [False, True])
def test_derivatives_are_those_of_the_loss(name, choice, shift):
    world = started(name, shift, choice)
    land = Landscape(world.loss, world.truth.shift)
    for x1, x2 in points(world):
        h = 1e-6 * max(1.0, abs(x1), abs(x2))
        if any(abs(x - s - edge) < 2 * h for x, s in ((x1, land.shift[0]), (x2, land.shift[1])) for edge in world.lows):
            continue  # at a reflecting edge there is no derivative
        gradient = [
            (land.value(x1 + h, x2) - land.value(x1 - h, x2)) / (2 * h),
            (land.value(x1, x2 + h) - land.value(x1, x2 - h)) / (2 * h),
        ]
        assert land.gradient(x1, x2) == pytest.approx(gradient, rel=1e-4, abs=1e-3)
        up, down = land.gradient(x1 + h, x2), land.gradient(x1 - h, x2)
        right, left = land.gradient(x1, x2 + h), land.gradient(x1, x2 - h)
        hessian = [(up[0] - down[0]) / (2 * h), (up[1] - down[1]) / (2 * h), (right[1] - left[1]) / (2 * h)]
        assert land.hessian(x1, x2) == pytest.approx(hessian, rel=1e-4, abs=1e-3)


@pytest.mark.parametrize(("name", "choice"), VARIANTS)
def test_nothing_is_less_than_the_minimum(name, choice):
    world = started(name, func_choice=choice)
    loss = world.loss
    assert loss.minimum == pytest.approx(PUBLISHED[name], abs=1e-4)
    grid = product(*(np.linspace(low, high, 301).tolist() for low, high in zip(loss.lows, loss.highs, strict=True)))
    assert all(loss.value(*point) >= loss.minimum - 1e-12 for point in grid)
    for minimiser in loss.minimisers:
        assert loss.value(*minimiser) == pytest.approx(loss.minimum, abs=1e-12)
        _, reward, _, _, info = world.step(minimiser)
        assert info["success"]
        assert reward == world.reward_range[1]


def test_values_that_the_literature_gives():
    value = {name: variants[0].value for name, variants in LOSSES.items()}
    assert value["Booth"](0, 0) == 74
    assert value["Rosenbrock"](0, 2) == 5
    assert value["McCormick"](-0.54719, -1.54719) == pytest.approx(-1.9133, abs=1e-4)
    assert value["Matyas"](1, 1) == pytest.approx(0.04)
    assert value["RotatedHyperEllipsoid"](1, 2) == 6
    assert value["ThreeHumpCamel"](1, 0) == pytest.approx(2 - 1.05 + 1 / 6)
    assert value["SixHumpCamel"](0.0898, -0.7126) == pytest.approx(-1.0316, abs=1e-4)
    assert value["Bohachevsky"](0, 0) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("name", LOSSES)
def test_rewards_are_llf_benchs(name):
    world = started(name)
    corner = max(world.loss.value(*c) for c in product(*zip(world.lows, world.highs, strict=True)))
    for point in points(world):
        observation, reward, terminated, truncated, info = world.step(np.array(point))
        y = world.loss.value(*point)
        assert reward == pytest.approx(np.clip(-y, -corner, -world.minimum) / 100)
        assert observation["y"].tolist() == [y]
        assert tuple(observation["x"].tolist()) == point
        assert info["success"] == (y <= world.minimum + TOLERANCE)
        assert not terminated
        assert not truncated
        assert world.failure_reward == max(reward - 0.01, world.reward_range[0])


def test_the_failure_reward_stays_in_the_range():
    world = Optimization(bowl, domain=(-1, 1), minimiser=(0.5, -0.25))
    low, high = world.reward_range
    assert high == -0.02
    for point in ((-1, -1), (1, 1), (0.5, -0.25)):
        world.reset(seed=0)
        world.step(np.array(point))
        assert low <= world.failure_reward < high


@pytest.mark.parametrize("name", LOSSES)
def test_a_shift_moves_the_minimum_within_the_domain(name):
    seen = set()
    for seed in range(50):
        world = started(name, shift=True, seed=seed)
        truth, land = world.truth, Landscape(world.loss, world.truth.shift)
        seen.add(truth.shift)
        for minimiser in land.minimisers():
            assert world.step(minimiser)[1] == pytest.approx(world.reward_range[1], abs=1e-9)
        for i, (low, high) in enumerate(zip(world.lows, world.highs, strict=True)):
            assert abs(truth.shift[i]) <= 0.2 * (high - low)
            assert low <= world.loss.minimisers[0][i] + truth.shift[i] <= high
        assert all(land.value(*point) >= world.minimum - 1e-9 for point in points(world, 50))
    assert len(seen) == 50


def test_the_observation_does_not_tell_the_shift():
    world = started(shift=True)
    observation, _ = world.reset(seed=1)
    assert set(observation) == {"x", "y"}
    assert world.describe(observation) == f"x = [0.236432, 9.00927]\ny = {world.truth.y:.6g}"


@pytest.mark.parametrize("gradient", [None, bowl_gradient])
@pytest.mark.parametrize("minimiser", [None, (0.5, -0.25)])
@pytest.mark.parametrize("shift", [False, True])
def test_a_loss_of_ones_own(gradient, minimiser, shift):
    world = started(bowl, shift, gradient=gradient, minimiser=minimiser, domain=((-1, 2), (-1, 1)))
    assert world.loss.minimisers == (pytest.approx((0.5, -0.25), abs=1e-5),)
    assert world.minimum == pytest.approx(2, abs=1e-9)
    assert world.lows == (-1, -1)
    assert world.highs == (2, 1)
    assert world.loss.gradient(1.0, 0.5) == pytest.approx((1, 4.5), abs=1e-6)
    assert world.loss.hessian(1.0, 0.5) == pytest.approx((2, 0, 6), abs=1e-3)
    assert world.loss.hessian(2.0, -1.0) == pytest.approx((2, 0, 6), abs=0.1)
    for copied in (copy.deepcopy(world), pickle.loads(pickle.dumps(world)), world.scratch()):
        copied.restore(world.save())
        assert copied.step([0.0, 0.0])[1] == world.step([0.0, 0.0])[1]


def test_all_minimisers_of_ones_own_are_found():
    world = Optimization(two_wells, domain=(-3, 3))
    assert sorted(world.loss.minimisers) == [pytest.approx((-1, 0), abs=1e-4), pytest.approx((1, 0), abs=1e-4)]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"loss": "Ackley"}, "loss 'Ackley' is unknown; allowed: Booth, McCormick"),
        ({"func_choice": 2}, "func_choice must be an integer from 1 to 1 for Booth, got 2"),
        ({"loss": "Bohachevsky", "func_choice": 4}, "from 1 to 3 for Bohachevsky, got 4"),
        ({"loss": bowl, "func_choice": 2, "domain": (0, 1)}, "func_choice applies to Bohachevsky only, got 2"),
        ({"shift": "yes"}, "shift must be True or False, got 'yes'"),
        ({"domain": (0, 1)}, "domain applies to custom functions only, got .* for Booth; allowed: None"),
        ({"loss": bowl}, r"domain of a custom function must be \(low, high\) or .* got None"),
        ({"loss": bowl, "domain": (1, 0)}, "with low < high"),
        ({"loss": bowl, "domain": (0, math.inf)}, "with low < high"),
        ({"loss": bowl, "domain": (-1, 1), "minimiser": (5, 0)}, "minimiser must be a point of the domain"),
        ({"loss": bowl, "domain": (-1, 1), "minimiser": (0, 0)}, "minimiser must be the point of least loss, got"),
        ({"loss": lambda x1, x2: math.inf, "domain": (-1, 1)}, "the loss must be finite on its domain"),
    ],
)
def test_bad_options(options, message):
    with pytest.raises(ValueError, match=message):
        Optimization(**options)


@pytest.mark.parametrize(
    "action", [[1, 2], (1.0, 2.0), np.array([1, 2]), np.array([1, 2], np.float32), [np.float64(1), np.int64(2)]]
)
def test_canonical_actions(action):
    legal = Optimization().legal(action)
    assert legal == (1.0, 2.0)
    assert [type(x) for x in legal] == [float, float]


@pytest.mark.parametrize("action", [[-0.0, -0.0], np.array([-0.0, -0.0]), "[-0, -0.0]"])
def test_a_negative_zero_is_zero(action):
    world = started()
    assert str(world.legal(action)) == "(0.0, 0.0)"
    assert world.describe(world.step(action)[0]).startswith("x = [0, 0]\n")


@pytest.mark.parametrize(
    "action",
    [
        *([math.nan, 0], [0, math.inf], [10.001, 0], [0, -11], [1], [1, 2, 3], [[1, 2]], [True, False], ["1", "2"]),
        *(np.zeros((1, 2)), np.array([math.nan, 1]), np.array(["1", "2"]), 1.0, {"x": 1}, [10**400, 0], [1j, 0]),
        *("x = [1, 2, 3]", "x = [11, 0]", "up", ""),
    ],
)
def test_what_is_no_action_is_refused(action):
    world = started()
    before = world.truth
    with pytest.raises(ValueError, match=r"not in the action space; allowed: x = \[x1, x2\] .* the state is unchanged"):
        world.step(action)
    assert world.truth == before


@pytest.mark.parametrize(
    ("text", "point"),
    [
        ("x = [1, 2]", (1, 2)),
        ("x=[ -1.5 ,+2e-1 ]", (-1.5, 0.2)),
        ("[.5, 2.]", (0.5, 2)),
        ("(1, 2)", (1, 2)),
        ("x: (1, 2).", (1, 2)),
        ("I propose x = [1, 2]", None),
        ("from [0, 0] to [1, 2]", None),
        ("[1, 2, 3]", None),
        ("[[1, 2]]", None),
        ("[1_0, 2]", None),
        ("[nan, inf]", None),
        ("[0x1, 2]", None),
        ("[1 2]", None),
        ("[\u0661, \u0662]", None),
        ("f[1, 2]", None),
        ("[__import__('os'), 2]", None),
        ("stop", "here"),
        ("Stay.", "here"),
        ("reached the minimum", "here"),
        ("stop [1, 2, 3]", None),
        ("unstoppable", None),
        ("", None),
    ],
)
def test_reading(text, point):
    world = started()
    assert world.read(text) == (world.truth.x if point == "here" else point)


def test_staying_before_the_first_reset_is_no_action():
    assert Optimization().read("stay") is None
