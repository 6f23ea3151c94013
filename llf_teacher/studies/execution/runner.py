"""The runner: plays the episodes of a study that a store lacks, by any executor, in constant memory."""

import contextlib
import itertools
import os
import platform
import re
import threading
from bisect import bisect_right
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import partial
from importlib import metadata
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from llf_teacher.episodes.failure import Failure, failure
from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.models.cache import spending
from llf_teacher.models.local.catalogue import is_local
from llf_teacher.models.local.options import slots
from llf_teacher.models.model import AsksModel
from llf_teacher.models.settings import CACHE
from llf_teacher.speakers.llm_reader import LLMReader
from llf_teacher.speakers.parsing import parse_reader, parse_teacher
from llf_teacher.speakers.speaker import Speaker
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.trait import traits_of
from llf_teacher.studies.definition.custom_specs import check_portable
from llf_teacher.studies.definition.stored_specs import facts_of, is_own
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution import changes, executors
from llf_teacher.studies.execution.episode import rehearse
from llf_teacher.studies.execution.executors import Executor, ExecutorError, Lost, Work
from llf_teacher.studies.execution.limits import Clock, Limits, TimeIsUp
from llf_teacher.studies.execution.shared_functions import put_back
from llf_teacher.studies.execution.worker import Packed, Stop, describe_episode, run_episode, set_up
from llf_teacher.studies.store import Store, StoreError
from llf_teacher.studies.store.store_lock import lock_store
from teachers.personality import Personality

if TYPE_CHECKING:
    from llf_teacher.studies.execution.interim import Decision

_PATIENCE = 1.0  # seconds between reports of progress without results


class EpisodeError(RuntimeError):
    """Episodes failed. Played episodes and the reasons of failures are stored."""

    trace: str = ""
    """The traceback of the first failure in the process that played it; empty if the message is enough."""
    played: int = 0
    """Number of played episodes."""


class StudyError(EpisodeError):
    """The study cannot go on. Played episodes are stored."""


class Shard(NamedTuple):
    """A part of a study's episodes: every `of`-th, starting with the `number`-th."""

    number: int
    of: int

    def __str__(self) -> str:
        return f"{self.number}/{self.of}"


def parse_shard(text: str) -> Shard:
    """Parse a shard of the command line, such as `3/8`.

    Raises:
        ValueError: bad syntax, or no such part.
    """
    match = re.fullmatch(r"(\d+)/(\d+)", text)
    shard = Shard(*map(int, match.groups())) if match else Shard(0, 0)
    if not 1 <= shard.number <= shard.of:
        raise ValueError(f"shard must be i/n with 1 <= i <= n, as in 3/8, got {text!r}")
    return shard


class RunOptions(NamedTuple):
    """How to play a study, without effect on its episodes."""

    executor: str | None = None
    """A name of `executors.NAMES`.

    None: `threads` without limits where a model of this machine is asked, `here` for one worker without limits, else
    `processes`, where limits can be enforced by killing a process.
    """
    address: str | None = None
    """Address of the executor's cluster."""
    limits: Limits = Limits()
    shard: Shard = Shard(1, 1)
    retry_failed: bool = False
    """Whether to play again episodes that failed in an earlier run."""
    fail_fast: bool = False
    """Whether to begin no more episodes after a failure."""
    keys: Collection[str] | None = None
    """Keys of the episodes to play; None: all."""
    changed: str = changes.STOP
    """What becomes of stored episodes whose teacher, student or world has changed since, one of `changes.CHOICES`."""
    name: str = ""
    """The study's name in its store and its report; empty: none, or that of an earlier run."""
    on_episode: Callable[[EpisodeSpec, Packed | None], object] | None = None
    """Called with each episode at its end, None if it failed."""

    def engine(self, workers: int | None, waits: bool = False) -> str:
        """Name of the executor.

        Args:
            workers: number of episodes at once; None: one per core.
            waits: whether a model of this machine is asked, for which players wait.
        """
        unlimited = self.limits == Limits()
        by_itself = "here" if workers == 1 and unlimited else "threads" if waits and unlimited else "processes"
        return self.executor or by_itself


