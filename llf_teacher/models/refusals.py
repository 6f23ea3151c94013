"""Parameters that some endpoints do not accept, and their replacements."""

import re
from collections.abc import Collection, Mapping
from typing import Any

SPARE: dict[str, str | None] = {
    "max_tokens": "max_completion_tokens",
    "max_completion_tokens": None,
    "temperature": None,
    "seed": None,
    "stop": None,
}
"""Parameters that a request does not need, each with its replacement, if any."""
_NO = re.compile(r"unsupported|not support|unrecogni[sz]ed|unknown|unexpected|not permitted|not allowed|extra", re.I)
_CODES = ("unsupported_parameter", "unsupported_value", "unknown_parameter")
_STATUS = (400, 422)


def refused(status: int | None, error: Any, sent: Collection[str]) -> str | None:
    """The parameter of `SPARE` that an endpoint refuses; None if the error has another reason.

    Args:
        status: the reply's status.
        error: the object `error` in the reply's body, or the whole body, or a text.
        sent: names of the parameters in the request.
    """
    if status not in _STATUS:
        return None
    spare = [name for name in SPARE if name in sent]
    details = error if isinstance(error, Mapping) else {}
    if details.get("code") in _CODES and details.get("param") in spare:
        return f"{details['param']}"
    text = f"{details.get('message') or error}"
    if _NO.search(text) is None:
        return None
    named = [(at.start(), name) for name in spare if (at := re.search(rf"(?<![\w]){name}(?![\w])", text))]
    return min(named)[1] if named else None


def adapted(request: Mapping[str, Any], unsent: Collection[str]) -> dict[str, Any]:
    """A request without the parameters that an endpoint refuses, or with their replacements."""
    body = dict(request)
    for name, instead in SPARE.items():
        if name in unsent and name in body:
            value = body.pop(name)
            if instead is not None:
                body.setdefault(instead, value)
    return body
