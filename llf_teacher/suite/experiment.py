"""The interface of an experiment: one ability, the teachers whose lessons are compared, and where."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cache
from importlib import import_module
from types import MappingProxyType
from typing import Any

from llf_teacher.suite import experiments
from llf_teacher.suite.places import ARMS, HOUSE, OPTIONS

TURNS, SEEDS = 12, 20
"""Turns of every lesson, at most, and worlds of most experiments."""
SILENT = "silent"
"""Spec of the teacher of the third arm, where the ability is to take notice."""


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """An ability, and the contrast in regret that measures it.

    The contrast is what a student loses in the lessons of `worse` beyond those of `better`, in the same worlds. Its
    unit is the contrast of the `reference`. The score is `offset` and the contrast in that unit, so that it is 1 for
    the reference and 0 for a student that takes no notice; from an offset of 1 on the contrast is subtracted.
    """

    ability: str
    """What the student does, as the end of a sentence that begins with its name."""
    better: str
    """Spec of the teacher whose lessons a student with the ability loses less in."""
    worse: str
    """Spec of the other teacher: usually the same words' number and length without a meaning."""
    reference: str
    """Spec of the student whose contrast is the unit."""
    ids: Sequence[str] = (ARMS, HOUSE)
    """Environments, of two families at least."""
    seeds: int = SEEDS
    """Number of worlds in each, more where scores are noisy; a smaller number of all experiments goes before it."""
    since: int = 0
    """Number of turns at the start whose regret does not count."""
    offset: float = 0.0
    """Score of a student without a contrast: 1 where the ability is to take no notice."""
    margin: float | None = None
    """Where both lessons should be alike, the greatest difference of the score from 1 that is not one."""
    unit: tuple[str, str] | None = None
    """Specs of the better and the worse teacher of the unit; None: those of the contrast."""
    rests_on: Sequence[str] = ()
    """Names of experiments without whose ability this one cannot be had."""
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=lambda: OPTIONS)
    """Options of the environments' worlds, by id; an id has the same in all experiments without `lessons`."""
    lessons: int = 0
    """Number of earlier episodes with the teachers; what is measured is then a test after them without a teacher."""
    worlds: str = "same"
    """Worlds of these: `same` as that of the test, or those that come `next`."""
    town: bool = False
    """Whether each test and its lessons are in a town of their own, whose number is the seed, with a law in common."""

    @property
    def arms(self) -> tuple[str, ...]:
        """The specs of the teachers whose lessons are compared."""
        return (self.better, self.worse, *(() if self.offset else (SILENT,)))

    @property
    def teachers(self) -> tuple[str, ...]:
        """The specs of all teachers, without repetition."""
        return tuple(dict.fromkeys((*self.arms, *(self.unit or ()))))

    def as_dict(self) -> dict[str, Any]:
        """All that decides a score, as JSON values."""
        values = {each.name: getattr(self, each.name) for each in fields(self)}
        return values | {"options": {id: dict(each) for id, each in self.options.items()}, "teachers": self.teachers}


@cache
def all_experiments() -> Mapping[str, Experiment]:
    """Every experiment by its name, in the order of a card: the modules of `llf_teacher.suite.experiments`."""
    return MappingProxyType({name: import_module(f"{experiments.__name__}.{name}").EXPERIMENT for name in ORDER})


ORDER = (
    *("advice", "warnings", "praise", "blame", "late", "hints"),
    *("silence", "recall", "rules", "voice", "truisms", "turncoat"),
)
"""The names in the order of a card."""
