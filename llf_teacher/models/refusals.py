"""Parameters that some endpoints do not take, and what to send in their place."""

import re
from collections.abc import Collection, Mapping
from typing import Any

SPARE: dict[str, str | None] = {
    "max_tokens": "max_completion_tokens",
    "max_completion_tokens": None,
    "temperature": None,
    "seed": None,
}
"""Parameters that a request can do without, each with what may stand for it."""
_NO = re.compile(r"unsupported|not support|unrecogni[sz]ed|unknown|unexpected|not permitted|not allowed|extra", re.I)
_CODES = ("unsupported_parameter", "unsupported_value", "unknown_parameter")
_STATUS = (400, 422)


def refused(status: int | None, error: Any, sent: Collection[str]) -> str | None:
    """The parameter that an endpoint refuses, of those that a request can do without; None if it has other troubles.

    Args:
        status: of the reply.
        error: the object `error` in the reply's body, or the whole body, or a text.
        sent: names of the parameters that were sent.
    """
    if status not in _STATUS:
        return None
    spare = [name for name in SPARE if name in sent]
    told = error if isinstance(error, Mapping) else {}
    if told.get("code") in _CODES and told.get("param") in spare:
        return f"{told['param']}"
    text = f"{told.get('message') or error}"
    if _NO.search(text) is None:
        return None
    named = [(at.start(), name) for name in spare if (at := re.search(rf"(?<![\w]){name}(?![\w])", text))]
    return min(named)[1] if named else None


def adapted(request: Mapping[str, Any], unsent: Collection[str]) -> dict[str, Any]:
    """A request as it is sent to an endpoint that refuses some parameters."""
    body = dict(request)
    for name, instead in SPARE.items():
        if name in unsent and name in body:
            value = body.pop(name)
            if instead is not None:
                body.setdefault(instead, value)
    return body
