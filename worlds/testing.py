"""A conformance kit for worlds. For your own world, run `check_world(MyWorld)`.

Each check takes a factory of worlds and raises an AssertionError that describes the error.
"""

import copy
import pickle
import random
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from gymnasium import spaces

from worlds.world import World
from worlds.world import plain as plain  # part of what the kit offers

Make = Callable[[], World[Any]]
_STEPS = 40


def check_world(make: Make) -> None:
    """Run every check."""
    for check in CHECKS:
        check(make)


def require(condition: Any, message: str) -> None:
    """Raise an AssertionError unless the condition holds."""
    if not condition:
        raise AssertionError(message)


def started(make: Make, seed: int = 0) -> World[Any]:
    """A new world after `reset(seed)`."""
    world = make()
    world.reset(seed=seed)
    return world


def trace(world: World[Any], actions: list[Any]) -> list[Any]:
    """The results and truths of a sequence of actions, comparable with `==`."""
    return [(*map(plain, world.step(action)), plain(world.truth)) for action in actions]


def some_actions(world: World[Any], count: int = _STEPS, seed: int = 1) -> list[Any]:
    """Random actions of a world."""
    rng = np.random.default_rng(seed)
    return [world.sample_action(rng) for _ in range(count)]


def check_spaces(make: Make) -> None:
    """Observations are in their space; sampled actions are in theirs and legal, also in canonical form.

    Discrete actions are numbered from 0, so that an action is its own index among values.
    """
    world = make()
    space = world.action_space
    require(
        not isinstance(space, spaces.Discrete) or space.start == 0,
        f"the actions of {space} are not numbered from 0; number them from 0, as values are, and let "
        "`action_words` and `describe` say other numbers",
    )
    observation, _ = world.reset(seed=0)
    for action in some_actions(world):
        require(observation in world.observation_space, f"observation {observation!r} is not in the observation space")
        require(action in world.action_space, f"sample_action returned {action!r}, which is not in the action space")
        canonical = world.legal(action)
        require(plain(world.legal(canonical)) == plain(canonical), f"legal({canonical!r}) changes a canonical action")
        observation = world.step(action)[0]
    require(observation in world.observation_space, f"observation {observation!r} is not in the observation space")


def check_info(make: Make) -> None:
    """The info has `success` as a bool, False at reset; flags are bools, rewards floats."""
    world = make()
    require(world.reset(seed=0)[1].get("success") is False, "reset must give info with success=False")
    for action in some_actions(world):
        _, reward, terminated, truncated, info = world.step(action)
        require(type(info.get("success")) is bool, f"info['success'] must be a bool, got {info.get('success')!r}")
        require(type(terminated) is bool and type(truncated) is bool, "terminated and truncated must be bools")
        require(isinstance(reward, float), f"the reward must be a float, got {reward!r}")


def check_listed_actions(make: Make) -> None:
    """If `actions_key` is set, each info has a list of legal actions under it, also at reset."""
    world = make()
    if not world.actions_key:
        return
    _, info = world.reset(seed=0)
    for action in some_actions(world):
        listed = info.get(world.actions_key)
        require(isinstance(listed, list), f"info[{world.actions_key!r}] must be a list of actions, got {listed!r}")
        for each in listed or ():
            world.legal(each)
        info = world.step(action)[4]


def check_reward_range(make: Make) -> None:
    """Rewards are within `reward_range`, and so is `failure_reward`."""
    world = started(make)
    low, high = world.reward_range
    rewards = [world.failure_reward, *(world.step(action)[1] for action in some_actions(world))]
    for reward in rewards:
        require(low <= reward <= high, f"reward {reward} is outside reward_range {world.reward_range}")


def check_seeding(make: Make) -> None:
    """The same seed and actions give the same episode, in a new world and in a used one."""
    actions = some_actions(started(make))
    first, again = trace(started(make, 3), actions), trace(started(make, 3), actions)
    require(first == again, "two worlds with the same seed and actions differ")
    reused = started(make, 9)
    trace(reused, actions)
    reused.reset(seed=3)
    require(trace(reused, actions) == first, "reset(seed) after an episode differs from a new world")


def check_truth(make: Make) -> None:
    """A truth is a snapshot: it does not change with the world, and equals the next one if nothing happens."""
    world = started(make)
    for action in some_actions(world):
        truth = world.truth
        require(truth == world.truth, "two truths of the same state differ")
        before = plain(truth)
        world.step(action)
        require(plain(truth) == before, "a truth changed in the next step")


def check_save(make: Make) -> None:
    """`restore(save())` restores the exact state, including the random stream."""
    world = started(make)
    actions = some_actions(world)
    trace(world, actions[:5])
    saved = world.save()
    first = trace(world, actions)
    world.restore(saved)
    require(trace(world, actions) == first, "after restore(save()) the same actions have other results")


