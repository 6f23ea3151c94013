"""The suite as a study, and the scores of a student from the played episodes."""

import hashlib
import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from llf_teacher.registry import entry
from llf_teacher.students.builtin.llm import LLM
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.trait import traits_of
from llf_teacher.studies import load
from llf_teacher.studies.definition.custom_specs import student_spec
from llf_teacher.studies.definition.design import TESTER
from llf_teacher.studies.definition.fingerprints import mixed, mixed_words
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.changes import STOP
from llf_teacher.studies.execution.progress import in_words
from llf_teacher.suite.answers import answers_of, first_prompt, rows_of
from llf_teacher.suite.card import Card, checksum
from llf_teacher.suite.environments import ARMS, OPTIONS
from llf_teacher.suite.experiment import TURNS, Experiment, all_experiments
from llf_teacher.suite.playing import Progress, SuitePlayer
from llf_teacher.suite.score import ALPHA, LEVELS, Arms, Score, score
from teachers.common import FACTS
from teachers.spec import unknown

VERSION = "suite-v1"
"""The version: its worlds, seeds, teachers, references and thresholds never change; `digest` covers all of them."""
QUICK_SEEDS, QUICK_TURNS = 8, 5
QUICK = ("advice", "hints", "silence", "turncoat")
"""The experiments of `quick`: those with the best ratio of contrast to noise; each is played with bandits."""
QUICK_SECONDS = 1200
"""Time of the quick suite; for a slow student it leaves out what does not fit."""
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


def actions_of(names: Sequence[str] = (), quick: bool = False) -> dict[str, str]:
    """What an answer must be in each environment of experiments, by id; arguments as for `chosen`."""
    places = {id: entry(id) for each in chosen(names, quick).values() for id in each.ids}
    there = {id: place for id, place in places.items() if not place.family.missing()}
    return {
        id: place.family.make_world(**{**place.options, **OPTIONS.get(id, {})}).action_syntax
        for id, place in there.items()
    }


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
    if (student.draws_worlds or student.needs_discrete) and not why:
        try:
            student.seat(place.family, place.family.make_world(**{**place.options, **OPTIONS.get(id, {})}))
        except ValueError as error:
            why = f"{error}"
    return why


class Outlook(NamedTuple):
    """What a run of the suite is going to play, and how long that takes at the measured speed."""

    names: tuple[str, ...]
    """The experiments."""
    left_out: Mapping[str, str]
    """Experiments that the quick suite leaves out for want of time, each with the reason."""
    worlds: int
    """Number of worlds of most experiments."""
    episodes: int
    """Number of the student's episodes that are missing."""
    seconds: float
    """How long all missing episodes take, those of references included."""
    turn_seconds: Mapping[str, float]
    """Seconds of a turn of the student, by environment; empty if nothing is missing."""

    def __str__(self) -> str:
        speed = ", ".join(f"{seconds:.2g} s in {id}" for id, seconds in self.turn_seconds.items())
        text = f"{self.episodes} episodes of the student are to be played: about {in_words(self.seconds)}"
        text += f" at the measured speed (a turn takes {speed})" if speed else ""
        return ". ".join([text, *(f"Left out: {name}, for {why}" for name, why in self.left_out.items())]) + "."


def take(
    student: Any,
    store: Path | str,
    names: Sequence[str] = (),
    quick: bool = False,
    key: str = "",
    workers: int | None = None,
    progress: Progress | None = None,
    turn_seconds: float | None = None,
    announce: Callable[[Outlook], object] | None = None,
    changed: str = STOP,
) -> Card:
    """Play the episodes of the suite that the store lacks, and return the card of a student.

    It plays a few episodes of each kind first, which measure the speed. `quick` without names is as much of its
    experiments as fits `QUICK_SECONDS` at that speed: see `quick_plans`.

    Args:
        student: a spec, a `Student`, or the factory of an agent.
        store: the file of the episodes; an interrupted suite is resumed from it, and failed episodes are played again.
        names: names of experiments; empty: all, or with `quick` its experiments.
        quick: fewer experiments, seeds and turns, for agents whose answers cost money or time.
        key: a text of your choice, for worlds that nobody could tune an agent to.
        workers: as in `llf_teacher.studies.run`.
        progress: called with the number of completed episodes, the total, and the seconds that are left.
        turn_seconds: time limit of a turn, after which the episode of a hanging agent fails; None: no limit.
        announce: called with what is going to be played, after the measurement.
        changed: what becomes of stored episodes whose student has changed since: `stop` before playing, `replay`, or
            `keep`, which the card says.

    Raises:
        ValueError: the student or an experiment is unknown, or cannot play.
        StoreError: the student's code has changed since episodes in the store were played.
        StudyError: the episodes cannot go on, for example after a spending limit; completed ones are stored.
    """
    began = time.monotonic()
    spec, experiments, turns = student_spec(student), chosen(names, quick), QUICK_TURNS if quick else TURNS
    seeds: Sequence[int] = seeds_of(key, quick)
    player = SuitePlayer(store, spec, workers, progress, turn_seconds, changed)
    studies = studies_of([spec], experiments, seeds, turns)
    player.begin(studies)
    player.measure(studies)
    left_out: dict[str, str] = {}
    hurry = quick and not names
    if hurry:
        experiments, seeds = _fitting(player, spec, seeds)
        left_out = {name: _too_slow(player, spec) for name in QUICK if name not in experiments}
        studies = studies_of([spec], experiments, seeds, turns)
        player.begin(studies)
    if announce is not None:
        number = len(seeds[: max(each.seeds for each in experiments.values())])
        speeds = player.pace.turn_seconds(spec) if player.missing(spec) else {}
        announce(Outlook(tuple(experiments), left_out, number, player.missing(spec), player.seconds_left, speeds))
    if hurry and player.seconds_left > QUICK_SECONDS / 4:
        experiments = _in_time(player, spec, experiments, seeds, began + QUICK_SECONDS)
        left_out = {name: _too_slow(player, spec) for name in QUICK if name not in experiments} | left_out
        studies = studies_of([spec], experiments, seeds, turns)
    else:
        player.play(studies)
    rows, lost = player.results(studies)
    scores = {name: scored(each, spec, rows, seeds) for name, each in experiments.items()}
    with load(store) as results:
        form = _form_of(spec)
        played = (({row["teacher"], row["student"]}, row["revision"], 1) for row in rows)
        newest = results.manifest.get("code", {})
        found = mixed(results.definitions, played, newest)
        several = {name: mixed_words(name, numbers) for name, numbers in found.items()}
        answers = {
            name: answers_of(each, spec, rows, seeds, results, form, scores[name].places)
            for name, each in experiments.items()
        }
    readable = {name: scored_where_read(each, spec, rows, seeds, scores[name]) for name, each in experiments.items()}
    settings = {"suite": VERSION, "digest": digest(), "key": key, "quick": quick, "left_out": left_out}
    return Card.of(spec, experiments, scores, rows, lost, answers, readable, mixed=several, **settings)


