"""What each family says: success and regret of every teacher with every student, and transcripts."""

from collections.abc import Mapping
from typing import Any

from llf_teacher.students.student import TAUGHT
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.figure import Plot
from llf_teacher.studies.report.parts.part import Part
from llf_teacher.studies.report.transcript import transcript


def _values(data: Data) -> Mapping[str, Any]:
    return {
        "taught": TAUGHT,
        "transcripts": lambda section: [transcript(data.store, spec) for spec in section.transcripts],
    }


def _links(data: Data) -> list[tuple[str, str, str]]:
    return [(s.anchor, s.family.name, f"{s.instruction_type}, {s.feedback_type}") for s in data.sections]


def _plots(data: Data) -> list[Plot]:
    return [plot for section in data.sections for plot in section.plots]


PART = Part("families", _values, plots=_plots, links=_links)
