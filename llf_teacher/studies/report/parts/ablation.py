"""What each kind of feedback adds."""

from collections.abc import Mapping
from typing import Any

from llf_teacher.studies.ablation import ablations
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.parts.part import Part
from pz_envs.family import all_families
from teachers.atoms import KINDS


def _values(data: Data) -> Mapping[str, Any] | None:
    found = list(ablations({group: cells for group, cells in data.outcomes.items() if not group.lessons}))
    if not found:
        return None
    kinds = [kind for kind in KINDS if any(kind in each.shares for each in found)]
    return {
        "found": found,
        "kinds": kinds,
        "units": {family.name: family.regret_unit for family in all_families()},
    }


PART = Part("ablation", _values, "What each kind adds")