def _form_of(spec: str) -> Callable[[str], str]:
    """For a student that asks a model, the text of its first prompt in an environment, by id; empty for others."""
    student, _ = traits_of(parse_student(spec))

    @cache
    def form(id: str) -> str:
        return first_prompt(id, student, **OPTIONS.get(id, {})) if isinstance(student, LLM) else ""

    return form


def by_need(experiments: Mapping[str, Experiment]) -> list[str]:
    """The names of experiments, those that rest on few others first."""
    return sorted(experiments, key=lambda name: len(experiments[name].rests_on))


def quick_plans(seeds: Sequence[int]) -> Iterator[tuple[dict[str, Experiment], Sequence[int]]]:
    """What the quick suite may play, from the most to the least: experiments, and the seeds of their worlds.

    The experiment that rests on most others goes first. The last plan has the fewest worlds whose test can be
    significant; fewer turns would change what the others measure.
    """
    whole = chosen(quick=True)
    ordered = by_need(whole)
    for number in range(len(ordered), 0, -1):
        yield {name: each for name, each in whole.items() if name in ordered[:number]}, seeds
    fewest = math.ceil(math.log2(2 / ALPHA))  # signs of that many worlds can be flipped in so many ways
    yield {ordered[0]: whole[ordered[0]]}, seeds[:fewest]


def _fitting(player: SuitePlayer, student: str, seeds: Sequence[int]) -> tuple[dict[str, Experiment], Sequence[int]]:
    """The first plan of the quick suite that fits its time and has all that was begun; else the least."""
    best = chosen(quick=True), seeds
    for plan in quick_plans(seeds):
        keys = {each.key for study in studies_of([student], *plan, QUICK_TURNS) for each in study.episodes()}
        if not player.begun <= keys:
            break
        best = plan
        if player.seconds_of(keys) <= QUICK_SECONDS:
            break
    return best


def _in_time(
    player: SuitePlayer, student: str, experiments: Mapping[str, Experiment], seeds: Sequence[int], until: float
) -> dict[str, Experiment]:
    """Play experiments one after the other, as long as the next one fits the time or was begun; returns these."""
    played: dict[str, Experiment] = {}
    keys: set[str] = set()
    for name in by_need(experiments):
        studies = studies_of([student], {name: experiments[name]}, seeds, QUICK_TURNS)
        own = {each.key for study in studies for each in study.episodes()} - keys
        if played and not player.begun & own and time.monotonic() + player.seconds_of(own) > until:
            break
        player.play(studies)
        played[name] = experiments[name]
        keys |= own
    return {name: each for name, each in experiments.items() if name in played}


def _too_slow(player: SuitePlayer, student: str) -> str:
    """Why an experiment does not fit the quick suite."""
    speed = max(player.pace.turn_seconds(student).values(), default=0.0)
    minutes = QUICK_SECONDS // 60
    return f"at {speed:.2g} s a turn it does not fit {minutes} minutes; the same command goes on with what fits then"


def scored(experiment: Experiment, student: str, rows: Iterable[Mapping[str, Any]], seeds: Sequence[int]) -> Score:
    """The score of a student in an experiment, from the rows of a store."""
    if experiment.lessons and not parse_student(student).remembers:
        return Score(why="the student does not remember earlier episodes")
    return score(arms_of(experiment, student, rows, seeds), experiment.margin)


def scored_where_read(
    experiment: Experiment, student: str, rows: Sequence[Mapping[str, Any]], seeds: Sequence[int], over_all: Score
) -> Score | None:
    """The score in the worlds in which each answer was an action; None if all worlds are such ones.

    Args:
        experiment, student, rows, seeds: as for `scored`.
        over_all: the score in all worlds; answers count in its environments.
    """
    own = [row for row in rows_of(experiment, student, rows, seeds) if row["id"] in over_all.places]
    failed = {row["seed"] for row in own if row["parse_failures"]}
    left = [seed for seed in seeds[: experiment.seeds] if seed not in failed]
    return scored(experiment, student, rows, left) if failed else None


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
