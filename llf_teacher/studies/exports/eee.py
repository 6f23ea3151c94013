"""eee: results in the schema of Every Eval Ever, a file a student, in a folder."""

import hashlib
import json
import math
import re
import time
from pathlib import Path
from typing import Any

from llf_teacher import __version__
from llf_teacher.registry import entry
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies.results import Results

SCHEMA = "0.2.1"
"""The version of the schema."""
_METRICS = ("success", "regret", "failures")
_CELL = ("id", "teacher", "instruction_type", "feedback_type", "max_turns")


class _Mean:
    """A mean with its spread, of numbers that come one by one (Welford)."""

    def __init__(self) -> None:
        self.count, self.mean, self._squares = 0, 0.0, 0.0

    def add(self, number: float) -> None:
        """Take in a number."""
        self.count += 1
        off = number - self.mean
        self.mean += off / self.count
        self._squares += off * (number - self.mean)

    def details(self) -> dict[str, Any]:
        """Score and uncertainty."""
        uncertainty: dict[str, Any] = {"num_samples": self.count}
        if self.count > 1:
            spread = math.sqrt(self._squares / (self.count - 1))
            error = {"value": spread / math.sqrt(self.count), "method": "analytic"}
            uncertainty |= {"standard_deviation": spread, "standard_error": error}
        return {"score": self.mean, "uncertainty": uncertainty}


def write(results: Results, path: Path, *, organization: str = "unknown", relationship: str = "other") -> int:
    """Write the files; the number of them.

    Args:
        results: the store.
        path: the folder.
        organization: who ran the study.
        relationship: to who made the models: `first_party`, `third_party`, `collaborative` or `other`.
    """
    allowed = ("first_party", "third_party", "collaborative", "other")
    if relationship not in allowed:
        raise ValueError(f"relationship must be one of {', '.join(allowed)}, got {relationship!r}")
    students: dict[str, dict[tuple[Any, ...], dict[str, _Mean]]] = {}
    for row in results.rows():
        if row["lessons"]:
            continue
        cells = students.setdefault(row["student"], {})
        means = cells.setdefault(tuple(row[name] for name in _CELL), {name: _Mean() for name in _METRICS})
        means["success"].add(float(row["success"]))
        means["regret"].add(row["regret"] / max(1, row["turns"]))
        means["failures"].add(row["parse_failures"] / max(1, row["turns"]))
    path.mkdir(parents=True, exist_ok=True)
    stamp = f"{time.time():.0f}"
    for student, cells in students.items():
        model = _model(student)
        source = {
            "source_name": "llf-teacher",
            "source_type": "evaluation_run",
            "source_organization_name": organization,
            "evaluator_relationship": relationship,
        }
        told = {
            "schema_version": SCHEMA,
            "evaluation_id": f"llf-teacher/{model['id']}/{stamp}",
            "retrieved_timestamp": stamp,
            "source_metadata": source,
            "eval_library": {"name": "llf-teacher", "version": __version__},
            "model_info": model,
            "evaluation_results": [each for cell, means in cells.items() for each in _results(cell, means)],
        }
        name = f"{re.sub(r'[^A-Za-z0-9]+', '-', model['name']).strip('-')[:60]}-{_digest(student)}.json"
        (path / name).write_text(json.dumps(told, indent=1, ensure_ascii=False), encoding="utf-8")
    return len(students)


def _model(student: str) -> dict[str, Any]:
    model = getattr(parse_student(student), "model", "")
    name = model or student
    id = name if "/" in name else f"{'unknown' if model else 'llf-teacher'}/{name}"
    return {"name": name, "id": id, "developer": id.partition("/")[0], "additional_details": {"student": student}}


def _results(cell: tuple[Any, ...], means: dict[str, _Mean]) -> list[dict[str, Any]]:
    told = {name: f"{value}" for name, value in zip(_CELL, cell, strict=True)}
    share = {"score_type": "continuous", "min_score": 0.0, "max_score": 1.0}
    unit = entry(cell[0]).family.regret_unit
    configured: tuple[dict[str, Any], ...] = (
        {"evaluation_description": "share of episodes that end in success", "lower_is_better": False, **share},
        {"evaluation_description": f"mean regret a turn: {unit}", "lower_is_better": True},
        {"evaluation_description": "share of turns without an action", "lower_is_better": True, **share},
    )
    return [
        {
            "evaluation_name": f"{cell[0]} {name}",
            "source_data": {"dataset_name": cell[0], "source_type": "other", "additional_details": told},
            "metric_config": {**metric, "additional_details": told},
            "score_details": means[name].details(),
        }
        for name, metric in zip(_METRICS, configured, strict=True)
    ]


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:8]
