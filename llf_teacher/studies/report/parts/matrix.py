"""Students and teachers crossed: their shares of the gain over the control `retry_only`."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from llf_teacher.studies.analysis.matrix import Matrix, matrices
from llf_teacher.studies.analysis.time_to_success import CONTROL
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.figure import Plot
from llf_teacher.studies.report.parts.part import Part
from llf_teacher.studies.report.plots import Pane, panel_plot


class Verdicts(NamedTuple):
    """Numbers of tables by the greater share of the variance of gains, also with intervals that exclude 0."""

    all: int
    students: int
    significant_students: int
    teachers: int
    significant_teachers: int


def verdicts(found: Sequence[Matrix]) -> Verdicts:
    """Count the tables with unequal gains."""
    leads = [(each.split.students - each.split.teachers, each.lead) for each in found if each.split]
    return Verdicts(
        len(leads),
        sum(lead > 0 for lead, _ in leads),
        sum(ends is not None and ends[0] > 0 for _, ends in leads),
        sum(lead < 0 for lead, _ in leads),
        sum(ends is not None and ends[1] < 0 for _, ends in leads),
    )


def _types(found: Sequence[Matrix]) -> list[tuple[str, str]]:
    return list(dict.fromkeys((each.group.instruction_type, each.group.feedback_type) for each in found))


def _plot(data: Data, found: Sequence[Matrix], types: tuple[str, str]) -> Plot:
    """A panel a family, a row a teacher; of one instruction type and feedback type."""
    called = data.called
    found = [each for each in found if (each.group.instruction_type, each.group.feedback_type) == types]
    return Plot(
        name=f"matrix-gains-{'-'.join(types)}".replace("+", "-"),
        title=f"Gain over {CONTROL} by teacher and student, one panel a family.",
        draw=lambda width: panel_plot(
            [
                Pane(
                    each.group.family,
                    data.units[each.group.family],
                    {(called(teacher), called(student)): gain for (teacher, student), gain in each.gains.items()},
                )
                for each in found
            ],
            list(dict.fromkeys(called(teacher) for each in found for teacher in each.teachers)),
            list(dict.fromkeys(called(student) for each in found for student in each.students)),
            f"gain over {CONTROL}",
            width,
        ),
        columns=("family", "instruction_type", "feedback_type", "teacher", "student", "seeds", *_GAIN),
        rows=[
            (each.group.family, *types, *map(called, pair), gain.n, *gain[:3])
            for each in found
            for pair, gain in each.gains.items()
        ],
    )


_GAIN = ("gain", "gain_low", "gain_high")


def _plots(data: Data) -> list[Plot]:
    found = list(matrices(data.taught))
    return [_plot(data, found, types) for types in _types(found)]


def _values(data: Data) -> Mapping[str, Any] | None:
    found = list(matrices(data.taught))
    if not found:
        return None
    return {
        "plots": [_plot(data, found, types) for types in _types(found)],
        "verdicts": verdicts(found),
        "found": found,
        "control": CONTROL,
    }


PART = Part("matrix", _values, "Whose the gain is", plots=_plots)