class _Tally(NamedTuple):
    """Numbers of episodes of a study, by their state."""

    there: int
    lost: int
    """Episodes that failed earlier and will not be played again."""
    todo: int
    students: tuple[str, ...]
    """Students of the episodes to be played."""
    turns: int
    """Greatest number of turns of an episode to be played."""
    teachers: Mapping[str, EpisodeSpec]
    """Teachers of the episodes to be played, each with its first episode."""

    @property
    def done(self) -> int:
        return self.there + self.lost

    @property
    def total(self) -> int:
        return self.done + self.todo


def play_missing(
    study: Study,
    store: Store,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    environment: Mapping[str, str] | None = None,
    options: RunOptions = RunOptions(),  # noqa: B008 (immutable)
    on_interim: "Callable[[Decision], None] | None" = None,
) -> int:
    """Play and store every episode of the study that the store lacks; `llf_teacher.studies.run` does it for users.

    A study with interim analyses is played and tested step by step. With `stop` it ends as soon as the design allows,
    and cannot be split into shards.

    Args:
        study: the study.
        store: the store; it gets each episode at its end.
        workers: number of episodes at once; None: one per core. With 1 this process plays, unless `options` say
            otherwise.
        progress: called with the number of completed episodes, and the total.
        environment: environment variables for the workers, such as `LLF_LLM_BUDGET`, beside those of this process.
        options: how to play.
        on_interim: called with the decision of each interim analysis of this run.

    Returns:
        The number of played episodes.

    Raises:
        EpisodeError: episodes failed, now or earlier; all others are stored.
        StudyError: the study cannot go on, for example after a spending limit; played episodes are stored.
        ValueError, ModuleNotFoundError: a student cannot play here, or the store is damaged; nothing was played. Or the
            store can no longer be written; episodes that were played before are in it.
    """
    options.limits.check()
    with lock_store(store.path):
        store.check_rows()
        silent: Callable[..., None] = lambda *_: None  # noqa: E731 (of two callbacks)
        try:
            return _Run(study, store, options, progress or silent, environment or {}, on_interim or silent).play(
                workers
            )
        except ExecutorError as error:
            raise StudyError(f"{error}") from None


