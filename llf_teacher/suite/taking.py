"""The suite as a study, and the scores of a student from the played episodes."""

import hashlib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llf_teacher.registry import entry
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies import load, run
from llf_teacher.studies.definition.custom_specs import student_spec
from llf_teacher.studies.definition.design import TESTER
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.limits import Limits
from llf_teacher.studies.execution.runner import RunOptions
from llf_teacher.suite.card import Card, checksum
from llf_teacher.suite.environments import ARMS, OPTIONS
from llf_teacher.suite.experiment import TURNS, Experiment, all_experiments
from llf_teacher.suite.score import LEVELS, Arms, Score, score
from teachers.common import FACTS
from teachers.spec import unknown

VERSION = "suite-v1"
"""The version: its worlds, seeds, teachers, references and thresholds never change; `digest` covers all of them."""
QUICK_SEEDS, QUICK_TURNS = 8, 5
QUICK = ("advice", "hints", "silence", "turncoat")
"""The experiments of `quick`: those with the best ratio of contrast to noise; each is played with bandits."""
FIRST_SEED = 500_000
"""First seed of the suite without a key."""


def digest() -> str:
    """A digest of everything that decides a score."""
    decides = {name: [vars(each), each.arms] for name, each in all_experiments().items()}
    seeds = seeds_of(), seeds_of("a key", quick=True)
    return checksum([VERSION, decides, seeds, QUICK_TURNS, QUICK, TURNS, LEVELS, FACTS, OPTIONS])


def seeds_of(key: str = "", quick: bool = False) -> tuple[int, ...]:
    """The seeds of the worlds; a key gives other seeds of the same kind."""
    first = 1_000_000 + int.from_bytes(hashlib.sha256(key.encode()).digest()[:4]) * 100 if key else FIRST_SEED
    return tuple(range(first, first + (QUICK_SEEDS if quick else max(e.seeds for e in all_experiments().values()))))


def chosen(names: Sequence[str] = (), quick: bool = False) -> dict[str, Experiment]:
    """The experiments of these names; without names all, or with `quick` its experiments, only with bandits.

    Raises:
        ValueError: an unknown name.
    """
    if quick and not names:
        return {name: replace(all_experiments()[name], ids=(ARMS,)) for name in QUICK}
    there = all_experiments()
    if odd := [name for name in names if name not in there]:
        raise ValueError(unknown("experiment", odd[0], there))
    return {name: each for name, each in there.items() if name in (names or there)}


def studies_of(
    students: Sequence[Any],
    experiments: Mapping[str, Experiment] | None = None,
    seeds: Sequence[int] = seeds_of(),
    turns: int = TURNS,
) -> list[Study]:
    """The studies with the episodes that the scores of these students need; references come first.

    Experiments without `lessons` share a study in each environment, if they have equally many seeds; students that
    forget between episodes are left out of the other studies. Families that are not installed are left out.
    """
    specs = [student_spec(each) for each in students]
    groups: dict[tuple[str | int, tuple[str, ...], tuple[int, ...]], list[Experiment]] = {}
    for name, each in (experiments or all_experiments()).items():
        own, there = tuple(seeds[: each.seeds]), [id for id in each.ids if not entry(id).family.missing()]
        for those in zip(own) if each.town else (own,):
            for ids in (tuple(there),) if each.town and there else zip(there):
                groups.setdefault((name if each.lessons else each.seeds, ids, those), []).append(each)
    return [_study_of(specs, group, ids, those, turns) for (_, ids, those), group in groups.items()]


def _study_of(
    students: Sequence[str], asked: Sequence[Experiment], ids: Sequence[str], seeds: Sequence[int], turns: int
) -> Study:
    """The study of experiments with the same lessons in some environments; in a town it has one seed."""
    teachers = tuple(dict.fromkeys(teacher for each in asked for teacher in (*each.arms, *(each.unit or ()))))
    references = tuple(dict.fromkeys(each.reference for each in asked))
    town = {"town": seeds[0]} if asked[0].town else {}
    options = {id: own for id in ids if (own := {**OPTIONS.get(id, {}), **town})}
    common: dict[str, Any] = {"ids": ids, "seeds": seeds, "max_turns": turns, "options": options}
    if not asked[0].lessons:
        able = (each for each in (*references, *students) if not any(_unable(each, id) for id in ids))
        return Study(teachers=teachers, students=tuple(dict.fromkeys(able)), **common)
    able = (each for each in students if parse_student(each).remembers)
    taught = {"students": list(dict.fromkeys((*references, *able))), "teachers": list(teachers)}
    lessons = {"lessons": [1], "worlds": [asked[0].lessons], **taught}
    return Study(teachers=(TESTER,), students=references, transfer=lessons, **common)  # with lessons before its tests


