"""JSON in what models and people write; an object with a key twice and constants such as NaN are refused."""

import json
import math
import re
from contextlib import suppress
from itertools import islice
from typing import Any, NoReturn

from teachers.schema import MOST_CLAIMS

__all__ = ["find_message", "finite_value", "lenient_value", "unique_keys"]


def unique_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """The `object_pairs_hook` of `json` that refuses an object in which a key occurs twice."""
    if len(found := dict(pairs)) < len(pairs):
        raise ValueError(f"each key must occur once, got {', '.join(key for key, _ in pairs):.80}")
    return found


def finite_value(text: str) -> Any:
    """The value of a text that is JSON as a whole.

    Raises:
        ValueError, RecursionError: the text is not JSON, or has a key twice or a number that is not finite.
    """
    return json.loads(text, object_pairs_hook=unique_keys, parse_float=_finite, parse_constant=_refuse)


def lenient_value(text: str) -> Any:
    """The value of JSON, also with single quotes, in round brackets or with a comma too many; None: it is no JSON."""
    if text[:1] + text[-1:] == "()":
        text = f"[{text[1:-1]}]"
    requoted = _STRING.sub(lambda found: _requoted(found[0]), text)
    for form in (text, requoted, _EXTRA.sub(lambda found: found["string"] or "", requoted)):
        with suppress(ValueError, RecursionError):
            return finite_value(form)
    return None


def _requoted(string: str) -> str:
    """A string in single or double quotes, in double quotes."""
    if string[0] == '"':
        return string
    inner = string[1:-1] if len(string) > 1 and string[-1] == "'" else string[1:]
    return '"' + inner.replace("\\'", "'").replace('"', '\\"') + '"'


def find_message(text: str) -> Any:
    """The first JSON object in a text that has claims, or the only object; other words may stand around it. Else None.

    Time and memory are linear in the text's length: the first `MOST_CLAIMS` braces are tried.
    """
    for brace in islice(_OBJECT.finditer(text), MOST_CLAIMS):
        try:
            found, end = _DECODER.raw_decode(text, brace.start())
        except (ValueError, RecursionError):
            continue
        if "claims" in found or (brace.start(), end) == (text.find("{"), text.rfind("}") + 1):
            return found
    return None


def _finite(digits: str) -> float:
    number = float(digits)
    return number if math.isfinite(number) else _refuse(digits)


def _refuse(name: str) -> NoReturn:
    raise ValueError(f"{name} is no finite number")


_STRING = re.compile(r"\"(?:[^\"\\]|\\.)*+(?:\"|$)|'(?:[^'\\]|\\.)*+(?:'|$)", re.DOTALL)
_EXTRA = re.compile(rf"(?P<string>{_STRING.pattern})|,(?=\s*+[\]}}])", re.DOTALL)
_OBJECT = re.compile(r'\{(?=\s*["}])')
_DECODER = json.JSONDecoder(object_pairs_hook=unique_keys, parse_constant=_refuse)  # `Vocabulary` refuses 1e999