def check_lab(make: Make) -> None:
    """A scratch world is new, has equal options, restores a truth, and is independent of the original."""
    world = started(make)
    trace(world, some_actions(world)[:5])
    truth = world.truth
    lab = world.scratch()
    require(lab is not world and type(lab) is type(world), "scratch() must return another world of the same class")
    require(lab.options == world.options, f"scratch() has options {lab.options}, not {world.options}")
    lab.restore(truth)
    require(lab.truth == truth, "restore(truth) does not restore the truth")
    lab.step(some_actions(world)[0])
    require(world.truth == truth, "a step of the scratch world changed the world it came from")


def check_legal(make: Make) -> None:
    """Anything but an action is refused by a ValueError that says what is allowed, without a change of state."""
    world = started(make)
    for wrong in (None, "\x00", -1, 10**9, 0.5, True, [], {}, object()):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a Box warns when it casts a value
            if wrong is not True and wrong in world.action_space:  # Gymnasium takes True for the number 1
                continue
        before = plain(world.save())
        try:
            world.step(wrong)
        except ValueError as error:
            require("allowed" in str(error), f"the error for {wrong!r} does not say what is allowed: {error}")
        else:
            raise AssertionError(f"legal({wrong!r}) accepts what is not in the action space")
        require(plain(world.save()) == before, f"the refused action {wrong!r} changed the state")


def check_reset_options(make: Make) -> None:
    """Unknown options of a reset are refused by a ValueError, without a change of state."""
    world = started(make)
    for wrong in (3, {"no such option": 1}):
        if world.reset_options is None and isinstance(wrong, dict):
            continue
        before = plain(world.save())
        try:
            world.reset(seed=1, options=wrong)  # type: ignore[arg-type]
        except ValueError:
            require(plain(world.save()) == before, f"reset refused the options {wrong!r} but changed the state")
        else:
            raise AssertionError(f"reset ignores the options {wrong!r}; call super().reset(seed=seed, options=options)")


def check_describe(make: Make) -> None:
    """`describe` returns text, the same for equal observations."""
    world = make()
    observation, _ = world.reset(seed=0)
    for action in some_actions(world):
        text = world.describe(observation)
        require(isinstance(text, str), f"describe must return a string, got {text!r}")
        again = world.describe(copy.deepcopy(observation))
        require(text == again, "describe returns different texts for equal observations")
        observation = world.step(action)[0]


def check_copies(make: Make) -> None:
    """Copies, by `deepcopy` or pickle, continue like the original."""
    world = started(make)
    actions = some_actions(world)
    trace(world, actions[:5])
    copies = [copy.deepcopy(world), pickle.loads(pickle.dumps(world))]  # noqa: S301
    expected = trace(world, actions)
    for copied in copies:
        require(trace(copied, actions) == expected, "a copy of the world does not continue like the original")


def check_global_random(make: Make) -> None:
    """No global random generator is used or seeded."""
    before = random.getstate(), plain(np.random.get_state())  # noqa: NPY002
    world = started(make)
    trace(world, some_actions(world))
    after = random.getstate(), plain(np.random.get_state())  # noqa: NPY002
    require(before == after, "the world uses a global random generator")


def check_fresh(make: Make) -> None:
    """An observation does not change in later steps."""
    world = make()
    observation, _ = world.reset(seed=0)
    for action in some_actions(world):
        before = plain(observation)
        following = world.step(action)[0]
        require(plain(observation) == before, "an observation changed in the next step")
        observation = following


def check_observe(make: Make) -> None:
    """`observe` returns the observation of `reset` or the last step, also after `restore`."""
    world = make()
    observation, _ = world.reset(seed=0)
    for action in some_actions(world):
        require(
            plain(world.observe()) == plain(observation),
            "observe() differs from the observation of reset or the last step",
        )
        observation = world.step(action)[0]
    lab = world.scratch()
    lab.restore(world.truth)
    require(plain(lab.observe()) == plain(observation), "after restore(truth) observe() differs")


def check_drawn_options(make: Make) -> None:
    """Random options of the world and of its reset make a world that can be played."""
    world = make()
    rng = np.random.default_rng(0)
    for _ in range(5):
        try:
            other = type(world)(**world.draw_options(rng))
            other.reset(seed=0, options=other.draw_reset(rng))
            other.step(other.sample_action(rng))
        except (TypeError, ValueError) as error:
            raise AssertionError(f"a world with random options cannot be played: {error!r}") from error


CHECKS: tuple[Callable[[Make], None], ...] = tuple(
    value for name, value in list(globals().items()) if name.startswith("check_") and name != "check_world"
)
"""Every check of a world."""
