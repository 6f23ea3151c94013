"""Spec strings such as `mistake(eps=0.1) | delayed(turns=2)`: frozen values as text."""

import ast
import contextlib
import dataclasses
import difflib
import importlib
import inspect
import math
import pkgutil
import re
import reprlib
import threading
import traceback
import warnings
from collections.abc import Callable, Iterable, Mapping
from functools import cache, cached_property, lru_cache
from numbers import Integral, Real
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any, ClassVar, Generic, NamedTuple, TypeGuard, TypeVar, get_type_hints

_PARSER = threading.Lock()  # Python 3.11 counts the nesting of all threads together, and may fail
T = TypeVar("T")


class Range(NamedTuple):
    """The range of a number, as in `eps: Annotated[float, Range(0, 1)] = 0.1`.

    A bound may be the name of another parameter. An `int` must be an integer; a `float` may be one.
    """

    low: float | str
    """The least value."""
    high: float | str
    """The greatest value."""


Share = Annotated[float, Range(0, 1)]
"""A probability or a fraction, 0 to 1."""
Count = Annotated[int, Range(0, 1_000_000)]
"""A number of things, 0 to 1,000,000."""

Worlds = Annotated[int, Range(1, 100_000)]
"""A number of worlds that are drawn."""


@dataclasses.dataclass(frozen=True)
class Spec:
    """A frozen dataclass named like its module; `str` gives its spec string.

    A class outside `package` keeps its Python name; spec strings name it with its module, as in `moods:Grudge`. Fields
    annotated with a `Range` and fields of type `bool` are checked; None passes in a field of `float | None`.
    """

    package: ClassVar[str] = ""
    """The package whose modules spec strings name."""

    @property
    def name(self) -> str:
        """The name in spec strings; outside `package` the name of the class."""
        package, _, module = type(self).__module__.rpartition(".")
        return module if package == self.package else type(self).__name__

    @property
    def _path(self) -> str:
        """The name with the module of a class outside `package`; a class within a function has no other name."""
        cls = type(self)
        inside = cls.__module__.rpartition(".")[0] == self.package or not cls.__qualname__.isidentifier()
        return self.name if inside else f"{cls.__module__}:{cls.__qualname__}"

    def __post_init__(self) -> None:
        for name, kind, bounds in self._checked():
            value = getattr(self, name)
            if bounds is None:
                if not isinstance(value, bool):
                    raise ValueError(f"{name} must be True or False, got {value!r}")
            elif value is not None or not isinstance(None, kind):
                low, high = (getattr(self, bound) if isinstance(bound, str) else bound for bound in bounds)
                check_range(name, value, low, high, kind)

    @classmethod
    @cache
    def _checked(cls) -> tuple[tuple[str, type, Range | None], ...]:
        """The checked fields, each with its type and its range; `bool` has no range."""
        hints = get_type_hints(cls, include_extras=True)
        found: list[tuple[str, type, Range | None]] = []
        for field in dataclasses.fields(cls):
            hint = hints[field.name]
            ranges = [note for note in getattr(hint, "__metadata__", ()) if isinstance(note, Range)]
            found += [(field.name, hint.__origin__, each) for each in ranges]
            if hint is bool:
                found.append((field.name, bool, None))
        return tuple(found)

    def __str__(self) -> str:
        values = {field.name: (getattr(self, field.name), field.default) for field in dataclasses.fields(self)}
        return call_string(self._path, {name: value for name, (value, default) in values.items() if value != default})


S = TypeVar("S", bound=Spec)


def fits(cls: type, form: str, name: str) -> bool:
    """Whether one class defines both attributes, so that `form` is another form of `name` and does the same."""
    owners = [next(base for base in cls.__mro__ if each in vars(base)) for each in (form, name)]
    return owners[0] is owners[1]


@lru_cache(maxsize=1024)
def signature_of(function: Callable[..., Any]) -> inspect.Signature:
    """The signature of a class or a function, cached since each new environment asks for some.

    Raises:
        ValueError: it has no signature.
    """
    return inspect.signature(function)


