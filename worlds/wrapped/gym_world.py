"""Any Gymnasium environment as a world, although its state can be neither read nor restored.

A truth is a position: an episode's seed and the actions so far. To restore it, a world repeats the actions, from a
copy of the environment (`snapshot="copy"`) or from a reset with the seed (`snapshot="replay"`). So a step of the played
environment costs almost nothing extra; scratch worlds pay the cost when they restore a truth.
"""

import copy
import inspect
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Self

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils.ezpickle import EzPickle

from worlds.actions import canonical, format_value, native, syntax
from worlds.spaces import Prose
from worlds.world import World, illegal
from worlds.wrapped.position import Episode, Position, plain_parts, same, still
from worlds.wrapped.shared import SharedState, lacking

__all__ = ["SNAPSHOTS", "Episode", "GymWorld", "Position", "another", "faithful", "same"]

_Env = gymnasium.Env[Any, Any]

SNAPSHOTS = ("auto", "copy", "replay")
_SPACES = ("action_space", "observation_space")
_REWARD_RANGE = (-1e6, 1e6)
_TRIAL = 16  # steps to test whether a copy is faithful
_FAR = 16  # with more replayed steps, keep a copy for the next restore to begin from


class GymWorld(World[Position, Any, Any]):
    """A world around an environment.

    Spaces, dynamics, rewards and the end of episodes are the environment's. Actions are legal if they are in its
    action space; for their canonical form see `worlds.actions`. The attribute `env` is the environment itself.

    Args:
        env: an environment, or a function without arguments that makes one.
        look: a function of the environment, as in `lambda env: env.unwrapped.s`, whose value is copied into each truth
            as `seen`. None: the observation. Its method `begin`, if it has one, is given the environment after each
            reset.
        snapshot: how truths are restored: `copy`, with copies of the environment, `replay`, with its seed and the
            actions, or `auto`, with copies if they prove faithful.
        success: a function `(observation, reward, terminated, truncated, info)` that returns whether the task is
            solved. None: the info's `success` or `is_success`, otherwise termination with a positive reward.
        describe: a function that returns an observation as text. None: plain numbers.
        action_words: words that name actions in text mode.
        reward_range: least and greatest reward; None: those of the environment if they are finite, else -1e6 and 1e6.

    Raises:
        ValueError: an argument is not allowed, or copies are not faithful although `snapshot="copy"`.
    """

    reset_options = None
    model: Any = None
    """A planner's knowledge of the environment, for oracles and their claims. Scratch worlds share it."""
    notes: Mapping[str, Any] = MappingProxyType({})
    """Entries that `reset` adds to the environment's own info."""

    def __init__(
        self,
        env: _Env | Callable[[], _Env],
        *,
        look: Callable[[_Env], Any] | None = None,
        snapshot: str = "auto",
        success: Callable[..., Any] | None = None,
        describe: Callable[[Any], str] | None = None,
        action_words: Mapping[str, Any] | None = None,
        reward_range: tuple[float, float] | None = None,
    ) -> None:
        super().__init__(
            env=env,
            look=look,
            snapshot=snapshot,
            success=success,
            describe=describe,
            action_words=action_words,
            reward_range=reward_range,
        )
        if snapshot not in SNAPSHOTS:
            raise ValueError(f"snapshot {snapshot!r} is unknown; allowed: {', '.join(SNAPSHOTS)}")
        if inspect.isabstract(env):
            raise ValueError(f"env must not be an abstract class, got {env!r}, which lacks {_missing(env)}")
        if not isinstance(action_words, Mapping | None) or not all(
            isinstance(word, str) for word in action_words or ()
        ):
            raise ValueError(f"action_words must be a dict of words with their actions, got {action_words!r}")
        self._make = None if isinstance(env, gymnasium.Env) or not callable(env) else env
        given = self._make() if self._make else env
        if not isinstance(given, gymnasium.Env):
            hint = "; wrap an environment of the old Gym in OldGym" if hasattr(given, "step") else ""
            raise ValueError(f"env must be a gymnasium.Env, or a function that makes one, got {given!r}{hint}")
        check_complete(given)
        self._given: _Env = given
        self._env: _Env | None = given
        self._copies = snapshot != "replay" and faithful(given)
        if snapshot == "copy" and not self._copies:
            raise ValueError(f"copies of {given} do not continue like the original; allowed: snapshot='replay'")
        self._look, self._success, self._describe = look, success, describe
        self.observation_space, self.action_space = _known(given.observation_space), given.action_space
        self._discrete = type(self.action_space) is spaces.Discrete
        self._integers: tuple[type, ...] = ()
        if type(self.action_space) is spaces.Discrete:
            self._least, self._count = int(self.action_space.start), int(self.action_space.n)
            self._integers = int, self.action_space.dtype.type
        self._sampler = copy.deepcopy(self.action_space)
        self.reward_range = _reward_range(given, reward_range)
        self.action_syntax = syntax(self.action_space)
        self.action_words = {}
        for word, action in (action_words or {}).items():
            try:
                self.action_words[str(word).lower()] = self.legal(action)
            except ValueError as error:
                raise ValueError(f"action_words must name actions of the action space, got {word!r}: {error}") from None
        if self.action_words:
            self.action_syntax = f"one of {', '.join(self.action_words)}, or {self.action_syntax}"
        self.names: dict[Any, str] = {action: word for word, action in reversed(self.action_words.items())}
        """The first word of each action that has a word."""
        self._at: tuple[Episode, int] | None = None
        self._kept: tuple[Episode, int, _Env, Any] | None = None
        self._shared = False

    @property
    def failure_reward(self) -> float:
        """The least reward of a step, at most 0; 0 if it is unknown. Seats may override it."""
        low = self.reward_range[0]
        return min(0.0, low) if self.reward_range != _REWARD_RANGE else 0.0

    @property
    def copied(self) -> bool:
        """Whether truths are restored by copies of the environment."""
        return self._copies

    @property
    def env(self) -> _Env:
        """The environment, in the current state."""
        return self._synchronized()

    @property
    def truth(self) -> Position:
        """The position in the episode, with the value of `look`."""
        at, episode, turn = self._at, self._episode, self._turn
        if at is not None and at[1] == turn and at[0] is episode:
            self._seen = still(self._observation if self._look is None else self._look(self._env))  # type: ignore[arg-type]  # there is one
        return Position(self._seen, turn, episode)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode. Without a seed the world draws one, so that the episode can be replayed."""
        super().reset(seed=seed, options=options)
        seed = int(self.np_random.integers(2**31)) if seed is None else seed
        if self._at is not None and self._at[0].live is self._env:
            self._at[0].live = None
        self._at = None
        env = self._synchronized()
        self._observation, info = env.reset(seed=seed, options=copy.deepcopy(options))
        if (begin := getattr(self._look, "begin", None)) is not None:
            begin(env)
        anchor, noted = (_anchor(env, info) if self._copies else None) or (None, None)
        parts = plain_parts(env) if anchor is None else None
        self._episode = Episode(seed, copy.deepcopy(options), still(self._observation), anchor, noted, parts)
        self._episode.live = env
        self._turn, self._shared, self._kept = 0, False, None
        self._at = self._episode, 0
        return self._observation, {**info, **self.notes, "success": False}

    def legal(self, action: Any) -> Any:
        """The action in canonical form."""
        # Without this short cut past Gymnasium's own check a turn of FrozenLake takes a sixth longer.
        if type(action) in self._integers and 0 <= int(action) - self._least < self._count:
            return int(action)
        try:
            return canonical(self.action_space, action)
        except (ValueError, TypeError, OverflowError):
            raise illegal(action, self.action_syntax) from None

    def advance(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Step the environment."""
        env = self._synchronized()
        if not self._discrete:
            observation, paid, terminated, truncated, info = env.step(native(self.action_space, action))
        else:
            observation, paid, terminated, truncated, info = env.step(action)
        reward, terminated, truncated = float(paid), bool(terminated), bool(truncated)
        if self._shared:
            self._episode, self._shared = self._episode.fork(self._turn), False
        episode = self._episode
        episode.actions.append(action)
        episode.rewards.append(reward)
        self._turn += 1
        self._at = episode, self._turn
        self._observation = observation
        success = self.solved(observation, reward, terminated, truncated, info)
        return observation, reward, terminated, truncated, {**info, "success": success}

    def solved(self, observation: Any, reward: float, terminated: bool, truncated: bool, info: dict[str, Any]) -> bool:
        """Whether a step with this result has solved the task."""
        if self._success is not None:
            return bool(self._success(observation, reward, terminated, truncated, info))
        success = info.get("success", info.get("is_success"))
        return bool(terminated and reward > 0 if success is None else success)

    def observe(self) -> Any:
        """The observation of reset or the last step."""
        self._synchronized()
        return still(self._observation)

    def describe(self, observation: Any) -> str:
        """The observation in plain numbers, or as text by the argument `describe`."""
        return format_value(observation) if self._describe is None else self._describe(observation)

    def sample_action(self, rng: np.random.Generator) -> Any:
        """A sample of the action space."""
        if self._discrete:
            return self._least + int(rng.integers(self._count))
        self._sampler.seed(int(rng.integers(2**31)))
        return self._sampler.sample()

    def state_of(self, truth: Position) -> Any:
        """The value of `look`, regardless of the actions before."""
        return truth.seen

    def scratch(self) -> Self:
        """A scratch world; it makes its environment at its first use."""
        lab = object.__new__(type(self))
        lab.__dict__.update(self.__dict__)
        lab._env = lab._at = lab._kept = None
        lab._np_random = None
        for name in ("_episode", "_turn", "_seen", "_observation"):
            lab.__dict__.pop(name, None)
        return lab

    def close(self) -> None:
        """Close the environment."""
        if self._env is not None:
            self._env.close()

    def _load(self, truth: Position) -> None:
        """Go to a position; the environment is synchronized at its next use."""
        self._episode, self._turn, self._seen = truth.episode, truth.turn, truth.seen
        self._shared = True
        if self._at is None:
            self._at = _NOWHERE

    def _synchronized(self) -> _Env:
        """The environment in the world's position, made if there is none."""
        at = self._at
        if at is not None and (at[1] != self._turn or at[0] is not self._episode):
            return self._replayed()
        if self._env is None:
            self._env = self._another()
        return self._env

    def _replayed(self) -> _Env:
        """The environment after replaying actions of the episode up to the world's position."""
        env, episode, turn = self._env, self._episode, self._turn
        here, begin = self._at or _NOWHERE
        if env is None or here is not episode or begin > turn:
            env, begin = self._set_back(episode, turn)
        for i in range(begin, turn):
            action = native(self.action_space, episode.actions[i])
            self._observation, reward, *_ = env.step(action)
            if not same(float(reward), episode.rewards[i]):
                self._at = _NOWHERE
                raise self._differs(f"action {i + 1}")
        if turn - begin > _FAR and episode.anchor is not None:
            self._kept = episode, turn, copy.deepcopy(env), self._observation
        self._at = episode, turn
        return env

    def _set_back(self, episode: Episode, turn: int) -> tuple[_Env, int]:
        """An environment in the episode, at this turn or an earlier turn, and its turn."""
        if episode.anchor is None:
            env = self._env = self._another() if self._env is None else self._env
            self._observation, _ = env.reset(seed=episode.seed, options=copy.deepcopy(episode.options))
            if not same(still(self._observation), episode.observation):
                raise self._differs("reset")
            return env, 0
        if self._kept is not None and self._kept[0] is episode and self._kept[1] <= turn:
            _, begin, kept, self._observation = self._kept
            env = self._env = copy.deepcopy(kept)
            return env, begin
        env = self._env = copy.deepcopy(episode.anchor)
        self._observation = episode.observation
        return env, 0

    def _differs(self, what: str) -> RuntimeError:
        return RuntimeError(
            f"{self._env} cannot be replayed: {what} had another result than in the episode. The environment draws "
            "from a random generator that reset(seed=...) does not seed, or that of a scratch world differs from the "
            "given one; pass a function that makes the environment"
        )

    def _another(self) -> _Env:
        """An environment like the given one."""
        return another(self._given, self._copies) if self._make is None else self._make()

    def __getstate__(self) -> dict[str, Any]:
        state = dict(self.__dict__)
        state["_shared"] = True  # the original continues to append to the episode
        if not self._copies:
            state["_env"] = None
            state["_at"] = self._at and _NOWHERE
        return state


