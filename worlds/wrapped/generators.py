"""The random generators that an environment holds, wherever it holds them: found, compared and seeded anew."""

import random
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache, partial
from itertools import chain
from types import FunctionType, MemberDescriptorType, MethodType, ModuleType
from typing import Any

import gymnasium
import numpy as np
from gymnasium.envs.registration import EnvSpec

from worlds.wrapped.layers import is_table, layers

__all__ = [
    "PLAIN",
    "drawn",
    "draws",
    "generators",
    "is_generator",
    "of_function",
    "parts",
    "reseed",
    "sealed",
    "set_back",
    "shake",
]

_Env = gymnasium.Env[Any, Any]
_GENERATORS = np.random.Generator, np.random.RandomState, np.random.BitGenerator, random.Random
"""Classes of random generators."""
PLAIN = (  # these hold no generators
    *(str, bytes, int, float, complex, bool, type(None), np.generic, type, EnvSpec),
    *(np.float64, np.float32, np.int64, np.int32, np.int8, np.uint8, np.bool_),
    *(ModuleType, range, slice),
)
_TORCH = "manual_seed", "get_state", "set_state"  # methods of generators like PyTorch's
_HARMLESS = {"_io", "_thread", "datetime", "decimal", "numpy", "pygame", "re", "weakref"}  # C modules without any
_WORD = 8  # bytes
_QUICK = frozenset(PLAIN)


def draws(env: _Env) -> list[str]:
    """The states of an environment's random generators; a draw changes them."""
    return [drawn(generator) for generator in generators(env)]


def shake(env: _Env, luck: int) -> None:
    """Seed an environment's random generators anew, but not those that its class holds, which are others', too."""
    for generator in _walk(env, [env])[0]:
        _seed(generator, luck)


def reseed(env: _Env, *seed: int) -> None:
    """Seed each generator with a seed of its own. The generators stay the same objects, since parts may share them.

    Those that its class holds are others', too, and stay as they are.
    """
    own = set(map(id, _walk(env, [env])[0]))
    for generator, source in zip(found := generators(env), np.random.SeedSequence(seed).spawn(len(found)), strict=True):
        if id(generator) in own:
            _seed(generator, source)


def _bits(generator: Any) -> Any:
    """The bit generator; None if it has none."""
    return generator if isinstance(generator, np.random.BitGenerator) else getattr(generator, "bit_generator", None)


def _seed(generator: Any, seed: int | np.random.SeedSequence) -> None:
    if (bits := _bits(generator)) is not None:
        bits.state = type(bits)(seed).state
        return
    number = int(seed.generate_state(1)[0]) if isinstance(seed, np.random.SeedSequence) else seed
    getattr(generator, "seed" if isinstance(generator, _GENERATORS) else "manual_seed")(number)


def set_back(generator: Any, other: Any) -> None:
    """Give a generator the state of another one of its class."""
    if (bits := _bits(generator)) is not None:
        bits.state = _bits(other).state
    elif isinstance(generator, random.Random):
        generator.setstate(other.getstate())
    else:
        generator.set_state(other.get_state())


def drawn(generator: Any) -> str:
    """The state of a generator; a draw changes it."""
    if (bits := _bits(generator)) is not None:
        return str(bits.state)
    return str((generator.getstate if isinstance(generator, random.Random) else generator.get_state)())


def generators(env: _Env) -> list[Any]:
    """All random generators that an environment holds, wherever `parts` finds them, and its action space."""
    return _walk(env, [env, env.action_space])[0]  # its class may hold the action space


def sealed(env: _Env) -> str:
    """A description of something in the environment that `parts` cannot look into; empty if there is nothing."""
    classes = _walk(env, [env, env.action_space])[1]
    held = (each for layer in layers(env) for each in vars(layer).items() if classes)
    names = (f"its attribute {name!r}" for name, part in held if _walk(env, [part], layers(env))[1])
    return next(chain(names, (f"an object of class {each.__qualname__}" for each in classes)), "")


def _walk(env: _Env, roots: Iterable[Any], known: Iterable[Any] = ()) -> tuple[list[Any], list[type]]:
    """The generators in some parts of an environment, and the classes of the objects that `parts` cannot look into."""
    found: list[Any] = []
    closed: list[type] = []
    tables = (part for layer in layers(env) for name, part in vars(layer).items() if is_table(name, part))
    seen = {*map(id, tables), *map(id, known)}  # tables are large and hold only numbers
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
    if issubclass(cls, _GENERATORS):
        return not issubclass(cls, random.SystemRandom)  # a SystemRandom has no state
    return isinstance(getattr(cls, "bit_generator", None), property) or all(map(partial(hasattr, cls), _TORCH))


def parts(whole: Any) -> Iterable[Any] | None:
    """The parts of a value: elements, attributes, slots, and a function's closure and defaults.

    None if Python does not show its memory, as for an object of a C module.
    """
    return _reader(type(whole))(whole)  # type: ignore[arg-type]  # as above


@cache
def _reader(cls: type) -> Callable[[Any], Iterable[Any] | None]:
    """A function that returns `parts` of objects of a class."""
    if issubclass(cls, PLAIN):
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
        held = [value for slot in slots if (value := _in_slot(slot, whole)) is not slot]
        return chain(getattr(whole, "__dict__", {}).values(), held, inner(whole) if inner else ())

    return read


def _in_slot(slot: MemberDescriptorType, whole: Any) -> Any:
    """The content of a slot; the slot itself if it is empty, also where a subclass has an attribute of its name."""
    try:
        return slot.__get__(whole, type(whole))
    except AttributeError:
        return slot


def _inside(cell: Any) -> Any:
    """The content of a cell of a closure; None if it is empty."""
    try:
        return cell.cell_contents
    except ValueError:
        return None


def _owner(method: Any) -> Any:
    """The object that a C method is bound to, in a tuple; None for any other object."""
    owner = getattr(method, "__self__", None)
    return owner if owner is None else (owner,)


def _rest(whole: Any) -> Any:
    """What an iterator has left; None if the iterator does not show it."""
    try:
        return whole.__reduce__()
    except TypeError:  # a generator does not show it
        return None


def of_function(whole: Any) -> list[Any]:
    """What a function closes over, and its defaults; empty for a C function."""
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
