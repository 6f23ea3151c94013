"""Answers of language models: answers that were not actions, cut answers, tokens, costs, latency."""

from collections.abc import Mapping
from typing import Any

from llf_teacher.studies.analysis.costs import MANY
from llf_teacher.studies.report.columns import columns
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.parts.part import Part


def _values(data: Data) -> Mapping[str, Any] | None:
    with columns(data.store, data.planned) as there:
        found = there.answers()
    forms = {spent["model"]: spent["form"] for spent in data.manifest.get("llm", ()) if "form" in spent}
    return {"found": found, "many": MANY, "forms": forms} if found else None


PART = Part("models", _values, "Language models")