class SpecCall(NamedTuple):
    """One part of a spec string: `name(key=value)` or `module:name(key=value)`; `str` writes it."""

    name: str
    arguments: dict[str, Any]
    """Keyword arguments in the given order; literals."""
    prefix: tuple[str, ...] = ()
    """The parts before the name, each followed by a colon: a module, `chat`, or `chat` and a module."""

    def __str__(self) -> str:
        return call_string(self.path, self.arguments)

    @property
    def path(self) -> str:
        """The name with its prefix, for messages: arguments may hold a secret."""
        return ":".join((*self.prefix, self.name))

    def imported(self, what: str) -> tuple[ModuleType, Any]:
        """The module of the last prefix and its attribute of this name; None if it has none.

        Args:
            what: what the spec describes, for the message.

        Raises:
            ValueError: the module cannot be imported.
        """
        try:
            module = importlib.import_module(self.prefix[-1])
        except Exception as error:  # importing a user's module may raise anything
            raise ValueError(
                f"{what} {self.path!r}: cannot import the module {self.prefix[-1]!r}: {error!r}{_line(error)}"
            ) from error
        return module, getattr(module, self.name, None)

    def check_arguments(self, what: str, function: Callable[..., Any]) -> None:
        """Check that a function or a class takes the arguments.

        Raises:
            ValueError: a parameter is unknown or missing.
        """
        try:
            signature = signature_of(function) if isinstance(function, type) else inspect.signature(function)
        except ValueError:  # a builtin without a signature
            return
        parameters = signature.parameters.values()
        allowed = [each.name for each in parameters if each.kind in (each.POSITIONAL_OR_KEYWORD, each.KEYWORD_ONLY)]
        if not any(each.kind is each.VAR_KEYWORD for each in parameters):
            for name in self.arguments:
                if name not in allowed:
                    raise ValueError(f"{what} {self.path!r}: {unknown('parameter', name, allowed)}")
        try:
            signature.bind(**self.arguments)
        except TypeError as error:
            raise ValueError(f"{what} {self.path!r}: cannot call {self.name}{signature}: {error}") from None

    def make(self, what: str, cls: Callable[..., T]) -> T:
        """Make an object of a class from the arguments.

        Raises:
            ValueError: a parameter is unknown or missing, or a value is not allowed.
        """
        self.check_arguments(what, cls)
        try:
            return cls(**self.arguments)
        except TypeError as error:
            raise ValueError(f"{what} {self.path!r}: {error}") from None


def _line(error: Exception) -> str:
    """The innermost line of a module that ended with an error, such as ` (moods.py, line 7)`; empty without one."""
    lines = [each for each in traceback.extract_tb(error.__traceback__) if each.name == "<module>"]
    return f" ({Path(lines[-1].filename).name}, line {lines[-1].lineno})" if lines else ""


