"""The mirror as studies, and the scores of a teacher from the episodes that were played."""

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from llf_teacher.episodes.record import READINGS
from llf_teacher.registry import entry
from llf_teacher.speakers.parsing import needed_of, speaks_freely
from llf_teacher.studies import load
from llf_teacher.studies.analysis.statistics import LEAST
from llf_teacher.studies.definition.custom_specs import parse_teacher, teacher_spec
from llf_teacher.studies.definition.design import NEXT, TESTER
from llf_teacher.studies.definition.study import Study
from llf_teacher.suite.card import Card, checksum
from llf_teacher.suite.experiment import TURNS
from llf_teacher.suite.mirror.quality import Quality, TaughtEpisode, TaughtWorld, all_qualities
from llf_teacher.suite.places import ARMS, FILMS, HOUSE, OPTIONS
from llf_teacher.suite.play import named, played, seeds_of
from llf_teacher.suite.score import LEVELS, Arms, Score, score
from pz_envs.checking import ALONE, share_false
from teachers.spec import check_range

VERSION = "mirror-v1"
"""Worlds, seeds, students, references and what is counted never change under this name; `digest` is that of all."""
SEEDS, QUICK_SEEDS = 20, 10
FAILURES = 3
"""Failures after which no more lessons begin: a quality that lacks a world is not measured anyway."""
_LESSON = ("lessons", "draws", "id", "teacher", "student", "seed")
"""What identifies an episode here: whether it is a test after a lesson, the measure, and who met where."""
Episodes = Callable[..., TaughtEpisode]
"""The episode of what `_LESSON` names; a KeyError if it was not played."""


@dataclass(frozen=True, kw_only=True)
class TeacherCard(Card):
    """What a teacher is worth to known students; `student` is the spec of the teacher."""

    role: ClassVar[str] = "teacher"
    about: ClassVar[str] = "what it is worth to known students"
    scored: ClassVar[str] = "quality"

    def settings(self) -> str:
        """Also how much was read of its words without claims."""
        from llf_teacher.studies.report.parts.accounting import own_words  # imports Matplotlib

        bounds = self.cost.get("least_false", 0.0), self.cost.get("most_false", 1.0)
        own = own_words({name: int(self.cost.get(name, 0)) for name in READINGS}, bounds)
        if own is None:
            return super().settings()
        return (
            f"{super().settings()} Of {own.sentences} sentences without claims {own.read:.0%} were read; of these "
            f"{own.false:.0%} were false, with the reader's own errors {own.bounds[0]:.0%} to {own.bounds[1]:.0%}."
        )


def digest() -> str:
    """A digest of all that decides a score: worlds, and the files that define what is counted and with whom."""
    here = Path(__file__).parent
    files = [here / "population.py", here / "quality.py", *sorted((here / "qualities").glob("*.py"))]
    texts = [file.read_text(encoding="utf-8") for file in files]
    worlds = ARMS, HOUSE, FILMS, OPTIONS, seeds_for(), seeds_for(quick=True, key="a key")
    return checksum([VERSION, SEEDS, worlds, TURNS, LEVELS, texts])


def take(
    teacher: Any,
    store: Path | str,
    names: Sequence[str] = (),
    quick: bool = False,
    key: str = "",
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    turn_seconds: float | None = None,
    worlds: int | None = None,
) -> TeacherCard:
    """Play what the store lacks of a teacher's lessons, and give its card.

    Args:
        teacher: a spec, a personality, or the factory of a policy for the teacher's seat.
        names: of qualities; without them all.
        quick: fewer seeds.
        store, key, workers, progress, turn_seconds: as in `llf_teacher.suite.take`.
        worlds: number of worlds, 5 to 20; None: 20, or 10 if it is `quick`. With fewer than 9 no test of a card of
            all qualities can be significant.

    Raises:
        ValueError: the teacher or a quality is unknown, `worlds` is not allowed, or an environment lacks what the
            teacher needs.
        StudyError: the episodes cannot go on; those so far are stored.
    """
    spec, asked = teacher_spec(teacher), named("quality", names, all_qualities())
    seeds = seeds_for(quick, key, worlds)
    found, lost = played(studies_of(spec, asked.values(), seeds), store, workers, progress, turn_seconds, FAILURES)
    with load(store) as results:
        rows = {tuple(row[name] for name in _LESSON): row for row in found}

        @cache
        def episode(*lesson: object) -> TaughtEpisode:
            row = rows[lesson]
            return TaughtEpisode(row["regrets"], row["words"], results.turns(row["key"]))

        scores = {name: _scored(each, spec, episode, seeds) for name, each in asked.items()}
        card = TeacherCard.of(spec, asked, scores, found, lost, suite=VERSION, digest=digest(), key=key, quick=quick)
        if not speaks_freely(parse_teacher(spec)):
            return card
        own = [row for row in found if row["teacher"] == spec]
        turns = [(row["seed"], turn) for row in own for turn in results.turns(row["key"])]
    paid = [turn["paid"] for _, turn in turns if turn["paid"]]
    read: defaultdict[int, list[tuple[str, bool]]] = defaultdict(list)
    for seed, turn in turns:
        alone = (each for each in turn["readings"] or () if each["layer"] in ALONE)
        read[seed] += [(each["text"], each["holds"] is False) for each in alone]
    low, high = share_false(read.values())
    cost = {"least_false": low, "most_false": high, "answers": float(len(paid))}
    cost |= {name: sum(row[name] or 0.0 for row in own) for name in READINGS}
    cost |= {name: math.fsum(each[name] or 0 for each in paid) for name in ("input_tokens", "output_tokens", "usd")}
    return replace(card, cost={**card.cost, **cost})


