"""The code of an object of the main program or of a notebook, whose module also has the code that runs the study.

So only what the object uses counts: its own functions, and the functions, classes and constants that these name.
"""

import ast
import dis
import inspect
import textwrap
from collections.abc import Iterator
from functools import partial
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any, NamedTuple

from llf_teacher.studies.definition.parsed_code import digest_of, plain

_MAIN = "__main__"
_CONSTANTS = (int, float, complex, str, bytes, type(None))
_OF_PYTHON = (
    *("__module__", "__qualname__", "__doc__", "__dict__", "__weakref__", "__slots__", "__abstractmethods__"),
    *("__firstlineno__", "__static_attributes__", "__annotations__", "__annotate_func__", "__match_args__"),
    *("__annotations_cache__", "__orig_bases__", "__parameters__", "__classdictcell__", "_abc_impl"),
)


class LiveCode(NamedTuple):
    """The code behind an object."""

    digest: str
    modules: tuple[str, ...]
    """Other modules that it uses."""
    unseen: tuple[str, ...]
    """Values that it uses and that are not compared."""


def live_code(thing: Any) -> LiveCode:
    """The code of a class or a function of the main module."""
    walk = _Walk()
    walk.visit("", thing)
    fixed = {name: value for name, value in walk.values.items() if name.rpartition(".")[2] not in walk.assigned}
    digest = digest_of(repr((walk.sources, sorted(fixed.items()))).encode())
    return LiveCode(digest, tuple(dict.fromkeys(walk.modules)), tuple(dict.fromkeys(walk.unseen)))


class _Walk:
    """A walk over all that an object uses."""

    def __init__(self) -> None:
        self.sources: list[Any] = []
        self.values: dict[str, str] = {}
        """Constants by the name of the variable or the attribute."""
        self.assigned: set[str] = set()
        """Names that functions assign to, so that their values say nothing about the code."""
        self.modules: list[str] = []
        self.unseen: list[str] = []
        self._seen: set[int] = set()

    def visit(self, name: str, thing: Any) -> None:
        """Add what a name stands for."""
        if isinstance(thing, _CONSTANTS) or (isinstance(thing, tuple | frozenset) and _is_constant(thing)):
            self.values[name] = repr(sorted(map(repr, thing)) if isinstance(thing, frozenset) else thing)
            return
        if id(thing) in self._seen:
            return
        self._seen.add(id(thing))
        if isinstance(thing, ModuleType):
            self.modules.append(thing.__name__)
        elif isinstance(thing, FunctionType | type) and thing.__module__ != _MAIN:
            self.modules.append(thing.__module__)
        elif isinstance(thing, FunctionType):
            self._function(name, thing)
        elif isinstance(thing, type):
            self._class(thing)
        elif isinstance(thing, staticmethod | classmethod):
            self.visit(name, thing.__func__)
        elif isinstance(thing, property):
            for each in (thing.fget, thing.fset):
                self.visit(name, each)
        elif isinstance(thing, partial):
            self.visit(name, thing.func)
            self.visit(f"{name} arguments", (*thing.args, *thing.keywords.items()))
        elif not isinstance(thing, BuiltinFunctionType):
            self.unseen.append(f"the value of {name} in the main program")
            self.visit(name, type(thing))

    def _class(self, cls: type) -> None:
        self.sources.append(("class", cls.__name__, [base.__name__ for base in cls.__bases__]))
        for base in cls.__bases__:
            self.visit(base.__name__, base)
        for name, each in sorted(vars(cls).items()):
            if name not in _OF_PYTHON and not name.startswith("__dataclass_") and not inspect.ismemberdescriptor(each):
                self.visit(f"{cls.__name__}.{name}", each)

    def _function(self, name: str, function: FunctionType) -> None:
        if (
            inspect.unwrap(function).__code__.co_filename == "<string>"
        ):  # made by `dataclass`, from what is visited anyway
            return
        self.sources.append((name, _source(function)))
        for code in _codes(function.__code__):
            for step in dis.get_instructions(code):
                if step.opname in ("STORE_ATTR", "STORE_GLOBAL"):
                    self.assigned.add(f"{step.argval}")
            for used in code.co_names:
                if used in function.__globals__:
                    self.visit(used, function.__globals__[used])
        for i, cell in enumerate(function.__closure__ or ()):
            self.visit(f"{name}, variable {function.__code__.co_freevars[i]}", cell.cell_contents)
        for value in (*(function.__defaults__ or ()), *(function.__kwdefaults__ or {}).values()):
            self.visit(f"{name}, a default", value)


def _is_constant(values: Any) -> bool:
    return all(isinstance(each, _CONSTANTS) or (isinstance(each, tuple) and _is_constant(each)) for each in values)


def _codes(code: CodeType) -> Iterator[CodeType]:
    """A function's code, and that of the functions in it."""
    yield code
    for each in code.co_consts:
        if isinstance(each, CodeType):
            yield from _codes(each)


def _source(function: FunctionType) -> Any:
    """The parsed code of a function; what Python made of it if there is no source."""
    try:
        return plain(ast.parse(textwrap.dedent(inspect.getsource(function))))
    except (OSError, TypeError, SyntaxError, ValueError):
        codes = list(_codes(function.__code__))
        return [(code.co_code, [each for each in code.co_consts if _is_constant((each,))]) for code in codes]
