"""Playing the episodes of the suite: first a few of each kind, which measure the speed, then the others."""

import os
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.models.local.options import slots
from llf_teacher.studies import load
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution import changes
from llf_teacher.studies.execution.limits import Limits
from llf_teacher.studies.execution.runner import EpisodeError, RunOptions, StudyError, asks_here, play_missing
from llf_teacher.studies.execution.worker import Packed
from llf_teacher.studies.store import Store
from llf_teacher.suite.pace import Pace

Progress = Callable[[int, int, float], None]
"""Takes the number of completed episodes, their total, and the seconds that are left."""
Rows = Sequence[Mapping[str, Any]]


class SuitePlayer:
    """Plays what the store lacks; an episode that fails is played again by the next player only.

    Args:
        store: the file of the episodes.
        student: the spec of the student.
        workers: as in `llf_teacher.studies.run`.
        progress: called now and then; None: nobody is.
        turn_seconds: time limit of a turn; None: no limit.
        changed: what becomes of stored episodes whose student has changed, one of `changes.CHOICES`.
    """

    def __init__(
        self,
        store: Path | str,
        student: str,
        workers: int | None = None,
        progress: Progress | None = None,
        turn_seconds: float | None = None,
        changed: str = changes.STOP,
    ) -> None:
        self._changed = changed
        self._store, self._student, self._workers, self._progress = Path(store), student, workers, progress
        self._limits = Limits(turn_seconds=turn_seconds)
        self._failed: set[str] = set()
        self._todo: dict[str, EpisodeSpec] = {}
        self._total = 0
        self._shares = False
        """Whether episodes that are played at once share a model of this machine."""
        self.pace = Pace(workers or os.cpu_count() or 1)
        self.begun: set[str] = set()
        """Keys of the student's episodes that are in the store."""

    def begin(self, studies: Sequence[Study]) -> None:
        """Take the episodes of these studies as all that is to be played, for the progress.

        Raises:
            StoreError: the code of the student has changed since some of them were played, and a run is to stop then.
        """
        if self._store.exists():
            with Store(self._store) as store:
                for study in studies:
                    changes.settle(study, store, study.episodes, self._changed)
        specs = {spec.key: spec for study in studies for spec in study.episodes()}
        there = self._stored(specs)
        self._todo = {key: spec for key, spec in specs.items() if key not in there and key not in self._failed}
        self._total = len(specs)
        self._shares = any(asks_here(study, [self._student]) for study in studies[:1])
        if self._shares and self._workers is None:
            self.pace.parallel = slots()
        self.begun = {key for key in there if specs[key].student == self._student}
        for key, row in there.items():  # answers that were paid for say how long they took
            if row["seconds"] and not specs[key].lessons:
                self.pace.add(specs[key], row["seconds"], row["turns"])

    def missing(self, student: str) -> int:
        """Number of a student's episodes that are to be played."""
        return sum(spec.student == student for spec in self._todo.values())

    @property
    def seconds_left(self) -> float:
        """The seconds that the missing episodes will take, at the speed of those that were played."""
        return self.seconds_of(self._todo)

    def seconds_of(self, keys: Iterable[str]) -> float:
        """The same of those that have these keys."""
        return self.pace.left(self._todo[key] for key in keys if key in self._todo)

    def measure(self, studies: Sequence[Study]) -> None:
        """Play the first missing episodes of each kind whose speed is unknown.

        They are episodes of the suite: none is played for the measurement alone. Where they share a model of this
        machine, as many are played at once as later.
        """
        for study in studies:
            chosen: list[EpisodeSpec] = []
            for spec in study.episodes():
                at_once = self.pace.parallel if self._shares and spec.student == self._student else 1
                alike = sum((each.id, each.student) == (spec.id, spec.student) for each in chosen)
                if spec.key in self._todo and not self.pace.knows(spec) and alike < at_once:
                    chosen.append(spec)
            if chosen:
                self._play(study, {spec.key for spec in chosen})

    def play(self, studies: Iterable[Study]) -> None:
        """Play all missing episodes of studies."""
        for study in studies:
            self._play(study, {spec.key for spec in study.episodes()} - self._failed)

    def _play(self, study: Study, keys: set[str]) -> None:
        options = RunOptions(
            limits=self._limits, retry_failed=True, keys=keys, changed=self._changed, on_episode=self._ended
        )
        with Store(self._store) as store:
            try:
                play_missing(study, store, self._workers, self._show, options=options)
            except StudyError:
                raise
            except EpisodeError:
                pass  # `results` has the reasons

    def _ended(self, spec: EpisodeSpec, played: Packed | None) -> None:
        self._todo.pop(spec.key, None)
        if played is None:
            self._failed.add(spec.key)
            return
        cached = played.episode.seconds or 0.0  # the cache keeps how long an answer took
        self.pace.add(spec, max(played.seconds, cached), played.episode.turns)

    def _show(self, *_: int) -> None:
        if self._progress is not None:
            self._progress(self._total - len(self._todo), self._total, self.seconds_left)

    def results(self, studies: Iterable[Study]) -> tuple[Rows, Rows]:
        """The rows of the studies' episodes, and those of failures."""
        keys = {spec.key for study in studies for spec in study.episodes()}
        with load(self._store) as results:
            rows, lost = ([row for row in each if row["key"] in keys] for each in (results.rows(), results.failures()))
        if lost:
            number = f"{len(lost)} of {len(keys)} episodes failed"
            warnings.warn(f"{number}, the first: {lost[0]['error']}", RuntimeWarning, stacklevel=3)
        return rows, lost

    def _stored(self, specs: Mapping[str, EpisodeSpec]) -> dict[str, Mapping[str, Any]]:
        """The rows of these episodes in the store, by key."""
        if not self._store.exists() or not self._store.stat().st_size:
            return {}
        with load(self._store) as results:
            return {row["key"]: row for row in results.rows() if row["key"] in specs}
