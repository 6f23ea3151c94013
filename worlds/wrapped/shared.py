"""The state that an environment shares with its copies, which their steps would change for each other.

`copy.deepcopy` returns functions, classes and modules as they are. So copies share what functions close over, their
defaults and attributes, class attributes and the globals that code names, and what a `__deepcopy__` hands on.
"""

import builtins
import contextvars
import copy
import dis
import os
import sys
import weakref
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cached_property, partial
from hashlib import blake2b
from itertools import pairwise
from types import BuiltinFunctionType, CodeType, FunctionType, MemberDescriptorType, MethodType, ModuleType
from typing import Any, NamedTuple

import gymnasium
import numpy as np

from worlds.wrapped.generators import PLAIN, drawn, is_generator, of_function, parts, set_back
from worlds.wrapped.layers import is_table, layers

__all__ = ["SharedState", "lacking"]

_Env = gymnasium.Env[Any, Any]
_MISSING = object()
_LARGE = 200_000  # parts of a value: of more, only the first ones are compared
_RESTORED = 20_000  # parts of a value: a larger one is not set back
_TRUSTED = {"gymnasium", "numpy"}
_GLOBAL = {"LOAD_GLOBAL", "LOAD_NAME", "STORE_GLOBAL", "DELETE_GLOBAL"}
_CLOCKS = {  # functions with another result each time, by module
    "time": {"time", "time_ns", "monotonic", "monotonic_ns", "perf_counter", "perf_counter_ns", "process_time"}
    | {"process_time_ns", "thread_time", "thread_time_ns", "gmtime", "localtime", "ctime", "clock_gettime"},
    "datetime": {"now", "today", "utcnow"},
    "os": {"urandom", "getrandom", "times", "open", "getloadavg"},
    "io": {"open"},
    "secrets": {"token_bytes", "token_hex", "randbelow", "choice", "randbits", "SystemRandom"},
    "random": {"SystemRandom"},
    "uuid": {"uuid1", "uuid4"},
}
_FILES = {  # methods of `pathlib.Path`
    *("read_text", "write_text", "read_bytes", "write_bytes", "open"),
    *("mkdir", "rmdir", "touch", "unlink", "rename", "replace", "symlink_to"),
}
_SAVING = {  # functions that change files or this process, by module
    "numpy": {"save", "savez", "savez_compressed", "savetxt", "memmap"},
    "os": {"chdir", "mkdir", "makedirs", "remove", "rename", "replace", "rmdir", "symlink", "system", "truncate"}
    | {"umask", "unlink", "utime", "write"},
    "shutil": {"copy", "copyfile", "copytree", "move", "rmtree"},
}
_CONTAINERS = list, dict, set, deque, np.ndarray
_DRAWING = "render"  # in the names of functions that decide nothing


class _Slot(NamedTuple):
    """A place that copies share."""

    name: str
    read: Callable[[], Any]
    write: Callable[[Any], None]
    value: Any
    print: bytes
    content: Any
    """A copy of the value; `_MISSING` if it cannot be set back."""