def seeds_for(quick: bool = False, key: str = "", worlds: int | None = None) -> tuple[int, ...]:
    """The seeds of the worlds, as many as `take` says.

    Raises:
        ValueError: so many are not allowed.
    """
    number = (QUICK_SEEDS if quick else SEEDS) if worlds is None else worlds
    check_range("worlds", number, LEAST, SEEDS, int)
    return seeds_of(key)[:number]


def studies_of(teacher: str, asked: Iterable[Quality], seeds: Sequence[int]) -> Iterator[Study]:
    """The studies of all lessons: one for qualities of the same kind, or for each town."""
    groups: dict[tuple[object, ...], list[Quality]] = {}
    for each in asked:
        groups.setdefault((each.town, each.bits, each.turns, each.zero, each.ids), []).append(each)
    for group in groups.values():
        first, ids = group[0], [id for id in group[0].ids if _serves(id, teacher)]
        students = tuple(dict.fromkeys(student for each in group for student in each.students))
        teachers = tuple(dict.fromkeys((*(other for each in group for other in each.teachers), teacher)))
        common: dict[str, Any] = {"ids": ids, "students": students, "max_turns": first.turns}
        if ids and not first.town:
            options = {id: OPTIONS[id] for id in ids if id in OPTIONS}
            yield Study(teachers=teachers, seeds=seeds, bits=first.bits or False, options=options, **common)
        lessons = {"lessons": [1], "students": students, "teachers": teachers, "worlds": [NEXT]}
        for seed in seeds if ids and first.town else ():
            options = {id: {**OPTIONS.get(id, {}), "town": seed} for id in ids}
            yield Study(teachers=(TESTER,), seeds=(seed,), transfer=lessons, options=options, **common)


def _serves(id: str, teacher: str) -> bool:
    return entry(id).family.serves(needed_of(parse_teacher(teacher)), **OPTIONS.get(id, {}))


def _world(quality: Quality, id: str, teacher: str, seed: int, episode: Episodes) -> TaughtWorld | None:
    """The lessons of a teacher in a world; None if one was not played."""
    lesson = int(quality.town), quality.bits, id
    try:
        both = ([episode(*lesson, who, each, seed) for each in quality.students] for who in (teacher, TESTER))
        return TaughtWorld(*both)
    except KeyError:
        return None


def _scored(quality: Quality, teacher: str, episode: Episodes, seeds: Sequence[int]) -> Score:
    """The score of a teacher in a quality."""
    found: dict[str, tuple[NDArray[np.float64], str]] = {}
    shared = np.ones(len(seeds), bool)
    for id in quality.ids:
        each_world = (
            (_world(quality, id, who, seed, episode) for seed in seeds) for who in (teacher, *quality.teachers)
        )
        worlds, outcomes, why = [list(filter(None, row)) for row in each_world], np.zeros((3, len(seeds))), ""
        if not _serves(id, teacher):
            why = "the oracle lacks what the teacher needs"
        elif missing := len(seeds) - min(map(len, worlds)):
            why = f"{missing} of {len(seeds)} worlds failed or were not played"
        else:
            counted = [quality.outcome(row) for row in worlds[: len(quality.teachers)]]  # without silence
            outcomes = np.array([*counted, np.zeros(len(seeds))][:3])
            there = np.isfinite(outcomes).all(axis=0)
            why = quality.absent if there.sum() < LEAST else ""
            shared = shared if why else shared & there
        found[id] = outcomes, why
    arms = {}
    for id, (outcomes, why) in found.items():
        own, one, zero = -outcomes[:, shared]
        arms[id] = Arms(better=own, worse=zero, unit_better=one, unit_worse=zero, missing=why)
    return score(arms)
