"""Why there is nothing of an episode, as text that can be stored."""

from typing import NamedTuple

REASONS = ("raised", "time", "memory", "died")
"""Why episodes fail: the agent raised, took too long, took too much memory, or its process is gone."""
_LONGEST = 2_000, 20_000  # characters of a failure's message and traceback


class Failure(NamedTuple):
    """Why there is nothing of an episode, as text: not every exception survives the way between processes."""

    reason: str
    """One of `REASONS`."""
    error: str
    trace: str = ""
    """The traceback in the process that played, where the error is not plain from its message."""


def failure(reason: str, error: str, trace: str = "") -> Failure:
    """A failure with texts that can be stored: of bounded length, without halves of characters."""
    longest, longest_trace = _LONGEST
    error, trace = (text.encode("utf-8", "replace").decode() for text in (error, trace))
    return Failure(
        reason,
        error if len(error) <= longest else error[: longest - 3] + "...",
        trace if len(trace) <= longest_trace else "..." + trace[3 - longest_trace :],
    )
