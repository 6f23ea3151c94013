"""Films of episodes, made in another process, so that the page keeps answering."""

import multiprocessing
import tempfile
from collections.abc import Sequence
from concurrent.futures import Future
from pathlib import Path

from pebble import ProcessPool

from llf_teacher.episodes.live import Input
from llf_teacher.tools.film import save
from llf_teacher.web.lesson import frames
from llf_teacher.web.plan import Plan


class Films:
    """Makes films, one after the other; the process starts with the first."""

    def __init__(self) -> None:
        self._pool: ProcessPool | None = None

    def begin(self, plan: Plan, inputs: Sequence[Input]) -> "Future[bytes]":
        """A future for the film of a lesson as a GIF; cancel it to give the film up."""
        if self._pool is None:
            self._pool = ProcessPool(1, context=multiprocessing.get_context("spawn"))
        made: Future[bytes] = self._pool.schedule(as_gif, args=(plan, list(inputs)))
        return made

    def close(self) -> None:
        """End the process; an unfinished film is given up."""
        if self._pool is not None:
            self._pool.stop()  # type: ignore[no-untyped-call]  # some of the package's functions have no types
            self._pool.join()


def as_gif(plan: Plan, inputs: Sequence[Input]) -> bytes:
    """Play a lesson again, and film it; no file stays."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.gif"
        save(frames(plan, inputs), path)
        return path.read_bytes()
