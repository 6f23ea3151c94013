"""What was studied, and how much of it has been played."""

from collections.abc import Mapping
from typing import Any

from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.parts.part import Part


def _values(data: Data) -> Mapping[str, Any]:
    students = dict.fromkeys(student for student, _ in data.failures)
    failures = {one: {why: n for (other, why), n in data.failures.items() if other == one} for one in students}
    return {"failures": failures, "families": list(dict.fromkeys(section.family.name for section in data.sections))}


PART = Part("introduction", _values)
