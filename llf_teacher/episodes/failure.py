"""Why an episode failed, as text that can be stored."""

from typing import NamedTuple

from teachers.schema import storable

REASONS = ("raised", "time", "memory", "died")
"""The agent raised an error, took too long, took too much memory, or its process ended."""
_LONGEST = 2_000, 20_000  # characters of a failure's message and traceback


class Failure(NamedTuple):
    """Why an episode failed, as text, since not every exception can be pickled."""

    reason: str
    """One of `REASONS`."""
    error: str
    trace: str = ""
    """The traceback in the process that played; empty if the message is enough."""


def failure(reason: str, error: str, trace: str = "") -> Failure:
    """A failure whose texts can be stored: of bounded length, without lone surrogates."""
    longest, longest_trace = _LONGEST
    error, trace = storable(error), storable(trace)
    return Failure(
        reason,
        error if len(error) <= longest else error[: longest - 3] + "...",
        trace if len(trace) <= longest_trace else "..." + trace[3 - longest_trace :],
    )
