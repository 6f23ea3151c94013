"""What long work shows on standard error, if that is a terminal."""

import sys
from types import TracebackType
from typing import TYPE_CHECKING, Any, Protocol, Self

if TYPE_CHECKING:
    from rich.console import Console

__all__ = ["Waiting", "error_console", "hide", "show"]


class _Display(Protocol):
    """A display of rich."""

    def start(self) -> None: ...
    def stop(self) -> None: ...


_shown: list[_Display] = []  # only the last one is on the terminal, until it is hidden


def show(display: _Display) -> None:
    """Start a display in place of the one that is on the terminal."""
    if _shown:
        _shown[-1].stop()
    _shown.append(display)
    display.start()


def hide(display: _Display) -> None:
    """Stop a display; the one that it took the place of goes on."""
    if _shown and _shown[-1] is display:
        _shown.pop().stop()
        if _shown:
            _shown[-1].start()


def error_console() -> "Console":
    """Standard error, on which names such as `gym:cat:Cat-v0` stay as they are."""
    from rich.console import Console

    return Console(stderr=True, emoji=False, markup=False, highlight=False)


class Waiting:
    """Says what takes long, beside something that moves, if standard error is a terminal. It is a context.

    Args:
        what: what is being done, such as "Preparing llf-gridworld-v0".
    """

    def __init__(self, what: str = "") -> None:
        self._what = what
        self._status: Any = None

    def say(self, what: str) -> None:
        """Say what is done now."""
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
