"""How soon problems are solved, and the gain by a teacher's words over mere repetition."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from llf_teacher.students.student import TAUGHT
from llf_teacher.studies.analysis.outcomes import Group
from llf_teacher.studies.analysis.time_to_success import CONTROL, Attempts, attempts
from llf_teacher.studies.definition.stored_specs import student_of
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.parts.part import Part


class Tries(NamedTuple):
    """The attempts of one group."""

    group: Group
    tries: tuple[int, ...]
    found: Mapping[tuple[str, str], Attempts]


def _tries(data: Data) -> Iterator[Tries]:
    for group, cells in data.taught.items():
        reached = {pair: cell for pair, cell in cells.items() if student_of(pair[1]).reads in TAUGHT}
        if found := attempts(reached, group.max_turns):
            yield Tries(group, next(iter(found.values())).tries, found)


def _values(data: Data) -> Mapping[str, Any] | None:
    found = list(_tries(data))
    return {"found": found, "control": CONTROL} if found else None


PART = Part("time_to_success", _values, "Attempts")
