"""What lessons have left in a test without a teacher."""

from collections.abc import Mapping
from typing import Any

from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.parts.part import Part
from llf_teacher.studies.transfer import tested
from pz_envs.family import all_families


def _values(data: Data) -> Mapping[str, Any] | None:
    found = list(tested(data.outcomes, data.study.baseline))
    if not found:
        return None
    return {"found": found, "units": {family.name: family.regret_unit for family in all_families()}}


PART = Part("transfer", _values, "Tests without a teacher")
