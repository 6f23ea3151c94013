"""A quality of a teacher: what is counted in the lessons of known students, and its unit."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from statistics import fmean
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from llf_teacher.suite.experiment import TURNS
from llf_teacher.suite.mirror import qualities
from llf_teacher.suite.places import ARMS, HOUSE
from llf_teacher.suite.score import Numbers
from teachers.atoms import Label

ORDER = ("truth", "calibration", "worth", "use", "timing", "news", "adapts", "fades", "pushback", "remains", "hints")
"""The names in the order of a card."""
NEW = 0.1
"""Bits below which a claim says nothing new."""
LOST = 1e-9
"""Regret up to which an action was right."""


class TaughtEpisode(NamedTuple):
    """An episode as it is stored."""

    regrets: Sequence[float]
    """By turn; shape (turns,)."""
    words: int
    turns: Sequence[Mapping[str, Any]]
    """The fields of `TurnRow`; the first is the opening."""

    def claims(self, *kinds: str) -> Iterator[Mapping[str, Any]]:
        """The feedback about the task, of some kinds or of all."""
        return (atom for turn in self.turns for atom in claims_of(turn, *kinds))

    def between(self) -> Iterator[tuple[bool, Mapping[str, Any]]]:
        """The turns after which another one comes, each with whether its action lost something."""
        return ((lost > LOST, turn) for lost, turn in zip(self.regrets[:-1], self.turns[1:-1], strict=True))


def claims_of(turn: Mapping[str, Any], *kinds: str) -> list[Mapping[str, Any]]:
    """The feedback of a turn about the task, of some kinds or of all; what was read of words without claims is last."""
    read = (
        {**each, "label": Label.TRUTHFUL if each["holds"] else Label.DISTORTED}
        for each in turn.get("readings") or ()
        if each["holds"] is not None and not any(each["text"] in atom["text"] for atom in turn["atoms"])
    )
    return [
        atom
        for atom in (*turn["atoms"], *read)
        if atom["kind"] is not None and atom["label"] != "placebo" and (not kinds or atom["kind"] in kinds)
    ]


def bits_of(atom: Mapping[str, Any]) -> float | None:
    """How much a claim says to the student; None if it was not measured."""
    found: float | None = atom.get("information", {}).get("bits")
    return found


def is_new(atom: Mapping[str, Any]) -> bool | None:
    """Whether a claim says something that the student could not know; None if it was not measured."""
    bits = bits_of(atom)
    return None if bits is None else bits >= NEW


class TaughtWorld(NamedTuple):
    """The episodes in a world, one of each student of a quality."""

    taught: Sequence[TaughtEpisode]
    silent: Sequence[TaughtEpisode]
    """The same students in the same world, whom nobody teaches."""

    @property
    def saved(self) -> float:
        """The regret that the teacher saved; NaN if it said no word."""
        if not any(each.words for each in self.taught):
            return np.nan
        return sum(sum(each.regrets) for each in self.silent) - sum(sum(each.regrets) for each in self.taught)


def by_world(count: Callable[[TaughtWorld], float]) -> Callable[[Sequence[TaughtWorld]], Numbers]:
    """The function that counts each world alone."""
    return lambda worlds: np.array([count(world) for world in worlds])


def mean(values: Sequence[float]) -> float:
    """The mean; NaN without values."""
    return fmean(values) if values else np.nan


@dataclass(frozen=True, kw_only=True)
class Quality:
    """What is counted, with whom, and the teachers of the scores 0 and 1."""

    ability: str
    """What the teacher does, as the end of a sentence that begins with its name."""
    outcome: Callable[[Sequence[TaughtWorld]], Numbers]
    """A number for each world, shape (worlds,), more is better; NaN where the quality could not show."""
    absent: str
    """Why it could not."""
    students: Sequence[str]
    reference: str
    """Spec of the teacher whose score is 1."""
    zero: str | None = None
    """Spec of the teacher whose score is 0; None: 0 is where nothing is counted."""
    rests_on: Sequence[str] = ()
    """Names of qualities without which this one cannot be had."""
    bits: int = 0
    """Number of worlds by which it is measured how much claims say; 0: it is not."""
    turns: int = TURNS
    """Turns of a lesson, at most."""
    town: bool = False
    """Whether a test in another world of a town is counted, where the teacher is absent."""
    ids: Sequence[str] = (ARMS, HOUSE)

    @property
    def teachers(self) -> tuple[str, ...]:
        """The teachers beside the one that is scored."""
        return tuple(dict.fromkeys((self.reference, *((self.zero,) if self.zero else ()), "silent")))


@cache
def all_qualities() -> Mapping[str, Quality]:
    """Every quality by its name, in the order of a card: the modules of `llf_teacher.suite.mirror.qualities`."""
    return MappingProxyType({name: import_module(f"{qualities.__name__}.{name}").QUALITY for name in ORDER})
