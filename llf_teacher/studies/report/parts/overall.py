"""The regret that each teacher saves over all families, with estimators for many tasks."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from llf_teacher.studies.analysis.overall import THRESHOLDS, Overall, overall
from llf_teacher.studies.report.data import Data, asked
from llf_teacher.studies.report.figure import Plot
from llf_teacher.studies.report.parts.part import Part
from llf_teacher.studies.report.plots import MOST, profile_plot
from teachers.words import type_words

_SHOWN = (0.0, 0.5, 0.9)


def _typed(found: Sequence[Overall]) -> bool:
    return len({(each.instruction_type, each.feedback_type) for each in found}) > 1


def _plot(data: Data, found: Sequence[Overall]) -> Plot:
    """A line per teacher; of many, those that the study asks about, a user's own, the best and the last have names.

    Names and colours are in the order of the study.
    """
    first, order = asked(data.study), data.study.teachers
    ranked = sorted(found, key=lambda each: (each.teacher not in first, -each.middle.mean))
    shown = ranked if len(ranked) <= MOST else [*ranked[: MOST - 1], ranked[-1]]
    drawn = [
        *sorted(shown, key=lambda each: order.index(each.teacher)),
        *(each for each in ranked if each not in shown),
    ]
    typed = _typed(found)

    def label(each: Overall) -> str:
        name = data.called(each.teacher)
        return f"{name} ({type_words(each.instruction_type, each.feedback_type)})" if typed else name

    return Plot(
        name="overall-profiles",
        title="Performance profiles: the share of seeds above a score, by teacher, over all families.",
        draw=lambda width: profile_plot(
            {label(each): (each.profile.thresholds.tolist(), each.profile.band) for each in drawn}, width=width
        ),
        columns=("teacher", "instruction_type", "feedback_type", "score", "above", "above_low", "above_high"),
        rows=[
            (data.called(each.teacher), each.instruction_type, each.feedback_type, float(score), *map(float, at))
            for each in found
            for score, at in zip(each.profile.thresholds, zip(*each.profile.band, strict=True), strict=True)
        ],
    )


def _plots(data: Data) -> list[Plot]:
    return [_plot(data, found)] if (found := list(overall(data.taught, data.study.baseline))) else []


def _values(data: Data) -> Mapping[str, Any] | None:
    found = list(overall(data.taught, data.study.baseline))
    if not found:
        return None
    return {
        "found": found,
        "most": MOST,
        "plot": _plot(data, found),
        "thresholds": {value: int(np.abs(THRESHOLDS - value).argmin()) for value in _SHOWN},
        "typed": _typed(found),
    }


PART = Part("overall", _values, "Over all families", plots=_plots)