class _Run:
    """One run of a study."""

    def __init__(
        self,
        study: Study,
        store: Store,
        options: RunOptions,
        progress: Callable[[int, int], None],
        environment: Mapping[str, str],
        on_interim: "Callable[[Decision], None]",
    ) -> None:
        self._study, self._store, self._options, self._progress = study, store, options, progress
        self._on_interim = on_interim
        self._cache = os.environ.get(CACHE) or f"{store.path.absolute().with_suffix('.llm.db')}"
        self._environment = {CACHE: self._cache, **environment}
        self._fresh = store.empty
        self._played = self._failed = 0
        self._first: EpisodeError | None = None
        """The first episode that failed."""
        self._error: EpisodeError | None = None
        """Why no more episodes begin."""

    def play(self, workers: int | None) -> int:
        """See `play_missing`."""
        store, options = self._store, self._options
        if options.shard.of > 1 and self._study.interim_analyses.get("stop"):
            raise ValueError(
                f"a study whose interim analyses may stop it cannot be played in shards, got shard {options.shard}; "
                "play it whole, or leave out `stop`"
            )
        changes.settle(self._study, store, self._specs, options.changed)
        tally = self._count()
        for student in tally.students:
            parse_student(student).check(os.environ | self._environment)
        for teacher in speakers(self._study) if tally.todo else ():
            teacher.check(os.environ | self._environment)
        if tally.todo and isinstance(reader := parse_reader(self._study.reader), LLMReader):
            reader.check(os.environ | self._environment)
        self._rehearse(tally)
        waits = asks_here(self._study, tally.students)
        executor = options.engine(workers, waits)
        if waits and workers is None and executor == "threads":
            workers = slots()  # each then keeps its conversation in the model's memory
        if tally.todo and executor not in executors.HERE:
            check_portable((*self._study.teachers, *self._study.transfer.get("teachers", ()), *tally.students))
        self._progress(tally.done, tally.total)
        store.define(manifest(self._study))
        if options.name:
            store.write_manifest({"name": options.name})
        if tally.todo and not self._ends(0):
            call = partial(run_episode, limits=options.limits)
            work = Work(partial(set_up, self._environment), call, tally.todo, options.limits.hard_seconds(tally.turns))
            try:
                with executors.start(executor, work, workers, options.address) as engine:
                    self._play(engine, tally)
            finally:
                with contextlib.suppress(StoreError):  # then the manifest lacks the costs, but no episode is lost
                    if spent := spending(self._cache):
                        store.write_manifest({"llm": spent})
        if error := self._error or self._failures(tally):
            error.played = self._played
            raise error
        return self._played

    def _rehearse(self, tally: _Tally) -> None:
        """Let each personality of the user's own speak, before anything is played; errors as in `rehearse`."""
        for teacher, spec in tally.teachers.items():
            parsed = parse_teacher(teacher) if is_own(teacher) else None
            if not isinstance(getattr(parsed, "personality", parsed), Personality):
                continue
            clock = Clock(self._options.limits if threading.current_thread() is threading.main_thread() else Limits())
            try:
                with contextlib.suppress(TimeIsUp), clock.running():
                    rehearse(spec)
            finally:
                put_back()

    def _specs(self) -> Iterator[EpisodeSpec]:
        shard, keys = self._options.shard, self._options.keys
        specs = itertools.islice(self._study.episodes(), shard.number - 1, None, shard.of)
        return specs if keys is None else (spec for spec in specs if spec.key in keys)

    def _is_there(self, spec: EpisodeSpec) -> bool:
        return not self._fresh and self._store.has(spec.key)

    def _is_lost(self, spec: EpisodeSpec) -> bool:
        """Whether the episode failed earlier and is not played again."""
        return not self._fresh and not self._options.retry_failed and self._store.has_failed(spec.key)

    def _count(self) -> _Tally:
        there = lost = todo = turns = 0
        students: dict[str, None] = {}
        teachers: dict[str, EpisodeSpec] = {}
        for spec in self._specs():
            if self._is_there(spec):
                there += 1
            elif self._is_lost(spec):
                lost += 1
            else:
                todo += 1
                students[spec.student] = None
                teachers.setdefault(spec.teacher, spec)
                turns = max(turns, spec.max_turns * (spec.lessons + 1))
        return _Tally(there, lost, todo, tuple(students), turns, teachers)

    def _ends(self, analysis: int) -> bool:
        """Whether the design ends the study now; reports the decisions from this analysis on."""
        if not self._study.interim_analyses or self._options.shard.of > 1:
            return False
        from llf_teacher.studies.execution.interim import decide  # imports Matplotlib

        decision = decide(self._store, self._study)
        if decision and decision.analysis >= max(analysis, 1):
            self._on_interim(decision)
        return decision is not None and decision.stops

    def _play(self, engine: Executor[EpisodeSpec, Packed | Failure | Stop], tally: _Tally) -> None:
        todo = (spec for spec in self._specs() if not self._is_there(spec) and not self._is_lost(spec))
        if not self._study.interim_analyses:
            self._play_these(engine, todo, tally)
            return
        analyses = {
            seed: 1 + bisect_right(self._study.interim_analyses["at"], i)
            for i, seed in enumerate(cast(Sequence[int], self._study.seeds))
        }
        for analysis, specs in itertools.groupby(todo, lambda spec: analyses[spec.seed]):
            self._play_these(engine, specs, tally)
            if self._error or self._ends(analysis):
                return

    def _play_these(
        self, engine: Executor[EpisodeSpec, Packed | Failure | Stop], todo: Iterator[EpisodeSpec], tally: _Tally
    ) -> None:
        under_way = 0
        while True:
            if self._error is None:
                for spec in itertools.islice(todo, max(0, engine.room - under_way)):
                    engine.submit(spec)
                    under_way += 1
            if not under_way:
                return
            running = self._error is None
            ended = engine.wait(_PATIENCE)
            under_way -= len(ended)
            with self._store.together():
                for spec, result in ended:
                    self._take(spec, result)
            self._progress(tally.done + self._played + self._failed, tally.total)
            if running and self._error is not None:  # begin no more; running episodes still count
                under_way -= len(engine.cancel())

    def _take(self, spec: EpisodeSpec, result: Packed | Failure | Stop | Lost | None) -> None:
        """Store the result of an episode."""
        if result is None:
            return
        if isinstance(result, Lost):
            result = failure(*result)
        if isinstance(result, Packed):
            self._store.add_packed(spec, result.episode, result.turns)
            self._played += 1
        elif isinstance(result, Stop):
            self._error = self._error or StudyError(result.error)
        else:
            self._store.add_failure(spec, result)
            self._failed += 1
            if self._first is None:
                self._first = EpisodeError(f"{describe_episode(spec)} failed: {result.error}")
                self._first.trace = result.trace
            if self._options.fail_fast:
                self._error = self._error or self._first
        if self._options.on_episode and not isinstance(result, Stop):
            self._options.on_episode(spec, result if isinstance(result, Packed) else None)

    def _failures(self, tally: _Tally) -> EpisodeError | None:
        """The error that reports failed episodes; None without any."""
        first = self._first
        if first is None:
            return EpisodeError(failures_in_words(self._store, tally.lost, tally.total)) if tally.lost else None
        if self._failed == 1:
            return first
        error = EpisodeError(f"{self._failed} of {tally.total} episodes failed, the first: {first}")
        error.trace = first.trace
        return error


