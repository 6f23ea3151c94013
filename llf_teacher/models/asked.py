"""What a model was asked, as records keep it: the messages as they were sent, and the form of the answer."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from llf_teacher.models.images import without_images

Asked = dict[str, Any]
"""`messages`, as they were sent, and `fields`, the part of the request for the form of the answer."""
UNKNOWN = "the prompt was not kept, as in stores of earlier versions; play the episode again to see it"
"""What is shown in place of a prompt that a record lacks."""


def as_asked(messages: Sequence[Mapping[str, Any]], fields: Mapping[str, Any] | None = None) -> Asked:
    """A request as it is kept: each image is replaced by its SHA-256."""
    kept: Any = [*messages]
    if any(isinstance(message.get("content"), list) for message in messages):
        kept = json.loads(without_images(json.dumps(kept), {"messages": messages}))
    return {"messages": kept, "fields": dict(fields or {})}


def shortened(asked: Iterable[Asked | None]) -> list[dict[str, Any] | None]:
    """Requests in their order, each without what it shares with the one before, since the history is in all of them.

    A message of the one before is its place there; fields are left out if they are equal.
    """
    found: list[dict[str, Any] | None] = []
    places: dict[str, int] = {}
    fields: Any = None
    for each in asked:
        if each is None:
            found.append(None)
            continue
        texts = [json.dumps(message) for message in each["messages"]]
        messages = [places.get(text, message) for text, message in zip(texts, each["messages"], strict=True)]
        found.append({"messages": messages} | ({} if each["fields"] == fields else {"fields": each["fields"]}))
        places, fields = {text: place for place, text in enumerate(texts)}, each["fields"]
    return found


def restored(short: Iterable[Mapping[str, Any] | None]) -> list[Asked | None]:
    """The requests that `shortened` made short."""
    found: list[Asked | None] = []
    messages: list[Any] = []
    fields: Any = None
    for each in short:
        if each is None:
            found.append(None)
            continue
        messages = [messages[message] if isinstance(message, int) else message for message in each["messages"]]
        fields = each.get("fields", fields)
        found.append({"messages": messages, "fields": fields})
    return found


def lines_of(asked: Asked) -> Iterator[tuple[str, str]]:
    """Each message as its role and its text, and at last the form of the answer."""
    for message in asked["messages"]:
        content, calls = message.get("content"), message.get("tool_calls")
        parts: list[Any] = content if isinstance(content, list) else [{"text": content or ""}]
        texts = [part["text"] if "text" in part else f"[image {part['image_url']['url']}]" for part in parts]
        called = [f"{call['function']['name']}({call['function']['arguments']})" for call in calls or ()]
        yield f"{message['role']}", "\n".join(called or texts)
    yield "form of answer", _form(asked["fields"])


def _form(fields: Mapping[str, Any]) -> str:
    if "response_format" in fields:
        return f"JSON of the schema {_json(fields['response_format']['json_schema']['schema'])}"
    if "tools" in fields:
        tools = (each["function"] for each in fields["tools"])
        return "; ".join(f"a call of the tool {tool['name']} with {_json(tool['parameters'])}" for tool in tools)
    return "a text" + (f" that ends before any of {_json(fields['stop'])}" if "stop" in fields else "")


def _json(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)