class SharedState:
    """The state that an environment shares with its copies, as it was when this was made; it steps nothing.

    Args:
        env: the environment.
        others: copies of it, or others from the same function; mutable objects that it holds with one are shared, too.
    """

    def __init__(self, env: _Env, others: Iterable[_Env] = ()) -> None:
        self.refusal = ""
        """What certainly makes copies unlike their original, such as a clock; empty if nothing was found."""
        self._slots: dict[Any, _Slot] = {}
        held = _held(env)
        self._own = set(map(id, held))
        own = {id(type(layer)) for layer in layers(env)}
        self._roots = {_root(type(layer)) for layer in layers(env)} - _TRUSTED
        self._classes = {type(each): None for each in [*layers(env), *held] if not self._is_library(type(each))}
        self._functions: dict[FunctionType, None] = {}
        for each in held:
            self._check_held(each)
        for other in others:
            self._track_common(held, _held(other))
        self._read_code([each for each in held if isinstance(each, FunctionType)])
        for cls in self._classes:
            for base in (*cls.__mro__, *type(cls).__mro__):
                if id(cls) in own or base is cls:
                    self._track_class(base)
        for name in {f"{getattr(cls, '__module__', '')}": None for cls in self._classes}:
            if (module := sys.modules.get(name)) is not None:
                self._track_names(module, f"the globals of {name}")
        bare = type(env.unwrapped)
        self._track("metadata", "its metadata", lambda: bare.metadata, partial(setattr, bare, "metadata"))
        self._track("context", "a context variable", _context, _set_context)
        self._track("os.environ", "os.environ", lambda: dict(os.environ), _set_environ)

    def changed(self) -> str:
        """The first shared thing that has changed since; empty if nothing has."""
        return next((slot.name for slot in self._slots.values() if _differs(slot)), "")

    def restore(self) -> None:
        """Set back what has changed, as far as possible."""
        for slot in self._slots.values():
            if _differs(slot):
                if slot.content is not _MISSING and slot.value is not _MISSING:
                    _refill(slot.value, copy.deepcopy(slot.content))
                slot.write(slot.value)

    def _refuse(self, why: str) -> None:
        self.refusal = self.refusal or why

    def _check_held(self, each: Any) -> None:
        """Refuse a held object that a copy would share with its original."""
        if isinstance(each, FunctionType) and self._is_library(each):
            return
        if isinstance(each, FunctionType) and (each.__closure__ or any(map(_is_mutable, of_function(each)))):
            where = "closes over" if each.__closure__ else "has as a default"
            name = next(iter(each.__code__.co_freevars), "a mutable value")
            self._refuse(f"it holds the function {each.__qualname__}, which {where} {name}; copies share that")
        elif isinstance(each, weakref.ReferenceType | weakref.ProxyType | weakref.CallableProxyType):
            self._refuse("it holds a weak reference, which is the same in its copies")
        elif isinstance(each, BuiltinFunctionType) and not isinstance(each.__self__, ModuleType | type | None):
            self._refuse(f"it holds the method {each.__qualname__} of an object, which its copies share")

    def _track_common(self, held: Iterable[Any], others: Iterable[Any]) -> None:
        """Track the mutable objects that two environments hold."""
        common = {id(each) for each in others}
        for each in held:
            if id(each) in common and not isinstance(each, FunctionType | BuiltinFunctionType | tuple | frozenset):
                self._track(id(each), f"an object of class {type(each).__qualname__}", partial(_same, each), _keep)

    def _read_code(self, functions: Iterable[FunctionType]) -> None:
        """Track what the functions that `step` and `reset` may call close over, name and have."""
        queue: deque[FunctionType] = deque(functions)
        for cls in self._classes:
            queue += _methods(cls, {"step", "reset", *(name for name in dir(cls) if _is_operator(name))})
        asked: set[str] = set()
        while queue:
            function = queue.popleft()
            if function in self._functions or _DRAWING in function.__name__ or self._is_library(function):
                continue
            self._functions[function] = None
            queue += self._read_function(function)
            names = {name for code in _codes(function.__code__) for name in code.co_names} - asked
            asked |= names
            classes = list(self._classes)
            queue += [each for cls in classes for each in _methods(cls, {n for n in names if _DRAWING not in n})]

    def _read_function(self, function: FunctionType) -> list[FunctionType]:
        """Track what one function reaches; return the functions among that."""
        found: list[Any] = []
        name, space = function.__qualname__, function.__globals__
        for variable, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
            read, write = partial(_content, cell), partial(setattr, cell, "cell_contents")
            found.append(self._take(id(cell), f"the variable {variable} that {name} closes over", read, write))
        for value in (*(function.__defaults__ or ()), *(function.__kwdefaults__ or {}).values()):
            found.append(self._take(id(value), f"a default value of {name}", partial(_same, value), _keep))
        self._take(("of", function), f"an attribute of {name}", partial(_same, vars(function)), _keep)
        found += [each for each in vars(function).values() if isinstance(each, FunctionType)]
        for code in _codes(function.__code__):
            names, steps = set(code.co_names), list(dis.get_instructions(code))
            for each, then in pairwise([*steps, steps[-1]]):
                if each.opname == "IMPORT_NAME":
                    self._check_clock(name, sys.modules.get(str(each.argval).partition(".")[0]), names)
                elif each.opname in _GLOBAL and each.argval in vars(builtins) and each.argval not in space:
                    if each.argval in ("open", "input"):
                        self._refuse(f"{name} calls {each.argval}, and so depends on what is outside of the program")
                elif each.opname in _GLOBAL:
                    asked = {str(then.argval)} if "ATTR" in then.opname or "METHOD" in then.opname else set()
                    self._check_clock(name, space.get(each.argval), asked)
                    found.append(self._take_global(space, str(each.argval), names, asked))
        return [each for each in found if isinstance(each, FunctionType)]

    def _take_global(self, space: dict[str, Any], variable: str, names: set[str], then: set[str]) -> Any:
        """Track a global, or of a module what the code names of it; of a library, only the attribute `then`."""
        value = space.get(variable, _MISSING)
        where = f"the global {variable} of {space.get('__name__', 'its module')}"
        if isinstance(value, ModuleType):
            if not self._is_library(value):
                for name in names & vars(value).keys():
                    self._take_global(vars(value), name, set(), set())
            else:
                for name in then:
                    self._track_attribute(value, name)
            return None
        if isinstance(value, type):
            if not self._is_library(value) and value not in self._classes:
                self._classes[value] = None
            return None
        if not isinstance(value, FunctionType):
            self._check_iterator(where, value)
        return self._take(
            (id(space), variable), where, partial(space.get, variable, _MISSING), _global(space, variable)
        )

    def _track_attribute(self, module: ModuleType, name: str) -> None:
        read = partial(vars(module).get, name, _MISSING)
        if not callable(read()):
            self._take((id(module), name), f"{module.__name__}.{name}", read, _global(vars(module), name))

    def _track_names(self, owner: type | ModuleType, where: str) -> None:
        """Track the names of a class or a module and their plain values, since code may compute names."""
        self._track(("names", owner), where, partial(_names, owner), partial(_set_names, owner))

    def _check_clock(self, function: str, value: Any, names: set[str]) -> None:
        """Refuse clocks, files and chance that no seed decides."""
        home = value.__name__ if isinstance(value, ModuleType) else getattr(value, "__module__", None)
        known = _CLOCKS.get(home, set()) | _SAVING.get(home, set()) if isinstance(home, str) else set()
        if isinstance(value, ModuleType | type):
            asked = sorted(known & names)
        else:
            asked = [value.__name__] if getattr(value, "__name__", None) in known else []
        if isinstance(value, type) and home == "pathlib":
            asked = sorted(_FILES & names)
        if asked and asked[0] in _SAVING.get(f"{home}", ()):
            self._refuse(f"{function} calls {asked[0]} of {home}, which changes what is outside of the program")
        elif asked:
            self._refuse(f"{function} calls {asked[0]} of {home}, whose result is another one each time")

    def _check_iterator(self, where: str, value: Any) -> None:
        if isinstance(value, Iterator):
            self._refuse(f"it takes from {where}, an iterator that its copies share")

    def _track_class(self, cls: type) -> None:
        """Track the data among the attributes of a class, and those that code sets."""
        if self._is_library(cls):
            return
        stored = {
            str(each.argval)
            for function in self._functions
            for code in _codes(function.__code__)
            for each in dis.get_instructions(code)
            if each.opname in ("STORE_ATTR", "DELETE_ATTR")
        }
        for name in sorted(stored | vars(cls).keys()):
            value = vars(cls).get(name, _MISSING)
            code = callable(value) or hasattr(type(value), "__get__")
            if name[:2] == "__" or name[:4] == "_abc" or (code and self._is_library(type(value))):
                continue
            where = f"the class attribute {cls.__qualname__}.{name}"
            self._check_iterator(where, value)
            self._take((cls, name), where, partial(_of_class, cls, name), partial(_set_class, cls, name))
        self._track_names(cls, f"the attributes of the class {cls.__qualname__}")

    def _take(self, key: Any, name: str, read: Callable[[], Any], write: Callable[[Any], None]) -> Any:
        """Track a place unless it holds code; return its content."""
        value = read()
        if isinstance(value, FunctionType | type | ModuleType | MethodType) or id(value) in self._own:
            return value
        self._check_iterator(name, value)
        self._track(key, name, read, write)
        return value

    def _track(self, key: Any, name: str, read: Callable[[], Any], write: Callable[[Any], None]) -> None:
        if key in self._slots:
            return
        value = read()
        seen, digest = _fingerprint(value)
        content = _MISSING
        if seen < _RESTORED and _is_mutable(value):
            try:
                content = _saved(value)
            except Exception:  # objects may raise anything
                content = _MISSING
        self._slots[key] = _Slot(name, read, write, value, digest, content)

    def _is_library(self, value: Any) -> bool:
        """Whether code is of Python or of an installed package that is not the environment's own."""
        root = _root(value)
        if root in _TRUSTED or root in sys.stdlib_module_names or root == "builtins":
            return True
        file = getattr(sys.modules.get(root), "__file__", None) or ""
        return "-packages" in file and root not in self._roots