def failures_in_words(store: Store, number: int, total: int) -> str:
    """How many episodes failed earlier, with the reason of the first one in the store."""
    first = next(store.failures(), None)
    named = {} if first is None else {name: first[name] for name in ("id", "teacher", "student", "seed")}
    reason = "" if first is None else f", such as {named}: {first['error']}"
    return f"{number} of {total} episodes failed in an earlier run{reason}"


def asks_here(study: Study, students: Iterable[str]) -> bool:
    """Whether one of these students, or a teacher or the reader of the study, asks a model of this machine."""
    asking: list[Any] = [traits_of(parse_student(student))[0] for student in students]
    asking += [getattr(each, "wording", each) for each in speakers(study)]
    asking.append(parse_reader(study.reader))
    return any(isinstance(each, AsksModel) and is_local(each.settings.model) for each in asking)


def speakers(study: Study) -> Iterator[Speaker]:
    """The teachers of a study beside mere personalities."""
    for spec in dict.fromkeys((*study.teachers, *study.transfer.get("teachers", ()))):
        if isinstance(teacher := parse_teacher(spec), Speaker):
            yield teacher


def manifest(study: Study) -> dict[str, Any]:
    """The facts for repeating a study: its definition, and the versions of its software."""
    return {
        "study": study.as_dict(),
        "played": {family: list(each) for family, each in study.versions.items()},
        "students": {spec: facts for spec in study.students if (facts := parse_student(spec).facts())},
        "teachers": {f"{teacher}": facts for teacher in speakers(study) if (facts := teacher.facts())},
        **({"reader": reader.facts()} if isinstance(reader := parse_reader(study.reader), LLMReader) else {}),
        "own": facts_of(*((*getattr(study, name), *study.transfer.get(name, ())) for name in ("students", "teachers"))),
        "code": {name: dict(each.modules) for name, each in changes.used_code(study).items()},
        "versions": _versions(),
        "python": platform.python_version(),
        "platform": platform.platform(),
    }


def _versions() -> dict[str, str]:
    """Versions of this package and of its installed dependencies, except those for tests."""
    own = "llf-teacher"
    asked = [each for each in metadata.requires(own) or () if "test" not in each.partition(";")[2]]
    names = sorted({re.split(r"[^\w.-]", each, maxsplit=1)[0] for each in asked} - {own})
    versions = {}
    for name in (own, *names):
        with contextlib.suppress(metadata.PackageNotFoundError):
            versions[name] = metadata.version(name)
    return versions
