"""Meta-World: the same results as metaworld's own, snapshots that are exact, turns that end when they should."""

import copy
import json
import pickle

import numpy as np
import pytest
from design import amount
from opengl import run, with_opengl

from worlds.metaworld import (
    CONTROLS,
    LONGEST,
    LONGEST_BY_EVENT,
    SHORTEST,
    TASKS,
    TRAVEL,
    MetaWorld,
    Script,
    Simulator,
)
from worlds.testing import plain

SAMPLE = ("bin-picking-v3", "door-lock-v3", "drawer-open-v3", "pick-place-v3", "stick-push-v3")
EVERY_TASK = [pytest.param(task, marks=() if task in SAMPLE else pytest.mark.full) for task in TASKS]


def original(task, variation):
    """metaworld's environment as its benchmarks make it, after a reset."""
    from metaworld.env_dict import ALL_V3_ENVIRONMENTS
    from metaworld.types import Task

    cls = ALL_V3_ENVIRONMENTS[task]
    env = cls()
    settings = {"env_cls": cls, "rand_vec": np.array(variation), "partially_observable": False}
    env.set_task(Task(task, pickle.dumps(settings)))
    return env, env.reset()[0]


def commands(script, observation, rng):
    """A mixture of the scripted policy and noise, so that things are touched and moved."""
    command = script.command(tuple(observation.tolist())).astype(float)
    return np.clip(command if rng.random() < 0.7 else rng.uniform(-1, 1, 4), -1, 1)


@pytest.mark.parametrize("task", EVERY_TASK)
def test_low_level_steps_are_metaworlds_to_the_last_bit(task):
    simulator, script, rng = Simulator(task), Script(task), np.random.default_rng(3)
    for seed in range(amount(1, full=2)):
        truth = simulator.reset(np.random.default_rng(seed))
        env, observation = original(task, truth.episode.variation)
        assert truth.observation == tuple(observation.tolist())
        for _ in range(150):
            command = commands(script, observation, rng)
            observation, reward, _, _, info = env.step(command)
            ours = simulator.env.step(command)
            assert ours[0].tobytes() == observation.tobytes()
            assert ours[1] == reward
            assert 0 <= reward <= 10
            assert {name: float(value) for name, value in ours[4].items()} == {
                name: float(value) for name, value in info.items()
            }


@pytest.mark.parametrize("task", EVERY_TASK)
def test_a_snapshot_is_the_whole_state(task):
    """From a snapshot in the middle of an episode everything goes on alike, in another simulator, too."""
    script, rng = Script(task), np.random.default_rng(4)
    simulator, other = Simulator(task), Simulator(task)
    observation = np.array(simulator.reset(np.random.default_rng(5)).observation)
    for _ in range(60):
        observation = simulator.env.step(commands(script, observation, rng))[0]
    middle = simulator.truth(tuple(observation.tolist()), False)
    played = []
    for _ in range(60):
        command = commands(script, observation, rng)
        observation, reward, *_ = simulator.env.step(command)
        played.append((command, observation.tobytes(), reward))
    end = simulator.truth(tuple(observation.tolist()), False)
    other.reset(np.random.default_rng(6))
    other.env.step(np.ones(4))
    for each, truth in ((simulator, middle), (other, pickle.loads(pickle.dumps(middle)))):
        each.load(truth)
        for command, expected, reward in played:
            observation, again, *_ = each.env.step(command)
            assert (observation.tobytes(), again) == (expected, reward)
        assert each.truth(tuple(observation.tolist()), False) == end


@pytest.mark.parametrize("task", EVERY_TASK)
def test_a_reset_is_that_of_a_new_simulator_and_holds_the_hand_once_at_most(task, monkeypatch):
    """metaworld's own reset holds it for 50 steps, three times in all."""
    used = Simulator(task)
    held = []
    hold = type(used.env).do_simulation
    monkeypatch.setattr(type(used.env), "do_simulation", lambda *args: held.append(args) or hold(*args))
    for seed in range(3):
        held.clear()
        truth = used.reset(np.random.default_rng(seed))
        assert len(held) <= 52
        used.env.step(np.ones(4))
        assert Simulator(task).reset(np.random.default_rng(seed)) == truth


@pytest.mark.parametrize("control", CONTROLS)
def test_what_is_foreseen_is_what_comes(control):
    world, other = MetaWorld("pick-place-v3", control), MetaWorld("pick-place-v3", control)
    world.reset(seed=2)
    other.reset(seed=3)
    rng = np.random.default_rng(1)
    for _ in range(5):
        action, begun = world.legal(world.sample_action(rng)), other.truth
        hand, solved = other.foresee(world.truth, action)
        assert other.truth is begun
        world.advance(action)
        assert (hand, solved) == (world.truth.observation[:3], world.truth.solved)


