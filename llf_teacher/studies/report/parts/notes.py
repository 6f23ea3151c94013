"""How to read the figures, and the contents of the page."""

from collections.abc import Mapping
from typing import Any

from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.parts.part import Part


def _values(data: Data) -> Mapping[str, Any]:
    return {}


PART = Part("notes", _values)
