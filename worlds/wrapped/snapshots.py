"""Ways back to states of an environment, so that a search can try other actions there.

A way is proved by a trial before it is used: after it went back, the same actions must give the same results.
"""

import copy
import random
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from itertools import chain
from types import FunctionType, MemberDescriptorType, MethodType, ModuleType
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from gymnasium import spaces, wrappers
from gymnasium.envs.registration import EnvSpec

from worlds.actions import native
from worlds.wrapped.gym_world import GymWorld, faithful
from worlds.wrapped.position import same, still

__all__ = [
    "GENERATORS",
    "Copies",
    "Replays",
    "States",
    "Stepped",
    "WayBack",
    "copied",
    "draws",
    "generators",
    "is_generator",
    "is_plain",
    "is_table",
    "layers",
    "of_function",
    "parts",
    "reseed",
    "sealed",
    "shake",
    "time_limits",
    "way_back",
]

_Env = gymnasium.Env[Any, Any]
GENERATORS = np.random.Generator, np.random.RandomState, np.random.BitGenerator, random.Random
"""Classes of what draws random numbers."""
_METHODS = (("clone_state", "restore_state"), ("get_state", "set_state"))  # by which environments set themselves back
_TRIAL = 8  # steps
_PLAIN = (  # what holds no generators
    *(str, bytes, int, float, complex, bool, type(None), np.generic, type, EnvSpec),
    *(np.float64, np.float32, np.int64, np.int32, np.int8, np.uint8, np.bool_),
    *(ModuleType, range, slice),
)
_TORCH = "manual_seed", "get_state", "set_state"  # methods of generators like PyTorch's
_HARMLESS = {"_io", "_thread", "datetime", "decimal", "numpy", "pygame", "re", "weakref"}  # modules in C that draw none
_WORD = 8  # bytes
_TIMERS = (  # wrappers without a state that decides anything but time
    *(wrappers.TimeLimit, wrappers.OrderEnforcing, wrappers.PassiveEnvChecker),
    *(wrappers.RecordEpisodeStatistics, gymnasium.ObservationWrapper),
)
_QUICK = frozenset(_PLAIN)
_STEPS = "_elapsed_steps"  # of Gymnasium's `TimeLimit`


class Stepped(NamedTuple):
    """What a step led to."""

    env: _Env
    """An environment in the state after the step, to be read only, before the next step."""
    saved: Any
    """The state, as `WayBack.step` takes it."""
    terminated: bool
    truncated: bool
    solved: bool
    """Whether the step has solved the task."""
    drew: bool
    """Whether the step drew random numbers."""


class WayBack(ABC):
    """A way back."""

    words: str
    """What it is, for people."""

    @abstractmethod
    def begin(self, lab: GymWorld) -> Any:
        """Save the state of a scratch world, which must not be used until the last `step` from there."""

    @abstractmethod
    def step(self, lab: GymWorld, saved: Any, action: Any, luck: int | None = None) -> Stepped:
        """Take an action in a saved state.

        Args:
            lab: the scratch world.
            saved: what `begin` or a step has saved.
            action: the action, in canonical form.
            luck: the seed of other random numbers than those that would come; None: those that would come.
        """


@dataclass(frozen=True)
class Copies(WayBack):
    """Each state is a copy of the environment."""

    words = "copies of the environment"

    def begin(self, lab: GymWorld) -> Any:
        """Take the scratch world's environment: it is only copied."""
        return lab.env

    def step(self, lab: GymWorld, saved: Any, action: Any, luck: int | None = None) -> Stepped:
        """Step a copy."""
        env = copied(saved)
        return Stepped(env, env, *_step(lab, env, action, luck))