def _unable(spec: str, id: str) -> str:
    """Why a student cannot play here; empty if it can, or if only playing shows it."""
    student, place = parse_student(spec), entry(id)
    why = place.family.missing()
    if student.draws_worlds and not why:
        try:
            student.seat(place.family, place.family.make_world(**{**place.options, **OPTIONS.get(id, {})}))
        except ValueError as error:
            why = f"{error}"
    return why


def take(
    student: Any,
    store: Path | str,
    names: Sequence[str] = (),
    quick: bool = False,
    key: str = "",
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    turn_seconds: float | None = None,
) -> Card:
    """Play the episodes of the suite that the store lacks, and return the card of a student.

    Args:
        student: a spec, a `Student`, or the factory of an agent.
        store: the file of the episodes; an interrupted suite is resumed from it, and failed episodes are played again.
        names: names of experiments; empty: all, or with `quick` its experiments.
        quick: fewer experiments, seeds and turns, for agents whose answers cost money or time.
        key: a text of your choice, for worlds that nobody could tune an agent to.
        workers: as in `llf_teacher.studies.run`.
        progress: called with the number of completed episodes, and the total.
        turn_seconds: time limit of a turn, after which the episode of a hanging agent fails; None: no limit.

    Raises:
        ValueError: the student or an experiment is unknown, or cannot play.
        StudyError: the episodes cannot go on, for example after a spending limit; completed ones are stored.
    """
    spec, experiments, seeds = student_spec(student), chosen(names, quick), seeds_of(key, quick)
    studies = studies_of([spec], experiments, seeds, QUICK_TURNS if quick else TURNS)
    rows, lost = played(studies, store, workers, progress, turn_seconds)
    scores = {name: scored(each, spec, rows, seeds) for name, each in experiments.items()}
    return Card.of(spec, experiments, scores, rows, lost, suite=VERSION, digest=digest(), key=key, quick=quick)


def played(
    studies: Iterable[Study],
    store: Path | str,
    workers: int | None,
    progress: Callable[[int, int], None] | None,
    turn_seconds: float | None,
) -> tuple[list[Mapping[str, Any]], list[Mapping[str, Any]]]:
    """Play the episodes of the studies that the store lacks, and return the rows of episodes and of failures.

    Arguments as in `take`; `progress` covers all studies.
    """
    options = RunOptions(limits=Limits(turn_seconds=turn_seconds), retry_failed=True)
    each_keys = [(study, {each.key for each in study.episodes()}) for study in studies]
    total, done = sum(len(own) for _, own in each_keys), 0
    lost: list[Mapping[str, Any]] = []

    def show(of_study: int, _: int) -> None:
        if progress is not None:
            progress(done + of_study, total)

    for study, own in each_keys:
        with run(study, store, workers, show, options) as results:
            lost += [each for each in results.failures() if each["key"] in own]
        done += len(own)
    keys = set[str]().union(*(own for _, own in each_keys))
    with load(store) as results:
        return [row for row in results.rows() if row["key"] in keys], lost


def scored(experiment: Experiment, student: str, rows: Iterable[Mapping[str, Any]], seeds: Sequence[int]) -> Score:
    """The score of a student in an experiment, from the rows of a store."""
    if experiment.lessons and not parse_student(student).remembers:
        return Score(why="the student does not remember earlier episodes")
    return score(arms_of(experiment, student, rows, seeds), experiment.margin)


def arms_of(
    experiment: Experiment, student: str, rows: Iterable[Mapping[str, Any]], seeds: Sequence[int]
) -> dict[str, Arms]:
    """The regret of a student and the reference in each environment of an experiment, from the rows of a store."""
    seeds = seeds[: experiment.seeds]
    asked = (row for row in rows if row["worlds"] == experiment.lessons)
    found: dict[tuple[object, ...], Mapping[str, Any]] = {
        (row["id"], row["teacher"], row["student"], row["seed"]): row for row in asked
    }

    def regrets(*lesson: str) -> NDArray[np.float64]:
        """For each seed the regret in the turns that count; NaN without the episode."""
        played = (found.get((*lesson, seed)) for seed in seeds)
        return np.array([math.fsum(row["regrets"][experiment.since :]) if row else np.nan for row in played])

    def unread(*lesson: str) -> float:
        """The share of turns whose answer was not an action."""
        played = [row for seed in seeds if (row := found.get((*lesson, seed)))]
        return float(sum(row["parse_failures"] for row in played) / max(1, sum(row["turns"] for row in played)))

    better, worse, silent = experiment.arms
    unit = experiment.unit or (better, worse)
    return {
        id: Arms(
            better=regrets(id, better, student),
            worse=regrets(id, worse, student),
            unit_better=regrets(id, unit[0], experiment.reference),
            unit_worse=regrets(id, unit[1], experiment.reference),
            silent=regrets(id, silent, student),
            unread={teacher: unread(id, teacher, student) for teacher in experiment.arms},
            missing=_unable(student, id),
        )
        for id in experiment.ids
    }
