"""The JSON Schema of a message of claims, bounded by what a moment allows, so that an answer ends."""

import json
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from gymnasium import spaces

from teachers.atoms import FN, FP, Claim, Moment, PlanClaim
from teachers.schema import TYPE, Vocabulary, actions_of, may_lack

FEW_CLAIMS = 3
"""The most claims of a message, by default."""
WORDS = 300
"""Greatest number of characters of the words beside the claims."""
_ITEMS = 4  # of a list in a claim
_TEXT = 100  # characters of a text that nothing else bounds
_ACTION = 300  # characters of an action that is a text
_NUMBER = 20  # characters of a number
_ANY = 100  # characters of a value of any form
_FIELD = 6  # characters around the name of a field


def message_schema(
    vocabulary: Vocabulary,
    moment: Moment[Any],
    most: int = FEW_CLAIMS,
    *,
    known: Iterable[Mapping[str, Any]] = (),
    words: bool = False,
) -> dict[str, Any]:
    """The JSON Schema of a message of at most `most` claims that can be said of a moment.

    It has the kinds that the student hears: hindsight only after an action, advice only before one. A verdict has no
    action, since the moment gives it. An action is one that can be taken, and a text one of those at hand; see
    `teachers.oracle.Oracle.texts_at_hand`.

    Args:
        vocabulary: the claims.
        moment: the moment.
        most: the most claims.
        known: claims as JSON values whose texts are at hand, too.
        words: whether the message has words of its own for the claims.
    """
    at_hand = _AtHand(vocabulary, moment, known)
    forms = [
        _claim(name, cls, at_hand)
        for name, cls in vocabulary.classes.items()
        if cls.kind in vocabulary.kinds and not (moment.over if cls.kind in (FP, FN) else moment.before is None)
    ]
    listed = (
        {"type": "array", "items": {"anyOf": forms}, "maxItems": most} if forms else {"type": "array", "maxItems": 0}
    )
    properties = {"claims": listed} | ({"text": {"type": "string", "maxLength": WORDS}} if words else {})
    return {"type": "object", "properties": properties, "required": [*properties], "additionalProperties": False}


def longest(schema: Mapping[str, Any]) -> int:
    """Greatest number of characters of JSON of a schema; an estimate where the schema sets no bound."""
    if "const" in schema or "enum" in schema:
        return max(len(json.dumps(value)) for value in schema.get("enum", (schema.get("const"),)))
    if "anyOf" in schema:
        return max(map(longest, schema["anyOf"]))
    kind = schema.get("type")
    if kind == "object":
        return 2 + sum(len(name) + _FIELD + longest(each) for name, each in schema["properties"].items())
    if kind == "array":
        items = schema.get("prefixItems") or [schema.get("items", {})] * schema.get("maxItems", _ITEMS)
        return 2 + sum(2 + longest(each) for each in items)
    if kind == "string":
        return 2 + int(schema.get("maxLength", _TEXT))
    return _NUMBER if kind in ("integer", "number") else _ANY


class _AtHand:
    """The values that a claim can name; the arguments are those of `message_schema`."""

    def __init__(self, vocabulary: Vocabulary, moment: Moment[Any], known: Iterable[Mapping[str, Any]]) -> None:
        self.vocabulary, self._moment = vocabulary, moment
        self._texts: dict[str, list[str]] = defaultdict(list)
        self._items: dict[str, int] = defaultdict(lambda: _ITEMS)
        for data in known:
            for field, value in data.items():
                values = value if isinstance(value, list) else [value]
                self._texts[field] += [each for each in values if isinstance(each, str)]
                self._items[field] = max(self._items[field], len(values))

    def texts(self, cls: type[Claim], field: str) -> list[str]:
        """The texts of a field; empty: any text."""
        found = self.vocabulary.texts_at_hand(cls, field, self._moment)
        return [*dict.fromkeys([*found, *self._texts[field]])]

    def items(self, field: str) -> int:
        """Greatest number of items of a list."""
        return self._items[field]


def _claim(name: str, cls: type[Claim], at_hand: _AtHand) -> dict[str, Any]:
    """The schema of a class."""
    vocabulary = at_hand.vocabulary
    fields = {
        field: form
        for field, form in vocabulary.schema_of(name)["properties"].items()
        if field != TYPE and not may_lack(cls, field)
    }
    acts = actions_of(cls)
    for field, form in fields.items():
        if field in acts:
            fields[field] = _action(vocabulary, form, at_hand.texts(cls, "action"))
        elif field == "actions" and issubclass(cls, PlanClaim):
            items = _action(vocabulary, form["items"], at_hand.texts(cls, "action"))
            fields[field] = {"type": "array", "items": items, "minItems": 1, "maxItems": at_hand.items(field)}
        else:
            fields[field] = _value(form, at_hand.texts(cls, field), at_hand.items(field))
    properties = {TYPE: {"const": name}, **fields}
    return {"type": "object", "properties": properties, "required": [*properties], "additionalProperties": False}


def _action(vocabulary: Vocabulary, form: Mapping[str, Any], at_hand: Sequence[str]) -> dict[str, Any]:
    """The schema of an action, in the form that the claim's field has."""
    world, own = vocabulary.world, {key: value for key, value in form.items() if key != "description"}
    if world is None or "enum" in own:
        return own
    space = world.action_space
    if at_hand or (world.action_words and own.get("type") != "integer"):
        return {"enum": [*(at_hand or world.action_words)]}
    if isinstance(space, spaces.Discrete):
        return {"type": "integer", "minimum": int(space.start), "maximum": int(space.start + space.n - 1)}
    if isinstance(space, spaces.Box) and len(space.shape) == 1:
        bounds = zip(space.low.tolist(), space.high.tolist(), strict=True)
        numbers = [{"type": "number", "minimum": low, "maximum": high} for low, high in bounds]
        alike = all(each == numbers[0] for each in numbers)
        items: dict[str, Any] = {"items": numbers[0]} if alike else {"prefixItems": numbers}
        return {"type": "array", **items, "minItems": len(numbers), "maxItems": len(numbers)}
    return {"type": "string", "maxLength": _ACTION} if isinstance(space, spaces.Text) else own


def _value(form: Mapping[str, Any], texts: Sequence[str], most: int) -> dict[str, Any]:
    """The schema of another field; `most`: the most items of a list."""
    if form.get("type") == "array" and "items" in form:
        fixed = form["minItems"] == form["maxItems"]
        least, most = form["minItems"], form["maxItems"] if fixed else most
        return {"type": "array", "items": _value(form["items"], texts, most), "minItems": least, "maxItems": most}
    if form.get("type") == "string":
        return {"enum": [*texts]} if texts else {"type": "string", "maxLength": _TEXT}
    return {**form}