class Registry(Generic[S]):
    """The specs of one base class: one in each module of a package.

    Args:
        what: what an entry is called in error messages.
        base: the base class of the entries.
        package: the package that holds a module for each entry.
    """

    def __init__(self, what: str, base: type[S], package: ModuleType) -> None:
        self._what, self._base, self._package = what, base, package

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Every name, sorted."""
        return tuple(sorted(module.name for module in pkgutil.iter_modules(self._package.__path__)))

    def __getitem__(self, name: str) -> type[S]:
        """The class of this name.

        Raises:
            ValueError: the registry has no such name, or the module cannot be imported or defines no such class.
        """
        if name not in self.names:
            raise ValueError(unknown(self._what, name, self.names))
        try:
            module = importlib.import_module(f"{self._package.__name__}.{name}")
        except Exception as error:  # a file that somebody is writing may raise anything
            file = Path(*self._package.__path__, f"{name}.py")
            where = f"{file}:{error.lineno}" if isinstance(error, SyntaxError) and error.filename == str(file) else file
            raise ValueError(
                f"the {self._what} {name!r} cannot be imported: {type(error).__name__}: {error}; mend {where}"
            ) from error
        found = [value for value in vars(module).values() if self._fits(value) and value.__module__ == module.__name__]
        if len(found) != 1:
            base, names = self._base.__name__, ", ".join(cls.__name__ for cls in found) or "none"
            raise ValueError(
                f"{module.__file__} must define one {self._what}, a class that derives from "
                f"{self._base.__module__}.{base}; it defines {names}"
            )
        return found[0]

    @property
    def expected(self) -> str:
        """The form of its spec strings, for messages."""
        return (
            "names with keyword arguments, such as `name`, `name(key=value)` or `package.module:Class(key=value)`; "
            f"names: {', '.join(self.names)}"
        )

    def parse(self, text: str) -> tuple[S, ...]:
        """The specs of a string, separated by `|`.

        Raises:
            ValueError: bad syntax, or a name, a parameter or a value is not allowed.
        """
        return tuple(map(self.make, parse_calls(self._what, text, self.expected, prefixes=1)))

    def make(self, call: SpecCall) -> S:
        """The spec of a call; with a prefix, of a user's own class, whose module is imported.

        Raises:
            ValueError: the name, a parameter or a value is not allowed, or the module has no such class.
        """
        if not call.prefix:
            return call.make(self._what, self[call.name])
        module, cls = call.imported(self._what)
        if not self._fits(cls):
            names = [name for name, each in vars(module).items() if self._fits(each) and each is not self._base]
            where = f"{self._what} in {module.__name__}"
            raise ValueError(f"{self._what} {call.path!r}: {unknown(where, call.name, names)}")
        return call.make(self._what, cls)

    def _fits(self, value: Any) -> TypeGuard[type[S]]:
        """Whether it is a class of the registry's kind."""
        return isinstance(value, type) and issubclass(value, self._base)


_TOKEN = re.compile(
    r"""('{3}|"{3}|'|")(?>(?:\\.|(?!\1).)*)\1  # a string; by *+ Python 3.11.2 errs
    | \#[^\n]* | [(\[{] | [)\]}] | [:@]""",
    re.DOTALL | re.VERBOSE,
)


def parse_calls(what: str, text: Any, expected: str, prefixes: int = 0) -> tuple[SpecCall, ...]:
    """The parts of a spec string, from left to right. Nothing is evaluated or imported.

        spec = part, {"|", part}
        part = {prefix, ":"}, name, ["(", [key, "=", literal, {",", key, "=", literal}], ")"]

    A prefix is `chat` or the dotted name of a module; a literal is a Python literal. Brackets may enclose parts
    without a prefix.

    Args:
        what: what the string describes, for the message.
        text: the spec string.
        expected: the expected form, for the message.
        prefixes: most prefixes of a part.

    Raises:
        ValueError: the text is not of this form.
    """
    if not isinstance(text, str):
        raise bad_spec(what, text, expected)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SyntaxWarning)
            with _PARSER:
                nodes = [ast.parse(f"({_as_expression(text)})", mode="eval").body]
        calls = []
        while nodes:
            node = nodes.pop()
            if isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitOr):
                nodes += [node.right, node.left]
            else:
                calls.append(_call(node, prefixes))
    except (SyntaxError, ValueError, TypeError, RecursionError, MemoryError):
        raise bad_spec(what, text, expected) from None
    return tuple(calls)


def paths_in(spec: str) -> list[str]:
    """The users' own classes and functions that a spec string names, as `module:name`; also in specs as arguments.

    Raises:
        ValueError: the text is not the form of a spec string.
    """
    found = []
    for call in parse_calls("teacher or student", spec, "the spec of a teacher or a student", prefixes=2):
        found += [call.path] if call.prefix else []
        for value in call.arguments.values():
            if isinstance(value, str):
                with contextlib.suppress(ValueError):  # not a spec, but any text
                    found += paths_in(value)
    return found


def parse_call(what: str, text: Any, expected: str, prefixes: int = 0) -> SpecCall:
    """The only part of a spec string; arguments as in `parse_calls`.

    Raises:
        ValueError: the text is not of this form, or has several parts.
    """
    calls = parse_calls(what, text, expected, prefixes)
    if len(calls) != 1:
        raise ValueError(f"{what} spec {reprlib.repr(text)} has {len(calls)} parts, separated by `|`; allowed: 1")
    return calls[0]


