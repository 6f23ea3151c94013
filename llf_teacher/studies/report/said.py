"""What a teacher said to the student of a comparison."""

from collections.abc import Iterator
from typing import NamedTuple

from llf_teacher.registry import entry
from llf_teacher.studies.analysis.scores import Compared
from llf_teacher.studies.report.columns import Sums
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.section import added, share
from teachers.atoms import Label


class ClaimRates(NamedTuple):
    """A teacher's claims in a turn of the student, on average."""

    truthful: float
    """True and in time."""
    distorted: float
    """Not true in the simulator."""

    @property
    def worth(self) -> float:
        """True, timely claims less distorted ones."""
        return self.truthful - self.distorted


class ClaimCounts(NamedTuple):
    """A teacher's claims in an episode, on average."""

    distorted: float
    truthful: float


def turn_rates(data: Data, teacher: str, like: Compared) -> ClaimRates:
    """The account of a teacher's claims to the student of a comparison, over all families."""
    mine = list(_sums(data, teacher, like))
    truthful, distorted = (share(mine, label, "turns") or 0.0 for label in (Label.TRUTHFUL, Label.DISTORTED))
    return ClaimRates(truthful, distorted)


def episode_counts(data: Data, teacher: str, like: Compared, family: str) -> ClaimCounts:
    """The same in the episodes of one family."""
    mine = list(_sums(data, teacher, like, family))
    episodes = sum(each.episodes for each in mine)
    distorted, truthful = (added(mine, label) / episodes for label in (Label.DISTORTED, Label.TRUTHFUL))
    return ClaimCounts(distorted, truthful)


def _sums(data: Data, teacher: str, like: Compared, family: str = "") -> Iterator[Sums]:
    for setting, each in data.sums.items():
        here = setting.teacher, setting.student, setting.instruction_type, setting.feedback_type, setting.lessons
        if here == (teacher, *like[1:4], 0) and family in ("", entry(setting.id).family.name):
            yield each
