"""Spec strings such as `mistake(eps=0.1) | delayed(turns=2)`: frozen values that are written as text."""

import ast
import dataclasses
import difflib
import importlib
import pkgutil
import reprlib
import threading
import warnings
from collections.abc import Iterable
from functools import cache, cached_property
from types import ModuleType
from typing import Annotated, Any, ClassVar, Generic, NamedTuple, TypeVar, get_type_hints

_PARSER = threading.Lock()  # Python 3.11 counts the depth of what is parsed for all threads together, and may fail


class Range(NamedTuple):
    """What a number may be, as in `eps: Annotated[float, Range(0, 1)] = 0.1`; a bound may be another parameter's name.

    An `int` must be an integer; a `float` may be one.
    """

    low: float | str
    """The least value."""
    high: float | str
    """The greatest value."""


Share = Annotated[float, Range(0, 1)]
"""A probability, or a part of a whole: 0 to 1."""
Count = Annotated[int, Range(0, 1_000_000)]
"""How many: at least 0."""


@dataclasses.dataclass(frozen=True)
class Spec:
    """A frozen dataclass that is named like its module; `str` gives its spec string.

    A class outside of a `shelf` is named as in Python: `str` shows it, but no spec string can name it. Fields that are
    annotated with a `Range` are checked.
    """

    shelf: ClassVar[str] = ""
    """The package whose modules are named in spec strings."""

    @property
    def name(self) -> str:
        """The name by which spec strings call it; that of its class if they cannot."""
        package, _, module = type(self).__module__.rpartition(".")
        return module if package == self.shelf else type(self).__name__

    def __post_init__(self) -> None:
        for name, kind, bounds in self._ranges():
            low, high = (getattr(self, bound) if isinstance(bound, str) else bound for bound in bounds)
            check_range(name, getattr(self, name), low, high, kind)

    @classmethod
    @cache
    def _ranges(cls) -> tuple[tuple[str, type, Range], ...]:
        """The fields that have a range, each with its type."""
        hints = get_type_hints(cls, include_extras=True)
        return tuple(
            (field.name, hints[field.name].__origin__, note)
            for field in dataclasses.fields(cls)
            for note in getattr(hints[field.name], "__metadata__", ())
            if isinstance(note, Range)
        )

    def __str__(self) -> str:
        given = [
            f"{field.name}={getattr(self, field.name)!r}"
            for field in dataclasses.fields(self)
            if getattr(self, field.name) != field.default
        ]
        return f"{self.name}({', '.join(given)})" if given else self.name


S = TypeVar("S", bound=Spec)


class Shelf(Generic[S]):
    """The specs of one base class, one in each module of a package.

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
        """The class of a name.

        Raises:
            ValueError: there is none of that name.
        """
        if name not in self.names:
            raise ValueError(unknown(self._what, name, self.names))
        module = importlib.import_module(f"{self._package.__name__}.{name}")
        found = [
            value
            for value in vars(module).values()
            if isinstance(value, type) and issubclass(value, self._base) and value.__module__ == module.__name__
        ]
        if len(found) != 1:
            raise ValueError(f"{module.__name__} must define one {self._base.__name__}, it defines {len(found)}")
        return found[0]

    def parse(self, text: str) -> tuple[S, ...]:
        """The specs that a string names, separated by `|`.

        Raises:
            ValueError: the text is no such string, or a name, a parameter or a value is not allowed.
        """
        if not isinstance(text, str):
            raise self._error(text)
        try:
            node = read_expression(text)
        except ValueError:
            raise self._error(text) from None
        parts: list[ast.expr] = []
        while isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitOr):
            parts.append(node.right)
            node = node.left
        return tuple(self._one(part, text) for part in reversed([*parts, node]))

    def _one(self, node: ast.expr, text: str) -> S:
        call = read_call(node)
        if call is None:
            raise self._error(text)
        name, values = call
        cls = self[name]
        allowed = [field.name for field in dataclasses.fields(cls)]
        for key in values:
            if key not in allowed:
                options = ", ".join(allowed) or "none"
                raise ValueError(f"{self._what} {name!r} has no parameter {key!r}; allowed: {options}")
        try:
            return cls(**values)
        except TypeError as error:
            raise ValueError(f"{self._what} {text!r}: {error}") from None

    def _error(self, text: object) -> ValueError:
        return ValueError(
            f"bad {self._what} spec {reprlib.repr(text)}; expected names with keyword arguments, such as "
            f"`name` or `name(key=value)`, separated by `|`; names: {', '.join(self.names)}"
        )


def read_expression(text: str) -> ast.expr:
    """The syntax tree of an expression; nothing is evaluated.

    Raises:
        ValueError: the text is no expression.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SyntaxWarning)
            with _PARSER:
                return ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError(f"{reprlib.repr(text)} is no expression") from None


def read_call(node: ast.expr) -> tuple[str, dict[str, Any]] | None:
    """The name and the keyword arguments, literals all, of `name` or `name(key=value)`; None if it is neither."""
    call = node if isinstance(node, ast.Call) else ast.Call(func=node, args=[], keywords=[])
    if not isinstance(call.func, ast.Name) or call.args or any(keyword.arg is None for keyword in call.keywords):
        return None
    try:
        values = {str(keyword.arg): ast.literal_eval(keyword.value) for keyword in call.keywords}
    except (ValueError, TypeError, RecursionError, MemoryError):
        return None
    return (call.func.id, values) if len(values) == len(call.keywords) else None


def import_call(role: str, kind: str, spec: str) -> tuple[ModuleType, str, dict[str, Any]]:
    """The module, the name and the keyword arguments of `package.module:name(key=value)`; this imports the module.

    `role` and `kind` are for the message: what the spec describes, and what the name is of.

    Raises:
        ValueError: bad syntax, or a module that cannot be imported.
    """
    module, _, call = spec.strip().partition(":")
    try:
        parsed = read_call(read_expression(call))
    except ValueError:
        parsed = None
    if parsed is None:
        form = f"package.module:{kind}"
        raise ValueError(f"bad {role} spec {spec!r}; expected `{form}` or `{form}(key=value)`")
    try:
        return (importlib.import_module(module.strip()), *parsed)
    except Exception as error:  # whatever a user's module does when it is imported
        raise ValueError(f"{role} {spec!r}: cannot import the module {module.strip()!r}: {error!r}") from error


def unknown(what: str, got: object, allowed: Iterable[str], where: str = "") -> str:
    """The message for a name that is not among the allowed ones, with the nearest of them.

    All that are allowed are listed, unless `where` tells what shows them.
    """
    allowed = tuple(allowed)
    near = difflib.get_close_matches(str(got), allowed, n=3, cutoff=0.4)
    hint = f"did you mean {' or '.join(near)}? " if near else ""
    if where:
        return f"unknown {what} {got!r}; {hint}all {len(allowed)} that are allowed are shown by {where}"
    listing = ", ".join(allowed) if len(allowed) <= 40 else f"{', '.join(allowed[:40])}, ..."
    return f"unknown {what} {got!r}; {hint}allowed: {listing}"


def check_range(name: str, value: Any, low: float, high: float, kind: type = float) -> None:
    """Check a parameter.

    Raises:
        ValueError: the value is not a number of the kind, or outside `[low, high]`.
    """
    allowed = (int,) if kind is int else (int, float)
    if isinstance(value, bool) or not isinstance(value, allowed) or not low <= value <= high:
        noun = "an integer" if kind is int else "a number"
        raise ValueError(f"{name} must be {noun} from {low} to {high}, got {value!r}")
