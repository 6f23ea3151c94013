"""What a reproduced result is: a claim with its source, settings that are played, and what their values say of it."""

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
from llf_teacher.studies.analysis.statistics import Estimate
from teachers.spec import unknown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Setting = Mapping[str, Any]
"""Keyword arguments of a row's `measure`, JSON values. What they do not say cannot change while results are kept."""
FIRST_SEED = 10_000
"""Seeds from here on belong to results; those below it are for trying things out."""
QUICK = 3
"""Seeds of each setting when it is only tried whether all runs."""
VERDICTS = ("yes", "in part", "no")


class Values:
    """What was measured: per setting an array of shape (seeds, numbers)."""

    def __init__(self, measured: Mapping[str, NDArray[np.float64]], seconds: float) -> None:
        self._measured = measured
        self.seconds = seconds
        """CPU time of all measurements."""
        self.seeds = min(map(len, measured.values()))
        """Measurements of each setting."""

    def __call__(self, **setting: Any) -> NDArray[np.float64]:
        """The numbers of a setting, a row a seed; the rows of all settings have the same seeds in the same order."""
        return self._measured[digest(setting)]


class Reading(NamedTuple):
    """What the values say."""

    agrees: str
    """One of `VERDICTS`."""
    ours: str
    """Our result, with its figures."""
    why: str = ""
    """Where and why it differs from the source; empty if it does not."""
    table: Sequence[Sequence[str]] = ()
    """All of it: a row of heads, then the others."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """A known result and how it is tried here."""

    claim: str
    source: str
    protocol: str
    """What is played, with all that determines it; complete sentences."""
    settings: Sequence[Setting]
    seeds: int
    """Number of seeds of each setting, the first of them `FIRST_SEED`."""
    measure: Callable[..., Sequence[float]]
    """Plays a setting with a `seed`; a function of a module, since other processes call it."""
    measures: Sequence[str]
    """What the numbers are that it gives, in their order."""
    read: Callable[[Values], Reading]
    draw: "Callable[[Values, Figure], None]"
    needs: str = ""
    """A module of the extra `learn` that measuring needs; empty if the core is enough."""

    def missing(self) -> str:
        """What keeps it from being measured here; empty if nothing does."""
        if not self.needs or importlib.util.find_spec(self.needs):
            return ""
        return f"needs {self.needs!r}, which is not installed; run: pip install 'llf-teacher[learn]'"


def digest(setting: Setting) -> str:
    """What tells a setting from others."""
    return hashlib.sha256(json.dumps(setting, sort_keys=True).encode()).hexdigest()[:16]


def all_rows() -> dict[str, Row]:
    """Every row by its name, in alphabetical order."""
    names = sorted(module.name for module in pkgutil.iter_modules(rows.__path__))
    return {name: import_module(f"{rows.__name__}.{name}").ROW for name in names}


def some_rows(names: Sequence[str]) -> dict[str, Row]:
    """The rows of these names; all if there are none.

    Raises:
        ValueError: there is no such row.
        ModuleNotFoundError: one of these names needs a package that is not installed; the message has the pip line.
    """
    there = all_rows()
    for name in names:
        if name not in there:
            raise ValueError(unknown("row", name, there))
        if why := there[name].missing():
            raise ModuleNotFoundError(f"the row {name} {why}", name=there[name].needs)
    return {name: there[name] for name in names or there}


def describe(estimate: Estimate, digits: int = 2) -> str:
    """An estimate with its interval."""
    return f"{estimate.mean:.{digits}f} [{estimate.low:.{digits}f}, {estimate.high:.{digits}f}]"