def lacking(env: _Env, copied: _Env) -> str:
    """An attribute that a copy lacks; empty if it has all."""
    for mine, its in zip(layers(env), layers(copied), strict=False):
        if gone := sorted(map(str, vars(mine).keys() - vars(its).keys())):
            return gone[0]
    return ""


def _root(value: Any) -> str:
    home = value.__name__ if isinstance(value, ModuleType) else getattr(value, "__module__", None)
    return str(home).partition(".")[0]


def _held(env: _Env) -> list[Any]:
    """The objects that an environment holds, without plain values and the content of tables."""
    found: list[Any] = []
    seen = {id(part) for layer in layers(env) for name, part in vars(layer).items() if is_table(name, part)}
    tables = [part for layer in layers(env) for name, part in vars(layer).items() if is_table(name, part)]
    queue: deque[Any] = deque([env, env.action_space, env.observation_space])
    while queue:
        each = queue.popleft()
        if id(each) in seen or isinstance(each, PLAIN):
            continue
        seen.add(id(each))
        found.append(each)
        queue.extend(parts(each) or ())
    return [*found, *tables]


def _is_operator(name: str) -> bool:
    return name[:2] == "__" and name not in ("__init__", "__deepcopy__", "__repr__", "__del__", "__reduce__")


def _methods(cls: type, names: set[str]) -> list[FunctionType]:
    """The functions of a class with these names, behind properties and decorators, too."""
    found = (vars(base)[name] for base in cls.__mro__ for name in names if name in vars(base))
    return [each for value in found for each in _unwrapped(value)]