def another(env: _Env, copies: bool = True) -> _Env:
    """An environment like the given one, which stays as it is: a copy, or one from its spec.

    Args:
        env: the environment.
        copies: whether a copy is tried first.

    Raises:
        ValueError: there is no such way.
    """
    ways: list[Callable[[_Env], _Env]] = [_from_spec, copy.deepcopy]
    why = ""
    for way in reversed(ways) if copies else ways:
        try:
            found = way(env)
        except Exception as error:  # environments may raise anything; the next way may work
            why = why or f" ({error!r})"
            continue
        lack = "" if isinstance(env.unwrapped, EzPickle) else lacking(env, found)
        if found.unwrapped is not env.unwrapped and (way is _from_spec or not lack):
            return found
        why = why or (f" (copies lack its attribute {lack!r})" if lack else " (a copy is the same object)")
    raise ValueError(
        f"a teacher that reads states needs another environment like {env}, which can neither be made from a spec nor "
        f"copied{why}; pass a function that makes it"
    )


def _known(space: spaces.Space[Any]) -> spaces.Space[Any]:
    """The space, with `Prose` in place of an environment's own class for texts, such as MiniGrid's."""
    if isinstance(space, spaces.Dict):
        found = {name: _known(each) for name, each in space.items()}
        return space if all(each is space[name] for name, each in found.items()) else spaces.Dict(found)
    if type(space).__module__.startswith("gymnasium."):
        return space
    try:
        return Prose() if type(copy.deepcopy(space).sample()) is str else space
    except Exception:  # spaces of other packages may raise anything
        return space