def test_worlds_of_a_task_do_not_disturb_each_other():
    def episode(others):
        world = MetaWorld("pick-place-v3")
        world.reset(seed=1)
        rng, seen = np.random.default_rng(0), []
        for _ in range(6):
            for other in others:
                other.step(other.sample_action(rng_of_others))
            seen.append(plain(world.step(world.sample_action(rng))))
        return seen

    rng_of_others = np.random.default_rng(9)
    others = [MetaWorld("pick-place-v3"), MetaWorld("reach-v3")]
    for other in others:
        other.reset(seed=8)
    assert episode(others) == episode([])


def test_threads_have_simulators_of_their_own():
    from concurrent.futures import ThreadPoolExecutor

    def play(seed):
        world = MetaWorld("reach-v3")
        world.reset(seed=seed)
        rng = np.random.default_rng(seed)
        return [plain(world.step(world.sample_action(rng))) for _ in range(5)]

    with ThreadPoolExecutor(3) as pool:
        assert list(pool.map(play, range(6))) == [play(seed) for seed in range(6)]


def low_level_steps(world, action):
    """How many a turn takes."""
    before = world.truth.passing[0]
    world.step(action)
    return world.truth.passing[0] - before


def test_a_turn_ends_when_the_hand_has_gone_far_or_long():
    world = MetaWorld("drawer-open-v3")
    world.reset(seed=0)
    hand = np.array(world.truth.observation[:3])
    steps = low_level_steps(world, [hand[0] + 0.3, hand[1], hand[2], -1])
    moved = np.abs(np.array(world.truth.observation[:3]) - hand).max()
    assert SHORTEST <= steps < LONGEST
    assert TRAVEL < moved < 2 * TRAVEL
    hand = world.truth.observation[:3]
    assert low_level_steps(world, [hand[0] + 0.02, *hand[1:], 1]) == LONGEST


def test_a_teachers_event_ends_a_turn():
    """The scripted policy aims at another place once the hand is above the handle."""
    world = MetaWorld("drawer-open-v3", control="teacher_event")
    world.reset(seed=0)
    first = world.script.aim(world.truth.observation)
    steps = low_level_steps(world, world.legal([*first.target, first.grip]))
    then = world.script.aim(world.truth.observation)
    assert steps == LONGEST_BY_EVENT or max(abs(a - b) for a, b in zip(first.target, then.target, strict=True)) > 0.03


def test_success_is_latched():
    world = MetaWorld("reach-v3")
    world.reset(seed=0)
    for _ in range(30):
        aim = world.script.aim(world.truth.observation)
        if world.step([*aim.target, aim.grip])[4]["success"]:
            break
    assert low_level_steps(world, [*aim.target, aim.grip]) >= SHORTEST  # to solve it again ends no turn
    assert world.step([0, 0.4, 0.5, -1])[4]["success"]
    assert world.step([0, 0.4, 0.5, -1])[4]["success"]


def test_the_original_takes_the_same_low_level_steps():
    world = MetaWorld("door-lock-v3")
    rng = np.random.default_rng(0)
    actions = [world.legal(world.sample_action(rng)) for _ in range(5)]
    original = world.original(actions, 3)
    original.reset()
    world.reset(seed=3)
    for action in actions:
        world.step(action)
        assert tuple(original.step(action)[0].tolist()) == world.truth.observation


def test_relative_targets_are_absolute_ones_less_the_hand():
    absolute, relative = MetaWorld("reach-v3"), MetaWorld("reach-v3", control="relative")
    absolute.reset(seed=2)
    relative.reset(seed=2)
    x, y, z = absolute.truth.observation[:3]
    absolute.step([x + 0.125, y + 0.25, z - 0.0625, 0.5])
    relative.step([0.125, 0.25, -0.0625, 0.5])
    assert absolute.truth.observation == pytest.approx(relative.truth.observation, abs=1e-9)


def test_gain():
    slow, fast = MetaWorld("reach-v3", gain=1), MetaWorld("reach-v3", gain=25.0)
    moved = []
    for world in (slow, fast):
        world.reset(seed=0)
        start = np.array(world.truth.observation[:3])
        low_level_steps(world, [start[0], start[1], start[2] + 0.1, 0])
        moved.append((world.truth.observation[2] - start[2]) / world.truth.passing[0])
    assert moved[0] < moved[1]


