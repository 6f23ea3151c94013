"""The effect of lessons in a test without a teacher."""

from collections.abc import Mapping, Sequence
from typing import Any

from llf_teacher.studies.analysis.outcomes import Group
from llf_teacher.studies.analysis.transfer import AfterLessons, tested
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.figure import Plot
from llf_teacher.studies.report.parts.part import Part
from llf_teacher.studies.report.plots import Pane, panel_plot
from teachers.words import INSTRUCTIONS, feedback_words


def _row(group: Group) -> str:
    """The label of lessons in the figure."""
    return f"{group.lessons} {group.worlds}, {feedback_words(group.feedback_type)}"


def _plot(data: Data, found: Sequence[AfterLessons]) -> Plot | None:
    """A panel per environment of tests, a row per kind of lessons; None without a comparison."""
    panes: dict[str, Pane] = {}
    rows: dict[str, None] = {}
    series: dict[str, None] = {}
    for each in found:
        if each.gain is None:
            continue
        group = each.group
        where = ", ".join(group.ids) + ("" if group.ids == (group.taught,) else f" after {group.taught}")
        title = f"{where} ({INSTRUCTIONS[group.instruction_type]})"
        row, name = _row(group), f"{data.called(each.teacher)}, {data.called(each.student)}"
        rows[row] = series[name] = None
        pane = panes.setdefault(title, Pane(title, data.units[group.family], {}))
        panes[title] = pane._replace(dots={**pane.dots, (row, name): each.gain})
    if not panes:
        return None
    baseline = data.called(data.study.baseline)
    return Plot(
        name="transfer-gains",
        title=f"Regret in a test without a teacher, less than after as many episodes with {baseline}.",
        draw=lambda width: panel_plot(list(panes.values()), list(rows), list(series), "gain", width),
        columns=(
            *("tested_in", "taught_in", "instruction_type", "lessons", "worlds", "feedback_type"),
            *("teacher", "student", "seeds", "success", "regret", "gain", "gain_low", "gain_high"),
        ),
        rows=[
            (
                *(" ".join(each.group.ids), each.group.taught, each.group.instruction_type, each.group.lessons),
                *(each.group.worlds, each.group.feedback_type),
                *(data.called(each.teacher), data.called(each.student), each.regret.n),
                *(each.success.mean, each.regret.mean, *(each.gain[:3] if each.gain else ("", "", ""))),
            )
            for each in found
        ],
    )


def _plots(data: Data) -> list[Plot]:
    plot = _plot(data, list(tested(data.outcomes, data.study.baseline)))
    return [plot] if plot else []


def _values(data: Data) -> Mapping[str, Any] | None:
    found = list(tested(data.outcomes, data.study.baseline))
    if not found:
        return None
    return {
        "found": found,
        "plot": _plot(data, found),
    }


PART = Part("transfer", _values, "Tests without a teacher", plots=_plots)