def _missing(abstract: Any) -> str:
    return ", ".join(sorted(abstract.__abstractmethods__))


def check_complete(env: _Env) -> None:
    """Check that an environment has methods and spaces of its own.

    Raises:
        ValueError: it lacks some.
    """
    bare = env.unwrapped
    lacks = [name for name in ("reset", "step") if getattr(type(bare), name) is getattr(gymnasium.Env, name)]
    lacks += [name for name in _SPACES if not isinstance(getattr(env, name, None), spaces.Space)]
    if lacks:
        raise ValueError(f"env must be complete, got {type(bare).__name__}, which lacks {', '.join(lacks)}")


_NOWHERE = (Episode(0, None, None, None), -1)


def faithful(env: _Env, copied: Callable[[_Env], _Env] = copy.deepcopy) -> bool:
    """Whether copies of an environment continue like the original, and leave it alone.

    The test does not step `env`, and sets back what its copies change of a state that they share with it.
    """
    try:
        first = copy.deepcopy(env)
        if first is env or lacking(env, first):
            return False
        shared = SharedState(env, [first])
    except Exception:
        return False
    try:
        return _continues(env, first, copied) and not shared.changed()
    finally:
        shared.restore()


def _continues(env: _Env, first: _Env, copied: Callable[[_Env], _Env]) -> bool:
    """The test of `faithful` with a copy of the environment."""
    try:
        space = copy.deepcopy(env.action_space)  # that of a class is the same in all its copies
        space.seed(0)
        actions = [space.sample() for _ in range(_TRIAL)]
        first.reset(seed=0)
        _play([first], [actions[: _TRIAL // 2]])
        alone, second, stray = (copied(first) for _ in range(3))
        if any(each is first or each.unwrapped is first.unwrapped for each in (alone, second, stray)):
            return False
        expected = _play([alone], [actions])[0]
        # Between the steps of the original its copies step: if they share state, the results differ.
        mine, its, _ = _play([first, second, stray], [actions, actions, actions[::-1]])
        return same(mine, expected) and same(its, expected)
    except Exception:
        return False


def _anchor(env: _Env, info: dict[str, Any]) -> tuple[_Env, dict[str, Any]] | None:
    """A copy of both; None if they cannot be copied any more, such as an environment that has opened a window."""
    try:
        return copy.deepcopy((env, info))
    except Exception:
        return None


def _play(envs: list[_Env], actions: Sequence[Sequence[Any]]) -> list[list[Any]]:
    """The results of actions in environments that take turns; when an episode ends, another begins.

    Its reset has a seed: without one, an environment may draw from the operating system, and copies differ by chance.
    """
    traces: list[list[Any]] = [[] for _ in envs]
    for now in zip(*actions, strict=True):
        for env, trace, action in zip(envs, traces, now, strict=True):
            observation, reward, terminated, truncated, _ = env.step(action)
            trace.append((still(observation), float(reward), bool(terminated), bool(truncated)))
            if terminated or truncated:
                trace.append(still(env.reset(seed=len(trace))[0]))
    return traces


def _from_spec(env: _Env) -> _Env:
    if env.spec is None:
        raise ValueError("the environment has no spec")
    silent = {"render_mode": None} if env.spec.kwargs.get("render_mode") == "human" else {}
    return gymnasium.make(env.spec, **silent)


def _reward_range(env: _Env, given: tuple[float, float] | None) -> tuple[float, float]:
    if given is None:
        try:
            low, high = map(float, env.get_wrapper_attr("reward_range"))
        except (AttributeError, TypeError, ValueError):
            return _REWARD_RANGE
        return (low, high) if np.isfinite((low, high)).all() and low <= high else _REWARD_RANGE
    low, high = map(float, given)
    if not np.isfinite((low, high)).all() or low > high:
        raise ValueError(f"reward_range must be two finite numbers in order, got {given!r}")
    return low, high
