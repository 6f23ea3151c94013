"""A conformance kit for worlds: what every world must do. For your own world, run `check_world(MyWorld)`.

Each check takes a factory of worlds and raises an AssertionError that says what is wrong.
"""

import copy
import pickle
import random
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from worlds.world import World

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
    """A world after `reset(seed)`."""
    world = make()
    world.reset(seed=seed)
    return world


def trace(world: World[Any], actions: list[Any]) -> list[Any]:
    """What a sequence of actions gives, with observations and truths."""
    return [(*map(plain, world.step(action)), plain(world.truth)) for action in actions]


def some_actions(world: World[Any], count: int = _STEPS, seed: int = 1) -> list[Any]:
    """Actions that one might take who knows nothing of the task."""
    rng = np.random.default_rng(seed)
    return [world.sample_action(rng) for _ in range(count)]


def plain(value: Any) -> Any:
    """A stand-in of nested tuples that compares with `==`, arrays included."""
    if isinstance(value, dict):
        return tuple((key, plain(item)) for key, item in value.items())
    if isinstance(value, np.ndarray):
        return value.shape, value.dtype.str, value.tobytes()
    return tuple(map(plain, value)) if isinstance(value, list | tuple) else value


def check_spaces(make: Make) -> None:
    """Observations lie in their space; sampled actions lie in theirs and are legal, also in canonical form."""
    world = make()
    observation, _ = world.reset(seed=0)
    for action in some_actions(world):
        require(observation in world.observation_space, f"observation {observation!r} is not in the observation space")
        require(action in world.action_space, f"sample_action gave {action!r}, which is not in the action space")
        canonical = world.legal(action)
        require(plain(world.legal(canonical)) == plain(canonical), f"legal({canonical!r}) changes a canonical action")
        observation = world.step(action)[0]
    require(observation in world.observation_space, f"observation {observation!r} is not in the observation space")


def check_info(make: Make) -> None:
    """The info says whether the task is solved, as a bool, not yet at reset; flags are bools, rewards floats."""
    world = make()
    require(world.reset(seed=0)[1].get("success") is False, "reset must give info with success=False")
    for action in some_actions(world):
        _, reward, terminated, truncated, info = world.step(action)
        require(type(info.get("success")) is bool, f"info['success'] must be a bool, got {info.get('success')!r}")
        require(type(terminated) is bool and type(truncated) is bool, "terminated and truncated must be bools")
        require(isinstance(reward, float), f"the reward must be a float, got {reward!r}")


def check_listed_actions(make: Make) -> None:
    """Where a world says that its info lists actions, it does so in a list, at reset too, and they are legal."""
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
    """Rewards stay in `reward_range`, and so does the reward of a text that is no action."""
    world = started(make)
    low, high = world.reward_range
    rewards = [world.failure_reward, *(world.step(action)[1] for action in some_actions(world))]
    for reward in rewards:
        require(low <= reward <= high, f"reward {reward} is outside reward_range {world.reward_range}")


def check_seeding(make: Make) -> None:
    """The same seed and actions give the same episode; another seed gives another one, sooner or later."""
    actions = some_actions(started(make))
    first, again = trace(started(make, 3), actions), trace(started(make, 3), actions)
    require(first == again, "two worlds with the same seed and actions differ")
    reused = started(make, 9)
    trace(reused, actions)
    reused.reset(seed=3)
    require(trace(reused, actions) == first, "reset(seed) after an episode differs from a new world")


def check_truth(make: Make) -> None:
    """A truth is a snapshot: it does not change when the world goes on, and equals itself when nothing happens."""
    world = started(make)
    for action in some_actions(world):
        truth = world.truth
        require(truth == world.truth, "two truths of the same state differ")
        before = plain(truth)
        world.step(action)
        require(plain(truth) == before, "a truth changed when the world went on")


def check_save(make: Make) -> None:
    """`restore(save())` brings back the exact state, random stream included."""
    world = started(make)
    actions = some_actions(world)
    trace(world, actions[:5])
    saved = world.save()
    first = trace(world, actions)
    world.restore(saved)
    require(trace(world, actions) == first, "after restore(save()) the same actions give something else")


