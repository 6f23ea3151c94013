"""What each teacher spares its students over all families, by estimators for many tasks."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from llf_teacher.studies.overall import THRESHOLDS, overall
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.parts.part import Part

_SHOWN = (0.0, 0.5, 0.9)


def _values(data: Data) -> Mapping[str, Any] | None:
    found = list(overall(data.taught, data.study.baseline))
    if not found:
        return None
    return {
        "found": found,
        "thresholds": {value: int(np.abs(THRESHOLDS - value).argmin()) for value in _SHOWN},
        "typed": len({(each.instruction_type, each.feedback_type) for each in found}) > 1,
    }


PART = Part("overall", _values, "Over all families")
