"""The interface of an experiment: one ability, the teachers to compare, and the environments."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from types import MappingProxyType

from llf_teacher.suite import experiments
from llf_teacher.suite.environments import ARMS, HOUSE

TURNS, SEEDS = 12, 20
"""Greatest number of turns of a lesson, and number of worlds in most experiments."""


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """An ability, and the contrast in regret that measures it.

    The contrast is a student's regret in the lessons of `worse` minus its regret in those of `better`, in the same
    worlds. The score is the contrast divided by that of the `reference`: 1 for the reference, 0 for a student that
    takes no notice. With a `margin` the ability is to take no notice, and the score is 1 minus the ratio.
    """

    ability: str
    """The ability, as the end of a sentence that begins with the student's name."""
    better: str
    """Spec of the teacher in whose lessons a student with the ability has less regret."""
    reference: str = "reasoner(worlds=64)"
    """Spec of the student whose contrast is the unit of the score."""
    worse: str = ""
    """Spec of the other teacher; empty: a placebo, as many words as the better teacher's without meaning."""
    ids: Sequence[str] = (ARMS, HOUSE)
    """Environments of at least two families."""
    seeds: int = SEEDS
    """Number of worlds in each environment, more for noisy scores; a smaller number for all experiments takes
    precedence.
    """
    since: int = 0
    """Number of turns at the start whose regret does not count."""
    margin: float | None = None
    """For abilities to take no notice, the greatest difference of the score from 1 that counts as none."""
    unit: tuple[str, str] | None = None
    """Specs of the better and the worse teacher for the unit; None: the teachers of the contrast."""
    rests_on: Sequence[str] = ()
    """Names of experiments whose ability is necessary for this one."""
    lessons: str = ""
    """World of a lesson before the measured test, which has no teacher: the `same` as the test's, or the `next` one;
    empty: the lessons themselves are measured."""
    town: bool = False
    """Whether each test and its lessons have a town of their own, whose number is the seed, with a common law."""

    @property
    def arms(self) -> tuple[str, str, str]:
        """The specs of the compared teachers: the better, the worse, and a silent one."""
        return self.better, self.worse or f"{self.better} | placebo", "silent"


@cache
def all_experiments() -> Mapping[str, Experiment]:
    """Every experiment by its name, in the order of a card: the modules of `llf_teacher.suite.experiments`."""
    return MappingProxyType({name: import_module(f"{experiments.__name__}.{name}").EXPERIMENT for name in ORDER})


def asked(name: str) -> str:
    """What a student is asked in an experiment, in plain words; empty for an unknown name."""
    return f"{import_module(f'{experiments.__name__}.{name}').ASKED}" if name in ORDER else ""


ORDER = (
    *("advice", "warnings", "praise", "blame", "hints"),
    *("silence", "recall", "rules", "voice", "truisms", "turncoat"),
)
"""The names in the order of a card."""
