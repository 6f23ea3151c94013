"""The interface of a reproduced result: a claim with its source and its rule, what is played, and how to read it."""

import hashlib
import importlib.util
import json
import pkgutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from llf_teacher.reproductions import rows
from llf_teacher.reproductions.rule import Rule, Setting
from llf_teacher.studies.analysis.statistics import Estimate, mean_interval
from teachers.spec import unknown
from worlds.extras import pip_install

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIRST_SEED = 70_000
"""First seed of results; smaller seeds are for tuning, or were looked at before the rules were written."""
QUICK = 3
"""Seeds of each setting in a trial."""
OURS = "a question of ours"
"""The source of a claim that no paper makes."""


class Values:
    """Measurements: per setting an array of shape (seeds, numbers)."""

    def __init__(self, measured: Mapping[str, NDArray[np.float64]], seconds: float) -> None:
        self._measured = measured
        self.seconds = seconds
        """CPU time of all measurements."""
        self.seeds = min(map(len, measured.values()))
        """Number of seeds of each setting."""

    def __call__(self, **setting: Any) -> NDArray[np.float64]:
        """The numbers of a setting, one row per seed; all settings have the same seeds in the same order."""
        return self._measured[digest(setting)]

    def means(self, **setting: Any) -> list[Estimate]:
        """The mean of each number of a setting, with its interval."""
        return [mean_interval(column) for column in self(**setting).T]


class Reading(NamedTuple):
    """What was seen, beside the verdict of the rule."""

    ours: str
    """Our result, with its numbers."""
    why: str = ""
    """The reasons, and what differs from the source."""
    table: Sequence[Sequence[str]] = ()
    """All results: a row of heads, then the others."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """A known result and its reproduction."""

    claim: str
    source: str
    protocol: str
    """What is played, with all parameters, in complete sentences."""
    rule: Rule
    """Declared before any of its seeds is played, the first of them `FIRST_SEED`."""
    settings: Sequence[Setting]
    measure: Callable[..., Sequence[float]]
    """Plays a setting with a `seed`; a global function, since other processes call it."""
    measures: Sequence[str]
    """Names of the numbers that it gives."""
    read: Callable[[Values], Reading]
    draw: "Callable[[Values, Figure], None]"
    needs: str = ""
    """A module of the extra `learn` that `measure` needs; empty: none."""

    def missing(self) -> str:
        """Why the row cannot be measured here; empty if it can."""
        if not self.needs or importlib.util.find_spec(self.needs):
            return ""
        return f"needs {self.needs!r}, which is not installed; run: {pip_install('learn')}"


def digest(setting: Setting) -> str:
    """A digest that identifies a setting."""
    return hashlib.sha256(json.dumps(setting, sort_keys=True).encode()).hexdigest()[:16]


def all_rows() -> dict[str, Row]:
    """Every row by its name, in alphabetical order."""
    names = sorted(module.name for module in pkgutil.iter_modules(rows.__path__))
    return {name: import_module(f"{rows.__name__}.{name}").ROW for name in names}


def some_rows(names: Sequence[str]) -> dict[str, Row]:
    """The rows with these names; all without names.

    Raises:
        ValueError: an unknown name.
        ModuleNotFoundError: a named row needs a package that is not installed; the message has the pip line.
    """
    there = all_rows()
    for name in names:
        if name not in there:
            raise ValueError(unknown("row", name, there))
        if why := there[name].missing():
            raise ModuleNotFoundError(f"the row {name} {why}", name=there[name].needs)
    return {name: there[name] for name in names or there}


def describe(estimate: Estimate, digits: int = 2) -> str:
    """An estimate with its interval, as text; a star stands for an interval that would not cover."""
    return f"{estimate.mean:.{digits}f}*" if estimate.why else estimate.text(digits)
