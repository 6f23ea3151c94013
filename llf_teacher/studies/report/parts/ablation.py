"""What each kind of feedback adds."""

from collections.abc import Mapping, Sequence
from typing import Any

from llf_teacher.studies.analysis.ablation import Ablation, ablations
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.figure import Plot
from llf_teacher.studies.report.parts.part import Part
from llf_teacher.studies.report.plots import Pane, panel_plot
from teachers.atoms import KINDS, FeedbackType
from teachers.words import INSTRUCTIONS, KIND_WORDS

_ALL = "all kinds"


def _found(data: Data) -> list[Ablation]:
    return list(ablations({group: cells for group, cells in data.outcomes.items() if not group.lessons}))


def _plot(data: Data, found: Sequence[Ablation]) -> Plot:
    """A panel a family and instruction type, a row a kind."""
    kinds = [kind for kind in KINDS if any(kind in each.shares for each in found)]
    typed = len({each.group.instruction_type for each in found}) > 1
    taught = len({each.teacher for each in found}) > 1
    panes: dict[tuple[str, ...], Pane] = {}
    series: dict[str, None] = {}
    for each in found:
        name = f"{data.called(each.teacher)}, {data.called(each.student)}" if taught else data.called(each.student)
        series[name] = None
        group = each.group
        title = f"{group.family} ({INSTRUCTIONS[group.instruction_type]})" if typed else group.family
        pane = panes.setdefault((title, *group.ids), Pane(title, data.units[group.family], {}))
        rows = {KIND_WORDS[kind]: each.shares[kind] for kind in kinds if kind in each.shares} | {_ALL: each.total}
        panes[title, *group.ids] = pane._replace(
            dots={**pane.dots, **{(row, name): estimate for row, estimate in rows.items()}}
        )
    return Plot(
        name="ablation-shares",
        title="What each kind of feedback adds to the gain, and the gain of all kinds, one panel a family.",
        draw=lambda width: panel_plot(
            list(panes.values()), [*(KIND_WORDS[kind] for kind in kinds), _ALL], list(series), "gain", width
        ),
        columns=("family", "instruction_type", "teacher", "student", "kind", "seeds", "gain", "gain_low", "gain_high"),
        rows=[
            (
                *(each.group.family, each.group.instruction_type, data.called(each.teacher), data.called(each.student)),
                *(KIND_WORDS[FeedbackType(kind)] if kind in KINDS else kind, gain.n, *gain[:3]),
            )
            for each in found
            for kind, gain in {**each.shares, _ALL: each.total}.items()
        ],
    )


def _plots(data: Data) -> list[Plot]:
    return [_plot(data, found)] if (found := _found(data)) else []


def _values(data: Data) -> Mapping[str, Any] | None:
    found = _found(data)
    if not found:
        return None
    kinds = [kind for kind in KINDS if any(kind in each.shares for each in found)]
    return {
        "plot": _plot(data, found),
        "found": found,
        "kinds": kinds,
    }


PART = Part("ablation", _values, "What each kind adds", plots=_plots)
