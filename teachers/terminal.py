"""Progress of long work on standard error, if that is a terminal."""

import sys
from types import TracebackType
from typing import TYPE_CHECKING, Any, Protocol, Self

if TYPE_CHECKING:
    from rich.console import Console

__all__ = ["Waiting", "error_console", "hide", "show"]


class _Display(Protocol):
    """A live display of rich."""

    def start(self) -> None: ...
    def stop(self) -> None: ...


_shown: list[_Display] = []  # only the last one is on the terminal, until it is hidden


def show(display: _Display) -> None:
    """Start a display in place of the current one."""
    if _shown:
        _shown[-1].stop()
    _shown.append(display)
    display.start()


def hide(display: _Display) -> None:
    """Stop a display and resume the one before."""
    if _shown and _shown[-1] is display:
        _shown.pop().stop()
        if _shown:
            _shown[-1].start()


def error_console() -> "Console":
    """A console on standard error that prints names such as `gym:cat:Cat-v0` unchanged."""
    from rich.console import Console

    return Console(stderr=True, emoji=False, markup=False, highlight=False)


class Waiting:
    """Context that shows a spinner and the current task, if standard error is a terminal.

    Args:
        what: the task, such as "Preparing llf-gridworld-v0".
    """

    def __init__(self, what: str = "") -> None:
        self._what = what
        self._status: Any = None

    def say(self, what: str) -> None:
        """Show another task."""
        from rich.text import Text

        self._what = what
        if self._status is not None:
            self._status.update(Text(what))  # a string would be read as markup, with emoji

    def __enter__(self) -> Self:
        if sys.stderr.isatty():
            from rich.text import Text

            self._status = error_console().status(Text(self._what))
            show(self._status)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._status is not None:
            hide(self._status)
            self._status = None
