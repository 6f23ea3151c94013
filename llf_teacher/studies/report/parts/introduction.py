"""The first answer of the study, its subject, and the share of it that was played."""

from collections.abc import Mapping
from typing import Any

from llf_teacher.studies.report.answers import answers
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.parts.part import Part


def _values(data: Data) -> Mapping[str, Any]:
    students = dict.fromkeys(student for student, _ in data.failures)
    failures = {each: {why: n for (student, why), n in data.failures.items() if student == each} for each in students}
    first = next((each.text for each in answers(data)), "")
    return {
        "first": first,
        "failures": failures,
        "families": list(dict.fromkeys(section.family.name for section in data.sections)),
    }


PART = Part("introduction", _values)