@dataclass(frozen=True)
class States(WayBack):
    """The environment sets itself back.

    Args:
        save: returns the state of an environment.
        load: takes an environment and a state, and sets the environment to it.
    """

    save: Callable[[_Env], Any]
    load: Callable[[_Env, Any], None]
    words = "the environment's own snapshots"

    def begin(self, lab: GymWorld) -> Any:
        """Borrow the scratch world's environment."""
        env = lab.lend()
        return env, self.saved(env)

    def step(self, lab: GymWorld, saved: Any, action: Any, luck: int | None = None) -> Stepped:
        """Set the environment back, and step it."""
        env, state = saved
        self.loaded(env, state)
        results = _step(lab, env, action, luck)
        return Stepped(env, (env, self.saved(env)), *results)

    def saved(self, env: _Env) -> Any:
        """The state, and the counts of time limits around it."""
        return self.save(env), [getattr(layer, _STEPS, None) for layer in layers(env)]

    def loaded(self, env: _Env, saved: Any) -> None:
        """Set all of these."""
        state, counts = saved
        self.load(env, state)
        for layer, count in zip(layers(env), counts, strict=True):
            if count is not None:
                setattr(layer, _STEPS, count)


@dataclass(frozen=True)
class Replays(WayBack):
    """Each state is the list of actions that lead there from the start of the episode."""

    words = "replays of the episode"

    def begin(self, lab: GymWorld) -> Any:
        """Note where the scratch world is."""
        return lab.truth, ()

    def step(self, lab: GymWorld, saved: Any, action: Any, luck: int | None = None) -> Stepped:
        """Take all actions anew."""
        start, actions = saved
        lab.restore(start)
        for each in actions:
            lab.advance(each)
        env = lab.lend()
        results = _step(lab, env, action, luck)
        return Stepped(env, (start, (*actions, action)), *results)


def way_back(env: _Env, states: States | None = None) -> WayBack | None:
    """The first way that proves faithful: own snapshots, copies, replays; None if none does. The environment is reset.

    Args:
        env: an environment, which is reset and stepped.
        states: how it is set back; None: by its own methods, if it has them.
    """
    states = states or _own(env)
    if states is not None and _restores(env, states):
        return states
    if faithful(env, copied):
        return Copies()
    return Replays() if _repeats(env) else None


def _own(env: _Env) -> States | None:
    """The pair of methods of an environment that has one, and no wrapper with a state that they leave out."""
    if not all(map(is_plain, layers(env))):
        return None
    for save, load in _METHODS:
        if callable(getattr(env.unwrapped, save, None)) and callable(getattr(env.unwrapped, load, None)):
            return States(_Method(save), _Method(load))
    return None


@dataclass(frozen=True)
class _Method:
    """Calls a method of an environment by its name."""

    name: str

    def __call__(self, env: _Env, *arguments: Any) -> Any:
        return getattr(env.unwrapped, self.name)(*arguments)