@pytest.mark.parametrize("task", ["reach-v3", "stick-push-v3"])
def test_observations_are_named_and_described_as_json(task):
    world = MetaWorld(task)
    observation, _ = world.reset(seed=0)
    told = json.loads(world.describe(observation))
    assert list(told) == list(observation)
    assert ("second_object" in told) == (task == "stick-push-v3")
    for name, value in observation.items():
        assert np.allclose(told[name], value if len(value) > 1 else value.item(), atol=6e-4)


@pytest.mark.parametrize("task", EVERY_TASK)
def test_the_script_needs_nothing_that_is_not_observed(task):
    """What it aims at does not depend on the earlier frame, which observations leave out, nor on the past."""
    world = MetaWorld(task)
    world.reset(seed=0)
    rng = np.random.default_rng(0)
    for _ in range(10):
        seen = world.truth.observation
        aim = world.script.aim((*seen[:18], *[0.0] * 18, *seen[36:]))
        assert aim == Script(task).aim(seen) == world.script.aim(seen)
        assert max(map(abs, aim.target)) <= 2
        world.step([*aim.target, aim.grip] if rng.random() < 0.7 else world.sample_action(rng))


def test_metaworlds_modules_stay_as_they_are():
    from metaworld.policies import sawyer_reach_v3_policy as module

    before = dict(vars(module))
    script = Script("reach-v3")
    script.aim((0.0,) * 39)
    assert vars(module) == before
    assert copy.deepcopy(script).aim((0.1,) * 39) == script.aim((0.1,) * 39)


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        ({"task": "juggle-v3"}, "task must be one of assembly-v3.*got 'juggle-v3'"),
        ({"control": "remote"}, "control must be one of absolute, relative, teacher_event, got 'remote'"),
        ({"gain": 0}, "gain must be None or a positive number, got 0"),
        ({"visual": 1}, "visual must be one of False, True, got 1"),
        ({"video": None}, "video must be one of False, True, got None"),
    ],
)
def test_bad_options(arguments, match):
    with pytest.raises(ValueError, match=match):
        MetaWorld(**arguments)


@pytest.mark.parametrize("action", [[0, 0, 0], [0, 0, 0, 2], [3, 0, 0, 0], [np.nan, 0, 0, 0], "up", [True, 0, 0, 0]])
@pytest.mark.parametrize("control", CONTROLS)
def test_bad_actions(action, control):
    world = MetaWorld("reach-v3", control)
    world.reset(seed=0)
    with pytest.raises(ValueError, match=r"allowed: \[x, y, z, grip\]"):
        world.step(action)


IMAGES = """
import numpy as np
from worlds.metaworld import MetaWorld
from worlds.testing import plain

def play(**options):
    world = MetaWorld("reach-v3", **options)
    seen = [world.reset(seed=0)]
    rng = np.random.default_rng(0)
    seen += [world.step(world.sample_action(rng)) for _ in range(3)]
    return world, seen, world.truth

blind, _, truth = play()
seeing, seen, same = play(visual=True, video=True)
assert same == truth
for observation, *_ in seen:
    assert observation in seeing.observation_space
    assert observation["image"].std() > 10
    assert "image" not in seeing.describe(observation)
assert plain(seen[0][0]["image"]) != plain(seen[3][0]["image"])
assert sum(len(each[4]["video"]) for each in seen[1:]) == truth.passing[0]
assert [frame.shape for frame in seen[1][4]["video"]] == [(240, 240, 3)] * len(seen[1][4]["video"])
assert plain(seen[3][4]["video"][-1]) == plain(seen[3][0]["image"])
shown = MetaWorld("reach-v3", render_mode="rgb_array")
shown.reset(seed=0)
assert plain(shown.render()) == plain(seen[0][0]["image"])
print("seen")
"""


TWICE = """
from worlds.metaworld.world import MetaWorld

refused = 0
for task in ("reach-v3", "push-v3"):
    try:
        MetaWorld(task, visual=True).reset(seed=0)
    except RuntimeError as error:
        refused += "images need off-screen OpenGL" in str(error)
print(refused)
"""


def test_images():
    assert with_opengl(IMAGES) == "seen\n"


def test_without_opengl_the_error_says_what_to_do():
    result = run(IMAGES, "glfw")  # which needs a display
    assert "RuntimeError: images need off-screen OpenGL" in result.stderr
    assert "MUJOCO_GL to egl" in result.stderr


def test_without_opengl_it_is_an_error_the_second_time_too():
    result = run(TWICE, "glfw")
    assert result.stdout == "2\n", result.stderr
