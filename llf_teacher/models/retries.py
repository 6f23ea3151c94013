"""Transient errors, and the pause before a request is sent again.

The `openai` client can retry by itself, but does not count its requests, and its retries would multiply with these.
"""

import email.utils
import math
import random
import time
from collections.abc import Mapping
from datetime import UTC

from llf_teacher.models import LLMError

_PASSING = (408, 409, 429)  # and all statuses from 500
_FIRST, _LONGEST, _MOST = 0.5, 8.0, 120.0  # seconds: the first pause, the longest, the longest on request
_JITTER = 0.25  # random share of a pause, so that many clients do not retry at once
_chance = random.SystemRandom()  # no episode depends on it


class PassingError(LLMError):
    """An attempt failed with a transient error.

    Args:
        problem: the error.
        seconds: the pause that the endpoint asks for; None: it asks for none.
        lost: whether the reply is missing, so that the charge is unknown.
    """

    def __init__(self, problem: str, seconds: float | None = None, lost: bool = False) -> None:
        super().__init__(problem)
        self.seconds, self.lost = seconds, lost


def may_pass(status: int, headers: Mapping[str, str]) -> bool:
    """Whether an error is transient, without a request for a long pause."""
    if (wait := asked_for(headers)) is not None and wait > _MOST:
        return False
    if (said := headers.get("x-should-retry")) in ("true", "false"):
        return said == "true"
    return status in _PASSING or status >= 500


def asked_for(headers: Mapping[str, str]) -> float | None:
    """The pause that an endpoint asks for, in seconds, from a number or a date; None: it asks for none."""
    for name, unit in (("retry-after-ms", 1000.0), ("retry-after", 1.0)):
        try:
            seconds = float(headers[name]) / unit
        except (KeyError, ValueError):
            continue
        return None if math.isnan(seconds) else max(0.0, seconds)
    until, now = _date(headers.get("retry-after", "")), _date(headers.get("date", ""))
    # The endpoint's clock, if it says what it shows: that of this machine may be wrong.
    return None if until is None else max(0.0, until - (time.time() if now is None else now))


def _date(text: str) -> float | None:
    """A date of HTTP, in seconds since 1970; None if it is none. One without a zone, or of -0000, is in UTC."""
    try:
        date = email.utils.parsedate_to_datetime(text)
        return (date if date.tzinfo else date.replace(tzinfo=UTC)).timestamp()
    except (ValueError, TypeError, OverflowError, OSError):
        return None


def pause(attempt: int, seconds: float | None) -> float:
    """Seconds before the next attempt.

    Args:
        attempt: number of the failed attempt, from 0.
        seconds: the pause that the endpoint asks for.
    """
    if seconds:
        return seconds
    return min(_FIRST * 2.0 ** min(attempt, 10), _LONGEST) * (1.0 - _JITTER * _chance.random())
