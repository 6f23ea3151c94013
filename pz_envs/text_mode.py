"""Text in: a strict grammar for actions written as text. Nothing is ever executed.

An answer is what the world itself reads as an action (`World.read`: its words for actions), or JSON: a number, a string
with such a word, a list (round brackets will do), an object whose only key is `action`, or, where actions are dicts, an
object with their keys. If the text has the marker
`Response:`, the answer is what follows its last occurrence. Where the world's action is itself a text, the answer is
that text.
"""

import json
import math
import re
from typing import Any, NoReturn

from gymnasium import spaces

from teachers.atoms import ParseFailure
from worlds.world import World

_MARKER = re.compile("response:", re.IGNORECASE)
_LONGEST = 1000  # characters of an answer that is not itself a text
_EXCERPT = 80


def parse_action(text: str, world: World[Any]) -> Any:
    """The action that a text stands for, in canonical form, or a `ParseFailure`."""
    start = 0
    for marker in _MARKER.finditer(text):
        start = marker.end()
    answer = text[start:].strip()
    if isinstance(world.action_space, spaces.Text):
        return legal_text(answer, world)
    if len(answer) > _LONGEST:
        return failure(text, world)
    try:
        action = world.read(answer)
        return world.legal(_value(answer, world) if action is None else action)
    except (ValueError, TypeError, OverflowError, RecursionError):
        return failure(text, world)


def legal_text(text: str, world: World[Any]) -> Any:
    """The text as an action of a world whose actions are texts, or a `ParseFailure`."""
    try:
        return world.legal(text)
    except ValueError:
        return failure(text, world)


def failure(text: str, world: World[Any]) -> ParseFailure:
    """The failure to read a text, with a printable excerpt."""
    excerpt = text[:_EXCERPT] if len(text) <= _EXCERPT else text[: _EXCERPT - 3] + "..."
    return ParseFailure("".join(c if c.isprintable() else " " for c in excerpt), world.action_syntax)


def _value(answer: str, world: World[Any]) -> Any:
    if answer.startswith("(") and answer.endswith(")"):
        answer = f"[{answer[1:-1]}]"
    value = json.loads(answer, object_pairs_hook=_object, parse_float=_finite, parse_constant=_refuse)
    space = world.action_space
    keys = space.spaces.keys() if isinstance(space, spaces.Dict) else ()
    if isinstance(value, dict) and list(value) == ["action"] and "action" not in keys:
        value = value["action"]
    if isinstance(value, dict) and not keys:
        raise ValueError("the only key of an object must be `action`")
    if isinstance(value, str):
        action = world.read(value)
        return value if action is None else action
    if _has_truth_value(value):
        raise ValueError("a truth value is no action")
    return value


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    value = dict(pairs)
    if len(value) < len(pairs):
        raise ValueError("a key comes twice")
    return value


def _finite(digits: str) -> float:
    number = float(digits)
    return number if math.isfinite(number) else _refuse(digits)


def _refuse(name: str) -> NoReturn:
    raise ValueError(f"{name} is no finite number")


def _has_truth_value(value: Any) -> bool:
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return isinstance(value, bool) or any(map(_has_truth_value, parts))
