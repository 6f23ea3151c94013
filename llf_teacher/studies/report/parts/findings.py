"""The findings of a study: a figure over all families, and sentences that are computed from it."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.figure import Plot
from llf_teacher.studies.report.gains import Gain, gains
from llf_teacher.studies.report.parts.part import Part
from llf_teacher.studies.report.plots import gain_plot


class Ranked(NamedTuple):
    """A teacher and a student with their gain."""

    teacher: str
    student: str
    gain: Gain


class Tally(NamedTuple):
    """Number of comparisons in the families' tables, and of those that are significant after Holm."""

    all: int
    better: int
    worse: int


def _values(data: Data) -> Mapping[str, Any] | None:
    found = gains(data.sections)
    if not found:
        return None
    most = max(len(gain.sections) for gain in found.values())
    ranked = [Ranked(*pair, gain) for pair, gain in found.items() if len(gain.sections) == most]
    ranked.sort(key=lambda each: each.gain.estimate.mean)
    return {
        "plot": _plot(data, found),
        "baseline": data.sections[0].reference,
        "best": ranked[-1],
        "worst": ranked[0],
        "widest": most,
        "tested": _tested(data, data.test.level) if data.test else None,
        "partial": [teacher for teacher, widest in _widest(found).items() if widest < most],
    }


def _widest(found: Mapping[tuple[str, str], Gain]) -> dict[str, int]:
    """Number of families in which each teacher was compared, for the student with most."""
    widest: dict[str, int] = {}
    for (teacher, _), gain in found.items():
        widest[teacher] = max(widest.get(teacher, 0), len(gain.sections))
    return widest


def _tested(data: Data, level: float) -> Tally:
    significant = [d.estimate.mean for section in data.sections for d in section.differences.values() if d.p <= level]
    every = sum(len(section.differences) for section in data.sections)
    return Tally(every, sum(mean < 0 for mean in significant), sum(mean > 0 for mean in significant))


def _plot(data: Data, found: Mapping[tuple[str, str], Gain]) -> Plot:
    teachers = [teacher for teacher in data.study.teachers if any(teacher == pair[0] for pair in found)]
    teachers.sort(key=lambda t: -max(gain.estimate.mean for pair, gain in found.items() if pair[0] == t))
    students = [student for student in data.study.students if any(student == pair[1] for pair in found)]
    baseline, called = data.sections[0].reference, data.sections[0].called
    return Plot(
        name="findings-gains",
        title=f"Share of the regret with {called(baseline)} that each teacher spares each student, over all families.",
        draw=lambda: gain_plot(
            [called(teacher) for teacher in teachers],
            [called(student) for student in students],
            {(called(teacher), called(student)): gain.estimate for (teacher, student), gain in found.items()},
            {(called(teacher), called(student)): gain.shares for (teacher, student), gain in found.items()},
            called(baseline),
        ),
        columns=("teacher", "student", "where", "families", "gain", "gain_low", "gain_high"),
        rows=[
            row
            for (teacher, student), gain in found.items()
            for row in (
                (teacher, student, "all", gain.estimate.n, *gain.estimate[:3]),
                *(
                    (teacher, student, section.anchor, 1, share, "", "")
                    for section, share in zip(gain.sections, gain.shares, strict=True)
                ),
            )
        ],
    )


def _plots(data: Data) -> list[Plot]:
    return [_plot(data, found)] if (found := gains(data.sections)) else []


PART = Part("findings", _values, "Findings", plots=_plots)
