"""The suite as a study, and the scores of a student from the episodes that were played."""

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llf_teacher.studies import run
from llf_teacher.studies.definition.custom_specs import student_spec
from llf_teacher.studies.definition.study import Study
from llf_teacher.suite.card import Card
from llf_teacher.suite.experiment import TURNS, Experiment, all_experiments
from llf_teacher.suite.score import LEVELS, Arms, Score, score
from teachers.spec import unknown

VERSION = "suite-v1"
"""Worlds, seeds, teachers, references and thresholds of this name never change; `digest` is that of all of them."""
SEEDS, QUICK_SEEDS = 20, 8
QUICK = ("advice", "blame", "silence", "turncoat")
"""The experiments of `quick`."""
FIRST_SEED = 500_000
"""First seed of the suite without a key."""


def digest() -> str:
    """A digest of all that decides a score."""
    decides = {name: each.as_dict() for name, each in all_experiments().items()}
    values = [VERSION, decides, SEEDS, QUICK_SEEDS, QUICK, FIRST_SEED, TURNS, LEVELS]
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:16]


def seeds_of(key: str = "", quick: bool = False) -> tuple[int, ...]:
    """The seeds of the worlds; those of a key are others of the same kind."""
    first = FIRST_SEED
    if key:
        first = 1_000_000 + int.from_bytes(hashlib.sha256(key.encode()).digest()[:4]) * 100
    return tuple(range(first, first + (QUICK_SEEDS if quick else SEEDS)))


def chosen(names: Sequence[str] = (), quick: bool = False) -> dict[str, Experiment]:
    """The experiments of these names; without names all, or those of `quick`.

    Raises:
        ValueError: an unknown name.
    """
    there = all_experiments()
    for name in names:
        if name not in there:
            raise ValueError(unknown("experiment", name, there))
    return {name: there[name] for name in there if name in (names or (QUICK if quick else there))}


def study_of(
    students: Sequence[Any], experiments: Mapping[str, Experiment] | None = None, seeds: Sequence[int] = seeds_of()
) -> Study:
    """The study whose episodes the scores of these students need; those of the references come first."""
    asked = list((experiments or all_experiments()).values())
    ids = tuple(dict.fromkeys(id for each in asked for id in each.ids))
    references = tuple(dict.fromkeys(each.reference for each in asked))
    return Study(
        ids=ids,
        teachers=tuple(dict.fromkeys(teacher for each in asked for teacher in each.teachers)),
        students=tuple(dict.fromkeys((*references, *map(student_spec, students)))),
        seeds=seeds,
        max_turns=TURNS,
        options={id: dict(options) for each in asked for id, options in each.options.items() if id in ids},
    )


def take(
    student: Any,
    store: Path | str,
    names: Sequence[str] = (),
    quick: bool = False,
    key: str = "",
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Card:
    """Play what the store lacks of the suite, and give the card of a student.

    Args:
        student: a spec, a `Student`, or the factory of an agent.
        store: the file of the episodes; an interrupted suite is resumed from it.
        names: of experiments; without them all, or those of `quick`.
        quick: fewer experiments and seeds, for agents whose answers cost money or time.
        key: a text of your choice, for worlds that nobody could tune an agent to.
        workers: as in `llf_teacher.studies.run`.
        progress: called with the number of episodes that are done, and the total.

    Raises:
        ValueError: the student or an experiment is unknown, or cannot play.
        StudyError: the episodes cannot go on, such as after a spending limit; those so far are stored.
    """
    spec, experiments, seeds = student_spec(student), chosen(names, quick), seeds_of(key, quick)
    study = study_of([spec], experiments, seeds)
    with run(study, store, workers, progress) as results:
        rows, lost = list(results.rows()), [each for each in results.failures() if each["student"] == spec]
    scores = {name: scored(each, spec, rows, seeds) for name, each in experiments.items()}
    return Card.of(
        spec,
        scores,
        suite=VERSION,
        digest=digest(),
        rows=[
            row for row in rows if row["student"] == spec and row["seed"] in seeds and row["teacher"] in study.teachers
        ],
        failures=len(lost),
        error=f"{lost[0]['error']}" if lost else "",
        key=key,
        quick=quick,
    )


def scored(experiment: Experiment, student: str, rows: Iterable[Mapping[str, Any]], seeds: Sequence[int]) -> Score:
    """The score of a student in an experiment, from the rows of a store."""
    found: dict[tuple[str, str, str], dict[int, Mapping[str, Any]]] = {}
    for row in rows:
        found.setdefault((row["id"], row["teacher"], row["student"]), {})[row["seed"]] = row

    def regrets(id: str, teacher: str, who: str) -> NDArray[np.float64]:
        """Per seed what is lost in the turns that count; NaN where the episode is missing."""
        lessons = found.get((id, teacher, who), {})
        return np.array([_lost(lessons[seed], experiment.since) if seed in lessons else np.nan for seed in seeds])

    def unread(id: str) -> float:
        """The share of turns whose answer was no action."""
        there = [found[id, teacher, student] for teacher in experiment.teachers if (id, teacher, student) in found]
        turns = sum(row["turns"] for lessons in there for row in lessons.values())
        return sum(row["parse_failures"] for lessons in there for row in lessons.values()) / turns if turns else 0.0

    better, worse = experiment.unit or (experiment.better, experiment.worse)
    arms = {
        id: Arms(
            better=regrets(id, experiment.better, student),
            worse=regrets(id, experiment.worse, student),
            unit_better=regrets(id, better, experiment.reference),
            unit_worse=regrets(id, worse, experiment.reference),
            unread=unread(id),
        )
        for id in experiment.ids
    }
    return score(arms, experiment.offset, experiment.margin)


def _lost(row: Mapping[str, Any], since: int) -> float:
    return float(sum(row["regrets"][since:]))
