"""The worker: plays an episode and returns its result as a value, whatever the agent raises."""

import os
import random
import sysconfig
import time
import traceback
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from llf_teacher.episodes.failure import Failure, failure
from llf_teacher.episodes.record import EpisodeRow, EpisodeSpec, pack_turns
from llf_teacher.models import LLMError, NoAnswerError, SpendingLimitError
from llf_teacher.studies.execution.episode import close_lessons, play
from llf_teacher.studies.execution.executors import Process
from llf_teacher.studies.execution.limits import Clock, Limits, TimeIsUp, within_memory
from llf_teacher.studies.execution.shared_functions import put_back

_NAMED = 3  # greatest number of functions in a message
_OWN = [Path(__file__).parents[3] / name for name in ("llf_teacher", "pz_envs", "teachers", "worlds")]
_OWN.append(Path(sysconfig.get_path("stdlib")))


class Stop(NamedTuple):
    """Why the whole study cannot go on."""

    error: str


class Packed(NamedTuple):
    """An episode in the store's form."""

    episode: EpisodeRow
    turns: bytes
    seconds: float = 0.0
    """How long it was played."""


def set_up(environment: Mapping[str, str]) -> None:
    """Set up a playing process; a notebook's definitions may have changed since an earlier run in it."""
    os.environ.update(environment)
    close_lessons()


def run_episode(spec: EpisodeSpec, limits: Limits = Limits()) -> Packed | Failure | Stop:  # noqa: B008 (immutable)
    """Play an episode and pack its turns. Global generators are seeded, for agents that use them.

    An episode fails if its agent replaces a function that its world may use: the world would not be that of the seed.
    """
    put_back()
    result = _run_episode(spec, limits)
    if replaced := put_back():
        Process.spoiled = True
        names, by = ", ".join([*replaced][:_NAMED]), next(iter(replaced.values()))
        return failure(
            "raised",
            f"{names} was replaced during the episode (by {by}), by which worlds and other students draw and compute, "
            "too; an agent must leave it as it is, and may have a generator of its own. A library that replaces such "
            "functions for good, as by patching a module when it is imported, fails every episode of its agent: turn "
            "its patches off, or run it in a process of its own that the agent asks",
        )
    return result


def _run_episode(spec: EpisodeSpec, limits: Limits) -> Packed | Failure | Stop:
    clock = Clock(limits)
    seed = int(spec.key, 16)
    random.seed(seed)
    np.random.seed(seed % 2**32)  # noqa: NPY002 (agents of the user's own may use it)
    began = time.monotonic()
    try:
        with within_memory(limits.memory), clock.running():
            record = play(spec, clock.turn)
        return Packed(record.episode, pack_turns(record.turns), time.monotonic() - began)
    except NoAnswerError as error:
        return failure("raised", f"{error}")
    except LLMError as error:
        return Stop(
            f"{error}" if isinstance(error, SpendingLimitError) else f"{describe_episode(spec)} failed: {error}"
        )
    except TimeIsUp as error:
        clock.stop()
        Process.spoiled = True
        return failure("time", f"{error}{_place(error)}", traceback.format_exc())
    except MemoryError as error:
        Process.spoiled = True
        most = "" if limits.memory is None else f"of {limits.memory} MB "
        return failure("memory", f"no memory {most}is left: {_repr(error)}", traceback.format_exc())
    except BaseException as error:  # an agent may raise anything
        if isinstance(error, KeyboardInterrupt) and not Process.owned:
            raise
        return failure("raised", f"{_repr(error)}{_place(error)}", traceback.format_exc())


def describe_episode(spec: EpisodeSpec) -> str:
    """An episode as text, for messages."""
    return f"episode {spec._asdict()}"


def _repr(error: BaseException) -> str:
    try:
        return repr(error)
    except Exception:  # its own `__repr__` may raise
        return type(error).__name__


def _place(error: BaseException) -> str:
    """The last line of foreign code in an error's traceback, such as ` (my_agent.py, line 7)`; empty without one."""
    frames = [each for each in traceback.extract_tb(error.__traceback__) if each.filename != "<string>"]  # no file
    files = [(Path(frame.filename), frame.lineno) for frame in frames]
    others = [f" ({file.name}, line {line})" for file, line in files if not any(map(file.is_relative_to, _OWN))]
    return others[-1] if others else ""
