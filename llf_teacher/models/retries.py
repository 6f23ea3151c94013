"""Troubles that may pass, and how long to wait before a request is sent again.

The client could try again by itself, but keeps no count of what it sends, and its attempts would multiply with ours.
"""

import email.utils
import math
import random
import time
from collections.abc import Mapping

from llf_teacher.models import LLMError

_PASSING = (408, 409, 429)  # and all from 500 on
_FIRST, _LONGEST, _MOST = 0.5, 8.0, 120.0  # seconds: the first pause, the longest, the longest that is asked for
_JITTER = 0.25  # share of a pause that is left to chance, so that many do not come back at once
_chance = random.SystemRandom()  # no episode depends on it


class PassingError(LLMError):
    """An attempt gave no answer; another one may.

    Args:
        problem: what was wrong.
        seconds: how long the endpoint asks to wait; None: it does not say.
        lost: whether there was no reply at all, so that nobody knows what was charged.
    """

    def __init__(self, problem: str, seconds: float | None = None, lost: bool = False) -> None:
        super().__init__(problem)
        self.seconds, self.lost = seconds, lost


def may_pass(status: int, headers: Mapping[str, str]) -> bool:
    """Whether what was refused with a status may be granted later, and not much later."""
    if (wait := asked_for(headers)) is not None and wait > _MOST:
        return False
    if (said := headers.get("x-should-retry")) in ("true", "false"):
        return said == "true"
    return status in _PASSING or status >= 500


def asked_for(headers: Mapping[str, str]) -> float | None:
    """The seconds that an endpoint asks to wait, as a number or as a date; None: it does not say."""
    for name, unit in (("retry-after-ms", 1000.0), ("retry-after", 1.0)):
        try:
            seconds = float(headers[name]) / unit
        except (KeyError, ValueError):
            continue
        return None if math.isnan(seconds) else max(0.0, seconds)
    try:
        date = email.utils.parsedate_to_datetime(headers["retry-after"])
        return max(0.0, date.timestamp() - time.time())
    except (KeyError, ValueError, TypeError, OverflowError, OSError):
        return None


def pause(attempt: int, seconds: float | None) -> float:
    """Seconds before the next attempt.

    Args:
        attempt: number of the one that failed, from 0.
        seconds: what the endpoint asks for.
    """
    if seconds:
        return seconds
    return min(_FIRST * 2.0 ** min(attempt, 10), _LONGEST) * (1.0 - _JITTER * _chance.random())
