"""Formats in which a request asks a chat model for an answer: example, schema, and the action in an answer."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces

from pz_envs.text.json_values import unique_keys
from pz_envs.text.number_patterns import number_pattern
from worlds.world import World

ANSWERS = ("text", "json", "tool")
"""The formats: text behind `Response:`, a JSON object, a call of the tool `act`."""
THOUGHT = 200
"""Greatest number of characters of a thought before an action, by default."""
_THOUGHT = "I have not tried this yet, and want to see what it does."
_LINES = 3  # of an example
_ITEM = 100  # characters of a line of verse, or of a title, in a list
_TEXT = 500  # characters of any other text
_NUMBER = 12  # characters of a number
_FORM = 40  # tokens around the thought and the action
_READ = 2  # characters of plain words in a token, at least


def example(answer: str, action: str) -> str:
    """An example of an answer.

    Args:
        answer: the format.
        action: an action from `written`.
    """
    if answer == "text":
        return f"Thought: {_THOUGHT}\nResponse: {action}"
    return json.dumps({"thought": _THOUGHT, "action": _value(action)}, ensure_ascii=False)


def answer_of(answer: str, action: str) -> str:
    """An answer with an action and no thought."""
    return action if answer == "text" else json.dumps({"action": _value(action)}, ensure_ascii=False)


def written(world: World[Any], rng: np.random.Generator) -> str:
    """A random action as text, in the world's words if it has some."""
    action = world.sample_action(rng)
    return "\n".join(action.splitlines()[:_LINES]) if isinstance(action, str) else worded(world, action)


def worded(world: World[Any], action: Any) -> str:
    """An action as text, in the world's words if it has some."""
    if isinstance(action, str):
        return action
    legal = world.legal(action)
    words = next((word for word, meant in world.action_words.items() if meant == legal), None)
    if words is not None:
        return words
    text = json.dumps(action, default=_plain)
    short = json.dumps(json.loads(text, parse_float=lambda digits: float(f"{float(digits):.3g}")))
    try:
        world.legal(json.loads(short))
    except ValueError:  # rounded, it is outside the space
        return text
    return short


def schema(world: World[Any] | None, listed: Sequence[str] = (), thought: int = THOUGHT) -> dict[str, Any]:
    """The JSON Schema of an answer: a short thought, and an action that the world takes.

    A box is a text with a pattern, as in "[0.5, -1]", since grammars of some endpoints ignore the bounds of numbers.

    Args:
        world: the world; None: any action.
        listed: the commands that the world lists in this turn; empty: none are listed.
        thought: greatest number of characters of the thought; 0: no thought.
    """
    first = {"thought": {"type": "string", "maxLength": thought}} if thought else {}
    properties = first | {"action": {} if world is None else _schema_of(world, listed)}
    return {"type": "object", "properties": properties, "required": [*properties], "additionalProperties": False}


def longest_answer(world: World[Any], answer: str, thought: int = THOUGHT) -> int:
    """A limit of tokens that leaves room for the thought and the longest action.

    A schema ends an answer by itself, so that its limit is generous: a token for each character. A text that goes on
    ends at this limit.
    """
    space = world.action_space
    if world.action_words or isinstance(space, spaces.Discrete):
        most = max(map(len, [*world.action_words, f"{_NUMBER * ' '}"]))
    elif world.text_items:
        most = world.text_items[1] * (_ITEM + 4)
    elif isinstance(space, spaces.Box):
        most = _NUMBER * int(np.prod(space.shape))
    else:
        most = _TEXT
    return _FORM + ((thought + most) // _READ if answer == "text" else thought + most)


def request_fields(
    answer: str, world: World[Any] | None, listed: Sequence[str] = (), thought: int = THOUGHT
) -> dict[str, Any]:
    """The fields of a request's body that ask for a format; `listed` and `thought` as for `schema`."""
    if answer == "text":
        return {}
    return form_fields(answer, "act", "Take one action.", schema(world, listed, thought))


def form_fields(answer: str, name: str, description: str, schema: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of a request's body that ask for JSON of a schema, as an answer or as the call of a tool."""
    if answer == "json":
        return {"response_format": {"type": "json_schema", "json_schema": {"name": name, "schema": schema}}}
    called = {"name": name, "description": description, "parameters": schema}
    return {
        "tools": [{"type": "function", "function": called}],
        "tool_choice": "required",  # some endpoints refuse a tool's name here
    }


def action_in(answer: str, text: str, world: World[Any] | None = None) -> tuple[str, str]:
    """The action in an answer, as text, and the thought beside it.

    A text of another format than `answer` is returned whole; `actions.read_text` decides whether it is an action. A
    JSON object that is cut off holds no action: it is empty.
    """
    if answer == "text":
        return text, ""
    try:
        value = json.loads(text, object_pairs_hook=unique_keys)
    except (ValueError, RecursionError):
        return "" if text.lstrip().startswith("{") else text, ""
    if not isinstance(value, dict) or "action" not in value:
        return text, ""
    action, thought = value["action"], value.get("thought")
    if world is not None and world.several_lines and _texts(action):
        said = "\n".join(action)
    else:
        said = action if isinstance(action, str) else json.dumps(action, ensure_ascii=False)
    return said, thought if isinstance(thought, str) else ""


def _value(action: str) -> Any:
    """A written action in JSON: a number or a list of numbers as such, all else as text."""
    try:
        value = json.loads(action)
    except ValueError:
        return action
    return action if isinstance(value, list) and any(isinstance(item, str) for item in value) else value


def _texts(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(each, str) for each in value)


def _schema_of(world: World[Any], listed: Sequence[str]) -> dict[str, Any]:
    """The schema of an action."""
    if listed:
        return {"enum": list(listed)}
    if world.action_words:
        return {"enum": list(world.action_words)}
    if world.text_items:
        least, most = world.text_items
        return {
            "type": "array",
            "items": {"type": "string", "minLength": 1, "maxLength": _ITEM},
            "minItems": least,
            "maxItems": most,
        }
    return _schema(world.action_space, world.answer_words)


def _schema(space: spaces.Space[Any], words: Sequence[str] = ()) -> dict[str, Any]:
    if isinstance(space, spaces.Text):
        return {"type": "string", "minLength": 1, "maxLength": min(space.max_length, _TEXT)}
    if isinstance(space, spaces.Discrete):
        return {"type": "integer", "minimum": int(space.start), "maximum": int(space.start + space.n - 1)}
    if isinstance(space, spaces.Box) and len(space.shape) == 1:
        numbers = ", ".join(number_pattern(low, high) for low, high in zip(*_bounds(space), strict=True))
        taken = "|".join([*words, rf"\[{numbers}\]"])
        return {"type": "string", "pattern": f"^({taken})$"}
    return {}


def _bounds(space: spaces.Box) -> tuple[list[float], list[float]]:
    return space.low.tolist(), space.high.tolist()


def _plain(value: Any) -> Any:
    return value.tolist()
