"""The runner: plays what a store lacks of a study, in parallel processes."""

import contextlib
import multiprocessing
import os
import platform
import random
import re
import threading
import traceback
from collections.abc import Callable, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from importlib import metadata
from typing import Any, NamedTuple

import numpy as np

from llf_teacher.models import LLMError, SpendingLimitError
from llf_teacher.models.cache import spending
from llf_teacher.models.settings import CACHE
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies.episode import EpisodeRow, pack_turns, play
from llf_teacher.studies.store import Store
from llf_teacher.studies.study import EpisodeSpec, Study

_AHEAD = 8  # episodes under way per worker: enough to keep them busy, few to lose


class Failure(NamedTuple):
    """Why an episode could not be played, as text: not every exception survives the way between processes."""

    error: str
    trace: str
    """The traceback, where the error is not plain from its message."""
    of_episode: bool = True
    """Whether it has to do with this episode."""


class EpisodeError(RuntimeError):
    """An episode failed. What was played before and beside it is stored."""

    trace: str = ""
    """The traceback in the process that played, if it tells more than the message."""


def run(
    study: Study,
    store: Store,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    environment: Mapping[str, str] | None = None,
) -> int:
    """Play and store every episode of the study that the store lacks.

    Args:
        study: what to play.
        store: where episodes go, each as it ends.
        workers: number of processes, each of which plays one episode at a time; None: one a core.
        progress: called with the number of stored episodes and of all.
        environment: environment variables for the workers, such as `LLF_LLM_BUDGET`, beside those of this process.

    Returns:
        The number of episodes that were played.

    Raises:
        EpisodeError: an episode failed; what was played is stored.
        ValueError, ModuleNotFoundError: a student cannot play here, or the store is damaged; nothing was played.
    """
    specs = list(study.episodes())
    store.check()
    there = store.keys()
    todo = [spec for spec in specs if spec.key not in there]
    done = len(specs) - len(todo)
    report = progress or (lambda *_: None)
    cache = os.environ.get(CACHE) or f"{store.path.absolute().with_suffix('.llm.db')}"
    environment = {CACHE: cache, **(environment or {})}
    for student in dict.fromkeys(spec.student for spec in todo):
        parse_student(student).check(os.environ | environment)
    report(done, len(specs))
    store.write_manifest(manifest(study))
    if not todo:
        return 0
    workers = min(workers or os.cpu_count() or 1, len(todo))
    # Spawned processes start from a clean interpreter, the same on every platform.
    context = multiprocessing.get_context("spawn")
    failed: EpisodeError | None = None
    with ProcessPoolExecutor(workers, mp_context=context, initializer=_begin, initargs=(environment,)) as pool:
        queue = iter(todo)
        pending: dict[Future[tuple[EpisodeRow, bytes] | Failure], EpisodeSpec] = {}
        try:
            while True:
                for spec in queue if failed is None else ():
                    pending[pool.submit(_attempt, spec)] = spec
                    if len(pending) >= workers * _AHEAD:
                        break
                if not pending:
                    break
                for future in wait(pending, return_when=FIRST_COMPLETED).done:
                    spec = pending.pop(future)
                    try:
                        result = future.result()
                    except BrokenProcessPool as error:
                        result = Failure(f"a process that plays died: {error}", "")
                    if isinstance(result, Failure):
                        if failed is None:
                            where = f"episode {spec._asdict()} failed: " if result.of_episode else ""
                            failed = EpisodeError(f"{where}{result.error}")
                            failed.trace = result.trace
                    else:
                        store.add_packed(spec, *result)
                        done += 1
                        report(done, len(specs))
                if failed is not None:  # play no more, but keep what is being played
                    pending = {future: spec for future, spec in pending.items() if not future.cancel()}
        finally:
            pool.shutdown(cancel_futures=True)
            if spent := spending(environment[CACHE]):
                store.write_manifest({"llm": spent})
    if failed is not None:
        raise failed
    return len(todo)


def _attempt(spec: EpisodeSpec) -> tuple[EpisodeRow, bytes] | Failure:
    """Play an episode and pack its turns, in a worker, whose global generators are seeded for agents that use them."""
    seed = int(spec.key, 16)
    random.seed(seed)
    np.random.seed(seed % 2**32)  # noqa: NPY002 (agents of the user's own may use it)
    try:
        record = play(spec)
        return record.episode, pack_turns(record.turns)
    except LLMError as error:
        return Failure(f"{error}", "", of_episode=not isinstance(error, SpendingLimitError))
    except (Exception, SystemExit) as error:  # an agent may raise anything
        return Failure(f"{error!r}", traceback.format_exc())


def manifest(study: Study) -> dict[str, Any]:
    """What is needed to repeat a study: its definition, and versions of what it ran on."""
    return {
        "study": study.as_dict(),
        "students": {spec: facts for spec in study.students if (facts := parse_student(spec).facts())},
        "versions": _versions(),
        "python": platform.python_version(),
        "platform": platform.platform(),
    }


def _versions() -> dict[str, str]:
    """Of this package and of what it asks for, tests aside, as far as it is installed."""
    own = "llf-teacher"
    asked = [each for each in metadata.requires(own) or () if "test" not in each.partition(";")[2]]
    names = sorted({re.split(r"[^\w.-]", each, maxsplit=1)[0] for each in asked} - {own})
    versions = {}
    for name in (own, *names):
        with contextlib.suppress(metadata.PackageNotFoundError):
            versions[name] = metadata.version(name)
    return versions


def _begin(environment: Mapping[str, str]) -> None:
    """Set up a worker. It ends when its parent is gone, even if that was killed."""
    os.environ.update(environment)
    parent = multiprocessing.parent_process()

    def watch() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