def check_lab(make: Make) -> None:
    """A scratch world is new, of equal options, and takes over a truth; the original notices nothing."""
    world = started(make)
    trace(world, some_actions(world)[:5])
    truth = world.truth
    lab = world.scratch()
    require(lab is not world and type(lab) is type(world), "scratch() must give another world of the same class")
    require(lab.options == world.options, f"scratch() has options {lab.options}, not {world.options}")
    lab.restore(truth)
    require(lab.truth == truth, "restore(truth) does not bring back the truth")
    lab.step(some_actions(world)[0])
    require(world.truth == truth, "a step of the scratch world changed the world it came from")


def check_legal(make: Make) -> None:
    """What is no action is refused by a ValueError that says so, and changes nothing."""
    world = started(make)
    for wrong in (None, "\x00", -1, 10**9, 0.5, True, [], {}, object()):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a Box warns of what it has to cast
            if wrong is not True and wrong in world.action_space:  # Gymnasium takes True for the number 1
                continue
        before = plain(world.save())
        try:
            world.step(wrong)
        except ValueError as error:
            require("allowed" in str(error), f"the error for {wrong!r} does not say what is allowed: {error}")
        else:
            raise AssertionError(f"{wrong!r} was taken for an action")
        require(plain(world.save()) == before, f"the refused action {wrong!r} changed the state")


def check_reset_options(make: Make) -> None:
    """Options of a reset that are none are refused by a ValueError that says so, which changes nothing."""
    world = started(make)
    for wrong in (3, {"no such option": 1}):
        if world.reset_options is None and isinstance(wrong, dict):
            continue
        before = plain(world.save())
        try:
            world.reset(seed=1, options=wrong)  # type: ignore[arg-type]
        except ValueError:
            require(
                plain(world.save()) == before, f"reset with the options {wrong!r} was refused and changed the world"
            )
        else:
            require(
                False, f"reset ignores the options {wrong!r}; pass them on: super().reset(seed=seed, options=options)"
            )


def check_describe(make: Make) -> None:
    """`describe` gives text, the same for the same observation."""
    world = make()
    observation, _ = world.reset(seed=0)
    for action in some_actions(world):
        text = world.describe(observation)
        require(isinstance(text, str), f"describe gave {text!r}, not a string")
        require(
            text == world.describe(copy.deepcopy(observation)), "describe gives different texts for one observation"
        )
        observation = world.step(action)[0]


def check_copies(make: Make) -> None:
    """Copies, by `deepcopy` or pickle, go on like the original."""
    world = started(make)
    actions = some_actions(world)
    trace(world, actions[:5])
    copies = [copy.deepcopy(world), pickle.loads(pickle.dumps(world))]  # noqa: S301
    expected = trace(world, actions)
    for copied in copies:
        require(trace(copied, actions) == expected, "a copy of the world does not go on like the original")


def check_global_random(make: Make) -> None:
    """No global random generator is read or seeded."""
    before = random.getstate(), plain(np.random.get_state())  # noqa: NPY002
    world = started(make)
    trace(world, some_actions(world))
    after = random.getstate(), plain(np.random.get_state())  # noqa: NPY002
    require(before == after, "the world touches a global random generator")


def check_fresh(make: Make) -> None:
    """An observation that was handed out does not change when the world goes on."""
    world = make()
    observation, _ = world.reset(seed=0)
    for action in some_actions(world):
        before = plain(observation)
        following = world.step(action)[0]
        require(plain(observation) == before, "an observation changed after it was handed out")
        observation = following


def check_observe(make: Make) -> None:
    """`observe` gives what `reset` or the last step gave, also in a world that has taken over the state."""
    world = make()
    observation, _ = world.reset(seed=0)
    for action in some_actions(world):
        require(plain(world.observe()) == plain(observation), "observe() differs from what reset or the last step gave")
        observation = world.step(action)[0]
    lab = world.scratch()
    lab.restore(world.truth)
    require(plain(lab.observe()) == plain(observation), "after restore(truth) observe() differs")


def check_drawn_options(make: Make) -> None:
    """Options that are drawn, of the world and of its reset, make a world that can be played."""
    world = make()
    rng = np.random.default_rng(0)
    for _ in range(5):
        try:
            other = type(world)(**world.draw_options(rng))
            other.reset(seed=0, options=other.draw_reset(rng))
            other.step(other.sample_action(rng))
        except (TypeError, ValueError) as error:
            raise AssertionError(f"a world with options that were drawn cannot be played: {error!r}") from error


CHECKS: tuple[Callable[[Make], None], ...] = tuple(
    value for name, value in list(globals().items()) if name.startswith("check_") and name != "check_world"
)
"""Every check of a world."""
