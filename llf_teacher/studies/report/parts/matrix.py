"""Whose the gain is: students and teachers crossed, beyond being told to try again."""

from collections.abc import Mapping
from typing import Any

from llf_teacher.studies.attempts import CONTROL
from llf_teacher.studies.matrix import matrices
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.parts.part import Part
from pz_envs.family import all_families


def _values(data: Data) -> Mapping[str, Any] | None:
    found = list(matrices(data.taught))
    if not found:
        return None
    return {
        "found": found,
        "control": CONTROL,
        "units": {family.name: family.regret_unit for family in all_families()},
    }


PART = Part("matrix", _values, "Whose the gain is")
