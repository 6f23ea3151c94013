"""Formats in which a request asks a chat model for an answer: example, schema, and the action in an answer."""

import json
from typing import Any

import numpy as np
from gymnasium import spaces

from pz_envs.text.json_values import unique_keys
from worlds.world import World

ANSWERS = ("text", "json", "tool")
"""The formats: text behind `Response:`, a JSON object, a call of the tool `act`."""
_THOUGHT = "I have not tried this yet, and want to see what it does."
_LINES = 3  # of an example


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
    if isinstance(action, str):
        return "\n".join(action.splitlines()[:_LINES])
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


def schema(world: World[Any] | None) -> dict[str, Any]:
    """The JSON Schema of a thought and an action; None: of any action."""
    action = {} if world is None else _schema(world.action_space)
    if world is not None and world.action_words:
        action = {"enum": list(world.action_words)}
    return {
        "type": "object",
        "properties": {"thought": {"type": "string"}, "action": action},
        "required": ["thought", "action"],
        "additionalProperties": False,
    }


def request_fields(answer: str, world: World[Any] | None) -> dict[str, Any]:
    """The fields of a request's body that ask for a format."""
    if answer == "json":
        return {"response_format": {"type": "json_schema", "json_schema": {"name": "turn", "schema": schema(world)}}}
    if answer == "tool":
        act = {"name": "act", "description": "Take one action.", "parameters": schema(world)}
        return {
            "tools": [{"type": "function", "function": act}],
            "tool_choice": "required",
        }  # some endpoints refuse a tool's name here
    return {}


def action_in(answer: str, text: str) -> tuple[str, str]:
    """The action in an answer, as text, and the thought beside it.

    A text of another format than `answer` is returned whole; `actions.read_text` decides whether it is an action.
    """
    if answer == "text":
        return text, ""
    try:
        value = json.loads(text, object_pairs_hook=unique_keys)
    except (ValueError, RecursionError):
        return text, ""
    if not isinstance(value, dict) or "action" not in value:
        return text, ""
    action, thought = value["action"], value.get("thought")
    said = action if isinstance(action, str) else json.dumps(action, ensure_ascii=False)
    return said, thought if isinstance(thought, str) else ""


def _value(action: str) -> Any:
    """A written action in JSON: a number or a list of numbers as such, all else as text."""
    try:
        value = json.loads(action)
    except ValueError:
        return action
    return action if isinstance(value, list) and any(isinstance(item, str) for item in value) else value


def _schema(space: spaces.Space[Any]) -> dict[str, Any]:
    if isinstance(space, spaces.Text):
        return {"type": "string"}
    if isinstance(space, spaces.Discrete):
        return {"type": "integer", "minimum": int(space.start), "maximum": int(space.start + space.n - 1)}
    if isinstance(space, spaces.Box) and len(space.shape) == 1:
        return {"type": "array", "items": {"type": "number"}, "minItems": space.shape[0], "maxItems": space.shape[0]}
    return {}


def _plain(value: Any) -> Any:
    return value.tolist()