def _unwrapped(value: Any) -> list[FunctionType]:
    if isinstance(value, property):
        return [each for each in (value.fget, value.fset) if isinstance(each, FunctionType)]
    value = value.func if isinstance(value, cached_property) else getattr(value, "__func__", value)
    return [value] if isinstance(value, FunctionType) else []


def _codes(code: CodeType) -> Iterator[CodeType]:
    """Some code, and the code of the functions in it."""
    yield code
    for each in code.co_consts:
        if isinstance(each, CodeType):
            yield from _codes(each)


def _same(value: Any) -> Any:
    return value


def _keep(value: Any) -> None:
    """The place always has the same object."""


def _content(cell: Any) -> Any:
    try:
        return cell.cell_contents
    except ValueError:
        return _MISSING


def _of_class(cls: type, name: str) -> Any:
    return vars(cls).get(name, _MISSING)


def _set_class(cls: type, name: str, value: Any) -> None:
    if value is not _MISSING:
        setattr(cls, name, value)
    elif name in vars(cls):
        delattr(cls, name)


def _global(space: dict[str, Any], name: str) -> Callable[[Any], None]:
    def write(value: Any) -> None:
        if value is not _MISSING:
            space[name] = value
        else:
            space.pop(name, None)

    return write


def _context() -> dict[Any, Any]:
    return dict(contextvars.copy_context().items())


def _set_context(value: Mapping[Any, Any]) -> None:
    for variable, each in value.items():
        variable.set(each)


