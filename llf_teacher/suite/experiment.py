"""The interface of an experiment: one ability, the teachers whose lessons are compared, and where."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from types import MappingProxyType

from llf_teacher.suite import experiments
from llf_teacher.suite.environments import ARMS, HOUSE

TURNS, SEEDS = 12, 20
"""Turns of every lesson, at most, and worlds of most experiments."""


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """An ability, and the contrast in regret that measures it.

    The contrast is what a student loses in the lessons of `worse` beyond those of `better`, in the same worlds. Its
    unit is the contrast of the `reference`. The score is the contrast in that unit, so that it is 1 for the reference
    and 0 for a student that takes no notice. With a `margin` the ability is to take no notice, and the score is 1 less
    the contrast.
    """

    ability: str
    """What the student does, as the end of a sentence that begins with its name."""
    better: str
    """Spec of the teacher whose lessons a student with the ability loses less in."""
    reference: str = "reasoner(worlds=64)"
    """Spec of the student whose contrast is the unit."""
    worse: str = ""
    """Spec of the other teacher; empty: as many words as of the better one, without a meaning."""
    ids: Sequence[str] = (ARMS, HOUSE)
    """Environments, of two families at least."""
    seeds: int = SEEDS
    """Number of worlds in each, more where scores are noisy; a smaller number of all experiments goes before it."""
    since: int = 0
    """Number of turns at the start whose regret does not count."""
    margin: float | None = None
    """Where both lessons should be alike, the greatest difference of the score from 1 that is not one."""
    unit: tuple[str, str] | None = None
    """Specs of the better and the worse teacher of the unit; None: those of the contrast."""
    rests_on: Sequence[str] = ()
    """Names of experiments without whose ability this one cannot be had."""
    lessons: str = ""
    """Worlds of an earlier episode with the teachers, after which a test without a teacher is measured: the `same` as
    that of the test, or a `next` one; empty: there is none."""
    town: bool = False
    """Whether each test and its lessons are in a town of their own, whose number is the seed, with a law in common."""

    @property
    def arms(self) -> tuple[str, str, str]:
        """The specs of the teachers whose lessons are compared: the better, the worse, and a silent one."""
        return self.better, self.worse or f"{self.better} | placebo", "silent"


@cache
def all_experiments() -> Mapping[str, Experiment]:
    """Every experiment by its name, in the order of a card: the modules of `llf_teacher.suite.experiments`."""
    return MappingProxyType({name: import_module(f"{experiments.__name__}.{name}").EXPERIMENT for name in ORDER})


ORDER = (
    *("advice", "warnings", "praise", "blame", "hints"),
    *("silence", "recall", "rules", "voice", "truisms", "turncoat"),
)
"""The names in the order of a card."""
