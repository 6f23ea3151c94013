"""The progress of a study: a bar on a terminal, a line per minute elsewhere."""

import time
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

_BAR_SECONDS = 0.1  # between updates of the bar on a terminal
_LINE_SECONDS = 60.0  # between lines in a file


def in_words(seconds: float) -> str:
    """A duration, rounded."""
    if seconds < 100:
        return f"{seconds:.0f} seconds"
    minutes = round(seconds / 60)
    return f"{minutes} minutes" if minutes < 100 else f"{minutes // 60} h {minutes % 60:02} min"


class StudyProgress:
    """Shows how many episodes are done, and nothing if the study cannot start.

    Args:
        console: the output.
        measured: whether the calls say the seconds left; if not, a bar shows what the speed of the episodes makes them.
    """

    def __init__(self, console: Console, measured: bool = False) -> None:
        self._console = console
        left = TextColumn("{task.fields[left]}", markup=False) if measured else TimeRemainingColumn()
        columns = BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), left
        self._bar = Progress(TextColumn("{task.description}", markup=False), *columns, console=console)
        self._task = self._bar.add_task("episodes", total=None, left="")
        self._began: float | None = None
        self._shown = (0.0, 0)

    def __call__(self, done: int, total: int, left: float | None = None) -> None:
        """Show the number of episodes that are done, of the total, and the seconds left, if they are known."""
        now = time.monotonic()
        terminal = self._console.is_terminal
        if self._began is None:
            self._began = now
            if terminal:
                self._bar.start()
        elif now - self._shown[0] < (_BAR_SECONDS if terminal else _LINE_SECONDS) and not (terminal and done == total):
            return
        elif not terminal:
            new, seconds = done - self._shown[1], now - self._shown[0]
            pace = f"{new / seconds:.3g} a second" if new else f"none in the last {seconds:.0f} s"
            pace += "" if left is None else f", {in_words(left)} left"
            self._console.print(
                f"{done:,} of {total:,} episodes after {now - self._began:.0f} s, {pace}", highlight=False
            )
        self._bar.update(self._task, completed=done, total=total, left="" if left is None else f"{in_words(left)} left")
        self._shown = now, done

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._began is not None and self._console.is_terminal:
            self._bar.stop()