def _restores(env: _Env, states: States) -> bool:
    """Whether an environment goes on alike each time that it is set back to a state."""
    try:
        actions = _actions(env)
        env.reset(seed=0)
        _trace(env, actions[: _TRIAL // 2])
        saved = states.saved(env)
        traces = []
        for _ in range(3):
            traces.append(_trace(env, actions))
            states.loaded(env, saved)
    except Exception:
        return False
    return all(same(traces[0], trace) for trace in traces)


def _repeats(env: _Env) -> bool:
    """Whether episodes from the same seed are alike."""
    try:
        actions, traces = _actions(env), []
        for _ in range(3):
            traces.append([still(env.reset(seed=0)[0]), *_trace(env, actions)])
    except Exception:
        return False
    return all(same(traces[0], trace) for trace in traces)


def _actions(env: _Env) -> list[Any]:
    space = copy.deepcopy(env.action_space)
    space.seed(0)
    return [space.sample() for _ in range(_TRIAL)]


def _trace(env: _Env, actions: list[Any]) -> list[Any]:
    """The results of actions, until the episode ends."""
    trace = []
    for action in actions:
        observation, reward, terminated, truncated, _ = env.step(action)
        trace.append((still(observation), float(reward), bool(terminated), bool(truncated)))
        if terminated or truncated:
            break
    return trace


def _step(lab: GymWorld, env: _Env, action: Any, luck: int | None) -> tuple[bool, bool, bool, bool]:
    """What a `Stepped` has, but for the state."""
    if luck is not None:
        shake(env, luck)
    sources = generators(env)
    before = [_drawn(each) for each in sources]
    observation, reward, terminated, truncated, info = env.step(native(lab.action_space, action))
    terminated, truncated = bool(terminated), bool(truncated)
    solved = lab.solved(observation, float(reward), terminated, truncated, info)
    return terminated, truncated, solved, [_drawn(each) for each in sources] != before


def layers(env: _Env) -> Iterator[Any]:
    """The wrappers of an environment, and itself."""
    while isinstance(env, gymnasium.Wrapper):
        yield env
        env = env.env
    yield env


def time_limits(env: _Env) -> tuple[int, ...]:
    """The numbers of steps after which an episode ends: of each `TimeLimit` around, and of an attribute `max_steps`."""
    limits = [each._max_episode_steps for each in layers(env) if isinstance(each, wrappers.TimeLimit)]
    own = getattr(env.unwrapped, "max_steps", None)
    return (*limits, own) if type(own) is int and own > 0 else tuple(limits)


def is_table(name: str, part: Any) -> bool:
    """Whether an attribute is a table of transitions, as Gymnasium's toy texts have it: a large part that stays."""
    return name == "P" and isinstance(part, Mapping)


def is_plain(layer: Any) -> bool:
    """Whether it is an environment itself, or a wrapper that decides nothing but observations and time."""
    if not isinstance(layer, gymnasium.Wrapper):
        return True
    return isinstance(layer, _TIMERS) and any(type(layer).step is cls.step for cls in _TIMERS)


def copied(env: _Env) -> _Env:
    """A copy that shares spaces, specs and tables, which steps do not change and which are most of the work."""
    shared = {
        id(part): part
        for layer in layers(env)
        for name, part in vars(layer).items()
        if isinstance(part, spaces.Space | EnvSpec) or is_table(name, part)
    }
    return copy.deepcopy(env, shared)


def draws(env: _Env) -> list[str]:
    """The states of an environment's random generators; they differ if something was drawn."""
    return [_drawn(generator) for generator in generators(env)]


def shake(env: _Env, luck: int) -> None:
    """Seed an environment's random generators anew."""
    for generator in generators(env):
        _seed(generator, luck)


def reseed(env: _Env, *seed: int) -> None:
    """The same, each generator with draws of its own. They stay the same objects: parts may share them."""
    for generator, source in zip(found := generators(env), np.random.SeedSequence(seed).spawn(len(found)), strict=True):
        _seed(generator, source)


def _bits(generator: Any) -> Any:
    """The bit generator; None if it has none."""
    return generator if isinstance(generator, np.random.BitGenerator) else getattr(generator, "bit_generator", None)


def _seed(generator: Any, seed: int | np.random.SeedSequence) -> None:
    if (bits := _bits(generator)) is not None:
        bits.state = type(bits)(seed).state
        return
    number = int(seed.generate_state(1)[0]) if isinstance(seed, np.random.SeedSequence) else seed
    getattr(generator, "seed" if isinstance(generator, GENERATORS) else "manual_seed")(number)


def _drawn(generator: Any) -> str:
    if (bits := _bits(generator)) is not None:
        return str(bits.state)
    return str((generator.getstate if isinstance(generator, random.Random) else generator.get_state)())


def generators(env: _Env) -> list[Any]:
    """All random generators that an environment holds, wherever `parts` finds them, and its action space."""
    return _walk(env, [env, env.action_space])[0]  # which the class may hold


def sealed(env: _Env) -> str:
    """What an environment holds and `parts` cannot look into, for people; empty if there is nothing."""
    classes = _walk(env, [env, env.action_space])[1]
    held = (each for layer in layers(env) for each in vars(layer).items() if classes)
    names = (f"its attribute {name!r}" for name, part in held if _walk(env, [part], layers(env))[1])
    return next(chain(names, (f"an object of class {each.__qualname__}" for each in classes)), "")


def _walk(env: _Env, roots: Iterable[Any], known: Iterable[Any] = ()) -> tuple[list[Any], list[type]]:
    """The generators in some parts of an environment, and the classes of what cannot be looked into."""
    found: list[Any] = []
    closed: list[type] = []
    tables = (part for layer in layers(env) for name, part in vars(layer).items() if is_table(name, part))
    seen = {*map(id, tables), *map(id, known)}  # tables are large, and of numbers
    queue: deque[Any] = deque(roots)
    while queue:
        each = queue.popleft()
        if id(each) in seen:
            continue
        seen.add(id(each))
        if is_generator(each):
            found.append(each)
        elif (inside := parts(each)) is not None:
            queue.extend([part for part in inside if type(part) not in _QUICK])
        else:
            closed.append(type(each))
    return found, closed


def is_generator(value: Any) -> bool:
    """Whether it draws random numbers: a generator of Python or NumPy, its bits, or one like PyTorch's."""
    return _draws(type(value))  # type: ignore[arg-type]  # classes are hashable


@cache
def _draws(cls: type) -> bool:
    if issubclass(cls, GENERATORS):
        return not issubclass(cls, random.SystemRandom)  # which has no state
    return isinstance(getattr(cls, "bit_generator", None), property) or all(map(partial(hasattr, cls), _TORCH))


def parts(whole: Any) -> Iterable[Any] | None:
    """What a value consists of: elements, attributes, slots, what a function closes over and has by default.

    None for one whose memory Python does not show, such as an object of a module in C.
    """
    return _reader(type(whole))(whole)  # type: ignore[arg-type]  # as above


@cache
def _reader(cls: type) -> Callable[[Any], Iterable[Any] | None]:
    """`parts` of the objects of a class."""
    if issubclass(cls, _PLAIN):
        return lambda _: ()
    if cls in _READERS:
        return _READERS[cls]
    home = getattr(cls, "__module__", "").partition(".")[0]
    if issubclass(cls, Iterator) and home in ("builtins", "itertools"):
        return _rest
    slots = [
        slot
        for base in cls.__mro__
        for name, slot in vars(base).items()
        if isinstance(slot, MemberDescriptorType) and name[:2] != "__"
    ]
    inner = next((read for base, read in _READERS.items() if issubclass(cls, base)), None)
    known = object.__basicsize__ + _WORD * (len(slots) + (cls.__dictoffset__ > 0) + (cls.__weakrefoffset__ > 0))
    if inner is None and home not in _HARMLESS and (cls.__basicsize__ > known or cls.__itemsize__):
        return _owner
    if inner is None and not slots:
        return lambda whole: getattr(whole, "__dict__", {}).values()

    def read(whole: Any) -> Iterable[Any]:
        held = [slot.__get__(whole, cls) for slot in slots if hasattr(whole, slot.__name__)]
        return chain(getattr(whole, "__dict__", {}).values(), held, inner(whole) if inner else ())

    return read


def _inside(cell: Any) -> Any:
    """What a cell of a closure holds; None if it is empty."""
    try:
        return cell.cell_contents
    except ValueError:
        return None


def _owner(method: Any) -> Any:
    """That of which a method in C is one; None of what is none."""
    owner = getattr(method, "__self__", None)
    return owner if owner is None else (owner,)


def _rest(whole: Any) -> Any:
    """What an iterator has left; None if that is not to be seen."""
    try:
        return whole.__reduce__()
    except TypeError:  # of a function that yields
        return None


def of_function(whole: Any) -> list[Any]:
    """What a function closes over, and its defaults; nothing of one in C."""
    if not isinstance(whole, FunctionType):
        return []
    closed = map(_inside, whole.__closure__ or ())
    return [*closed, *(whole.__defaults__ or ()), *(whole.__kwdefaults__ or {}).values()]


_READERS: dict[type, Callable[[Any], Any]] = {
    **dict.fromkeys((list, tuple, set, frozenset, deque), iter),
    Mapping: lambda whole: chain(whole.keys(), whole.values()),
    np.ndarray: lambda whole: whole.ravel().tolist() if whole.dtype == object else (),
    FunctionType: of_function,
    MethodType: lambda whole: [whole.__self__, *of_function(whole.__func__)],
    partial: lambda whole: (whole.func, whole.args, whole.keywords),
}
_READERS[dict] = _READERS[Mapping]
