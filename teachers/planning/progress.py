"""A progress bar for long planning."""

import sys
import time
from types import TracebackType
from typing import Any, Self

from teachers import terminal

_PATIENCE = 1.0  # seconds before it is shown


class ProgressBar:
    """Context that shows the done share of the found items, on standard error, if that is a terminal.

    Args:
        what: the task, such as "exploring".
        unit: the name of the items.
    """

    def __init__(self, what: str, unit: str) -> None:
        self._what, self._unit, self._begun = what, unit, time.monotonic()
        self._bar: Any = None

    def show(self, done: int, found: int) -> None:
        """Show both numbers; either may grow."""
        if self._bar is None and sys.stderr.isatty() and time.monotonic() - self._begun > _PATIENCE:
            from rich.progress import BarColumn, Progress, TextColumn

            what = TextColumn("{task.description}", markup=False)
            count = TextColumn(f"{{task.completed:,}} of {{task.total:,}} {self._unit} found so far", markup=False)
            self._bar = Progress(what, BarColumn(), count, console=terminal.error_console(), transient=True)
            self._bar.add_task(self._what)
            terminal.show(self._bar)
        if self._bar is not None:
            self._bar.update(self._bar.task_ids[0], completed=done, total=found)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            terminal.hide(self._bar)