def bad_spec(what: str, text: object, expected: str) -> ValueError:
    """The error for a spec string of the wrong form."""
    return ValueError(f"bad {what} spec {reprlib.repr(text)}; expected {expected}")


def call_string(name: str, arguments: Mapping[str, Any]) -> str:
    """A name with keyword arguments, as in a spec string."""
    given = ", ".join(f"{key}={value!r}" for key, value in arguments.items())
    return f"{name}({given})" if given else name


def _as_expression(text: str) -> str:
    """A spec string as a Python expression: the colon behind a prefix becomes `@`, which binds tighter than `|`.

    Raises:
        ValueError: the text has an `@` outside of strings, or closes a bracket that is not open.
    """
    depth = 0

    def replaced(token: re.Match[str]) -> str:
        nonlocal depth
        found = token[0]
        depth += (found in ("(", "[", "{")) - (found in (")", "]", "}"))
        if depth < 0 or found == "@":
            raise ValueError
        return "" if found[0] == "#" else "@" if found == ":" and not depth else found

    return _TOKEN.sub(replaced, text)


def _call(node: ast.expr, prefixes: int) -> SpecCall:
    """Convert an expression into one part of a spec string.

    Raises:
        ValueError or TypeError: the expression has another form.
    """
    operands = [node]
    while isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
        operands[:1] = [node.left, node.right]
        node = node.left
    *before, last = operands
    call = last if isinstance(last, ast.Call) else ast.Call(func=last, args=[], keywords=[])
    if not isinstance(call.func, ast.Name) or call.args or len(before) > prefixes:
        raise ValueError
    arguments = {f"{keyword.arg}": ast.literal_eval(keyword.value) for keyword in call.keywords if keyword.arg}
    if len(arguments) != len(call.keywords):  # a name twice, or `**`
        raise ValueError
    return SpecCall(call.func.id, arguments, tuple(map(_dotted_name, before)))


def _dotted_name(node: ast.expr) -> str:
    names = []
    while isinstance(node, ast.Attribute):
        names.append(node.attr)
        node = node.value
    if not isinstance(node, ast.Name):
        raise ValueError
    return ".".join([node.id, *reversed(names)])


def unknown(what: str, got: object, allowed: Iterable[str], where: str = "", near: Iterable[str] | None = None) -> str:
    """The message for a name that is not allowed: the nearest allowed names, then all of them.

    `where` says where to find the allowed names; then the message counts them and does not list them. `near` has the
    nearest names if something better than spelling finds them.
    """
    allowed = tuple(allowed)
    near = difflib.get_close_matches(str(got).strip("'"), allowed, n=3) if near is None else [*near]
    hint = f"did you mean {' or '.join(near)}? " if near else ""
    if where:
        return f"unknown {what} {got!r}; {hint}see {where} for all {len(allowed)}"
    listing = ", ".join(allowed) if len(allowed) <= 40 else f"{', '.join(allowed[:40])}, ..."
    return f"unknown {what} {got!r}; {hint}allowed: {listing or 'none'}"


def check_range(name: str, value: Any, low: float, high: float, kind: type = float) -> None:
    """Check a parameter.

    Raises:
        ValueError: the value is no number of this kind, or outside `[low, high]`.
    """
    allowed = (int,) if kind is int else (int, float)
    if isinstance(value, bool) or not isinstance(value, allowed) or not low <= value <= high:
        noun = "an integer" if kind is int else "a number"
        raise ValueError(f"{name} must be {noun} from {low} to {high}, got {value!r}")


def check_cost(name: str, value: Any) -> None:
    """Check a cost.

    Raises:
        ValueError: it is not a finite number of at least 0.
    """
    if isinstance(value, bool) or not isinstance(value, Real) or not 0 <= float(value) < math.inf:
        raise ValueError(f"{name} must be a finite number of at least 0, got {value!r}")


def is_count(value: Any, most: float = math.inf) -> TypeGuard[int]:
    """Whether a value is an integer, NumPy's included, from 1 to `most`."""
    return isinstance(value, Integral) and not isinstance(value, bool) and 1 <= int(value) <= most
