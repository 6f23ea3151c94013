"""eee: results in the schema of Every Eval Ever, one file per student, in a folder."""

import hashlib
import json
import math
import re
import time
from pathlib import Path
from typing import Any

from llf_teacher import __version__
from llf_teacher.registry import entry
from llf_teacher.studies.definition.recalled import student_of
from llf_teacher.studies.results import Results

SCHEMA = "0.3.0"
"""The version of the schema."""
_METRICS = ("success", "regret", "failures")
_RELATIONSHIPS = ("first_party", "third_party", "collaborative", "other")
_DEPLOYMENTS = ("self_deployed", "externally_managed", "unknown")
_AVAILABILITIES = ("open_weights", "closed_weights", "unknown")
_CELL = ("id", "teacher", "instruction_type", "feedback_type", "max_turns")


class _Mean:
    """Mean and standard deviation of numbers that come one by one (Welford)."""

    def __init__(self) -> None:
        self.count, self.mean, self._squares = 0, 0.0, 0.0

    def add(self, number: float) -> None:
        """Add a number."""
        self.count += 1
        off = number - self.mean
        self.mean += off / self.count
        self._squares += off * (number - self.mean)

    def details(self) -> dict[str, Any]:
        """Score and uncertainty, as the schema has them."""
        uncertainty: dict[str, Any] = {"num_samples": self.count}
        if self.count > 1:
            spread = math.sqrt(self._squares / (self.count - 1))
            error = {"value": spread / math.sqrt(self.count), "method": "analytic"}
            uncertainty |= {"standard_deviation": spread, "standard_error": error}
        return {"score": self.mean, "uncertainty": uncertainty}


def write(
    results: Results,
    path: Path,
    *,
    organization: str = "unknown",
    relationship: str = "other",
    deployment: str = "unknown",
    availability: str = "unknown",
) -> int:
    """Write the files; gives their number.

    Args:
        results: the store.
        path: the folder.
        organization: that ran the study.
        relationship: of this organization to the makers of the models: `first_party`, `third_party`, `collaborative` or
            `other`.
        deployment: of the models: `self_deployed`, `externally_managed` or `unknown`.
        availability: of the models' weights: `open_weights`, `closed_weights` or `unknown`.

    Raises:
        ValueError: one of the last three has another value.
    """
    _check("relationship", relationship, _RELATIONSHIPS)
    _check("deployment", deployment, _DEPLOYMENTS)
    _check("availability", availability, _AVAILABILITIES)
    students: dict[str, dict[tuple[Any, ...], dict[str, _Mean]]] = {}
    for row in results.rows():
        if row["lessons"]:
            continue
        cells = students.setdefault(row["student"], {})
        means = cells.setdefault(tuple(row[name] for name in _CELL), {name: _Mean() for name in _METRICS})
        means["success"].add(float(row["success"]))
        means["regret"].add(max(0.0, row["regret"]) / max(1, row["turns"]))  # rounding may give less than 0
        means["failures"].add(row["parse_failures"] / max(1, row["turns"]))
    path.mkdir(parents=True, exist_ok=True)
    stamp = f"{time.time():.0f}"
    for student, cells in students.items():
        model = _model(student)
        model["additional_details"] |= {"deployment_type": deployment, "model_availability": availability}
        source = {
            "source_name": "llf-teacher",
            "source_type": "evaluation_run",
            "source_organization_name": organization,
            "evaluator_relationship": relationship,
        }
        report = {
            "schema_version": SCHEMA,
            "evaluation_id": f"llf-teacher-{_digest(student)}/{model['id']}/{stamp}",
            "retrieved_timestamp": stamp,
            "source_metadata": source,
            "eval_library": {"name": "llf-teacher", "version": __version__},
            "model_info": model,
            "evaluation_results": [each for cell, means in cells.items() for each in _results(cell, means)],
        }
        name = f"{re.sub(r'[^A-Za-z0-9]+', '-', model['name']).strip('-')[:60]}-{_digest(student)}.json"
        (path / name).write_text(json.dumps(report, indent=1, ensure_ascii=False), encoding="utf-8")
    return len(students)


def _model(student: str) -> dict[str, Any]:
    model = getattr(student_of(student), "model", "")
    name = model or student
    id = name if "/" in name else f"{'unknown' if model else 'llf-teacher'}/{name}"
    return {"name": name, "id": id, "developer": id.partition("/")[0], "additional_details": {"student": student}}


def _results(cell: tuple[Any, ...], means: dict[str, _Mean]) -> list[dict[str, Any]]:
    setting = {name: f"{value}" for name, value in zip(_CELL, cell, strict=True)}
    unit = entry(cell[0]).family.regret_unit
    share: dict[str, Any] = {"metric_unit": "proportion", "max_score": 1.0}
    loss = {"metric_unit": f"{unit} a turn", "max_score": "Infinity"}
    metrics: tuple[tuple[str, bool, dict[str, Any]], ...] = (
        ("share of episodes that end in success", False, share),
        (f"mean regret a turn: {unit}", True, loss),
        ("share of turns without an action", True, share),
    )
    return [
        {
            "evaluation_result_id": _digest(json.dumps([name, *cell])),
            "evaluation_name": f"{cell[0]} {name}",
            "source_data": {"dataset_name": cell[0], "source_type": "other", "additional_details": setting},
            "metric_config": {
                "evaluation_description": description,
                "metric_id": f"llf-teacher.{name}",
                "metric_name": name,
                "lower_is_better": lower,
                "score_type": "continuous",
                "min_score": 0.0,
                **scale,
                "additional_details": setting,
            },
            "score_details": means[name].details(),
        }
        for name, (description, lower, scale) in zip(_METRICS, metrics, strict=True)
    ]


def _check(name: str, value: str, allowed: tuple[str, ...]) -> None:
    if value not in allowed:
        raise ValueError(f"{name} must be one of {', '.join(allowed)}, got {value!r}")


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:8]