def _set_environ(value: Mapping[str, str]) -> None:
    os.environ.clear()
    os.environ.update(value)


def _differs(slot: _Slot) -> bool:
    value = slot.read()
    return _fingerprint(value)[1] != slot.print


def _is_mutable(value: Any) -> bool:
    return not isinstance(value, (*PLAIN, FunctionType, BuiltinFunctionType)) and value is not _MISSING


def _names(owner: Any) -> dict[str, Any]:
    """The plain values of a class or a module by name; an ellipsis stands for any other value."""
    held = [*vars(owner).items()]
    return {name: value if isinstance(value, PLAIN) else ... for name, value in held if name[:2] != "__"}


def _set_names(owner: Any, value: Mapping[str, Any]) -> None:
    now = _names(owner)
    for name in now.keys() - value.keys():
        delattr(owner, name)
    for name, each in value.items():
        if each is not ... and (name not in now or now[name] is not each):
            setattr(owner, name, each)


def _buffer(value: Any) -> memoryview | None:
    """The writable memory of an array, a number of C and the like; None if a value has none."""
    try:
        memory = memoryview(value)
        return None if memory.readonly else memory.cast("B")
    except (TypeError, ValueError, BufferError):
        return None


def _inner(value: Any) -> dict[str, Any]:
    """The attributes and slots of an object of a class of Python."""
    places = {name for cls in type(value).__mro__ for name, each in vars(cls).items() if _is_slot(name, each)}
    slots = {name: getattr(value, name) for name in places if hasattr(value, name)}
    return slots | getattr(value, "__dict__", {})


def _is_slot(name: str, value: Any) -> bool:
    return isinstance(value, MemberDescriptorType) and name[:2] != "__"


def _saved(value: Any) -> Any:
    """A copy of a mutable value, for `_refill`; of an object whose copy may be itself, of its attributes."""
    if isinstance(value, _CONTAINERS) or is_generator(value):
        return copy.deepcopy(value)
    return copy.deepcopy(_inner(value)) if (memory := _buffer(value)) is None else memory.tobytes()


def _refill(value: Any, content: Any) -> None:
    """Give a mutable object the content that `_saved` has kept."""
    if is_generator(value):
        set_back(value, content)
    elif isinstance(value, list):
        value[:] = content
    elif isinstance(value, np.ndarray):
        value[...] = content
    elif isinstance(value, dict | set):
        value.clear()
        value.update(content)
    elif isinstance(value, deque):
        value.clear()
        value.extend(content)
    elif (memory := _buffer(value)) is not None:
        memory[:] = content
    else:
        for name in _inner(value).keys() | content.keys():
            slot, kept = getattr(type(value), name, None), name in content
            if isinstance(slot, MemberDescriptorType):
                slot.__set__(value, content[name]) if kept else slot.__delete__(value)
            elif kept:
                vars(value)[name] = content[name]
            else:
                del vars(value)[name]


def _fingerprint(value: Any) -> tuple[int, bytes]:
    """The number of parts of a value, and a digest of all that Python shows of it."""
    digest, seen, stack = blake2b(digest_size=16), dict[int, tuple[int, Any]](), [value]
    while stack and len(seen) < _LARGE:
        each = stack.pop()
        if isinstance(each, type | ModuleType) or each is _MISSING:
            digest.update(f"{id(each)};".encode())
        elif isinstance(each, PLAIN):
            digest.update(f"{type(each).__name__}{each!r};".encode())
        elif id(each) in seen:
            digest.update(f"again {seen[id(each)][0]};".encode())
        else:
            seen[id(each)] = len(seen), each
            if is_generator(each):
                digest.update(drawn(each).encode())
            elif isinstance(each, np.ndarray) and each.dtype != object:
                digest.update(f"{each.shape}{each.dtype}".encode() + each.tobytes())
            elif (memory := _buffer(each)) is not None:
                digest.update(memory.tobytes())
            else:
                held = parts(each)
                inner = [id(each)] if held is None else list(held)
                digest.update(f"{type(each).__qualname__}{len(inner)};".encode())
                stack += reversed(inner)
    return len(seen), digest.digest()
