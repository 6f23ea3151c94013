"""What is needed to repeat the study."""

import hashlib
from collections.abc import Mapping
from typing import Any

from llf_teacher.studies.definition.study import to_toml
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.parts.part import Part


def _values(data: Data) -> Mapping[str, Any]:
    return {"toml": to_toml(data.study), "digest": _digest}


def _digest(spec: str) -> str:
    return hashlib.sha256(spec.encode()).hexdigest()[:8]


PART = Part("manifest", _values, "Manifest")
