"""Options of a model's server. They come from the environment: what a model answers does not depend on them."""

import os
from collections.abc import Mapping
from typing import NamedTuple

SLOTS, CONTEXT, THREADS = "LLF_LOCAL_SLOTS", "LLF_LOCAL_CONTEXT", "LLF_LOCAL_THREADS"
_LONGEST, _MOST_SLOTS, _MOST_THREADS = 1_000_000, 256, 1024
_SLOTS, _CONTEXT, _THREADS = 2, 8192, 8  # by default, where cores and model allow it
_SHORTEST = 256


class ServerOptions(NamedTuple):
    """How a model is served."""

    slots: int
    """Number of conversations that are answered at once; others wait."""
    context: int
    """Tokens of a conversation, the answer included."""
    threads: int
    """Number of cores that compute."""

    @classmethod
    def read(cls, longest: int, environment: Mapping[str, str] = os.environ) -> "ServerOptions":
        """The options of the environment, or the defaults.

        Args:
            longest: context that the model was trained for; 0: unknown.
            environment: the variables.

        Raises:
            ValueError: one is not allowed.
        """
        return cls(
            slots=slots(environment),
            context=_given(CONTEXT, _SHORTEST, longest or _LONGEST, environment) or min(longest or _CONTEXT, _CONTEXT),
            threads=_given(THREADS, 1, _MOST_THREADS, environment) or min(cores(), _THREADS),
        )


def slots(environment: Mapping[str, str] = os.environ) -> int:
    """Number of conversations that a model answers at once.

    Raises:
        ValueError: the variable is no such number.
    """
    return _given(SLOTS, 1, _MOST_SLOTS, environment) or _SLOTS


def given(environment: Mapping[str, str] = os.environ) -> dict[str, str]:
    """The options that the environment sets: field and variable."""
    names = {"slots": SLOTS, "context": CONTEXT, "threads": THREADS}
    return {field: name for field, name in names.items() if environment.get(name)}


def cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _given(name: str, least: int, most: int, environment: Mapping[str, str]) -> int:
    """The number in a variable; 0 if it is not set."""
    text = environment.get(name)
    if not text:
        return 0
    if not text.isascii() or not text.isdigit() or not least <= int(text) <= most:
        own = ", the longest context of the model" if name == CONTEXT and most < _LONGEST else ""
        raise ValueError(f"{name} must be a whole number of {least} to {most}{own}, got {text!r}")
    return int(text)
