"""The claims that a family allows, as JSON Schema; reads claims from JSON, strictly and within bounds."""

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from enum import Enum
from functools import cache, cached_property
from inspect import cleandoc
from itertools import pairwise
from operator import itemgetter
from typing import Annotated, Any, NamedTuple, get_args, get_origin

from teachers.atoms import HN, HP, ActionClaim, Atom, Claim, FeedbackType, Grounded, Moment, PlanClaim, Utterance
from teachers.oracle import Oracle, claims_of
from teachers.phrasebook import Phrasebook
from teachers.spec import Range, unknown
from worlds.world import World

__all__ = [
    "LONGEST_TEXT",
    "Message",
    "Vocabulary",
    "holds",
    "in_own_words",
    "names_of",
    "sentences_of",
    "storable",
]


TYPE = "type"
"""The key that names a claim's class."""
MOST_CLAIMS, MOST_ITEMS, LONGEST_TEXT = 32, 64, 8192
"""The most claims of a message, items of a list, and characters of a text."""
MOST_CHARACTERS = 32_768
"""The most characters of a message's claims together, as Python writes them."""
GREATEST_INTEGER, GREATEST_NUMBER = 9_999, 1e9
"""Largest magnitudes of numbers in fields without a `Range`; some checks take time or memory in proportion."""
_DEEPEST = 4  # lists in lists, of an action whose form only the world knows


class Message(NamedTuple):
    """What a policy in the teacher's seat says, as far as it could be read."""

    claims: tuple[Claim, ...]
    text: str
    """The policy's own words for the claims; if empty, the voice words them."""
    problems: tuple[str, ...]
    """The reason for each claim that could not be read."""


class Vocabulary:
    """The claims of feedback that can be read from JSON: those of a family, and those of all families.

    A claim is an object with its class in `type`, and its fields. A verdict on the student's last action may omit the
    action if there is a moment. Excluded are instructions, verdicts on actions tried before the episode, notices,
    hedged and late claims, and comparisons of turns. A `Grounded` claim has no ground here; `means` checks it.

    Args:
        claims: the classes of a family. If a class of all families has the same name, it is called `common.Name`.
        oracle: its lab checks actions; None checks only their form.
        kinds: the kinds that the student hears, which `schema` and `listing` have by default.
    """

    def __init__(
        self,
        claims: Iterable[type[Claim]],
        oracle: Oracle | None = None,
        kinds: Iterable[FeedbackType] = tuple(FeedbackType),
    ) -> None:
        own = {cls.__name__: cls for cls in claims if _can_be_said(cls)}
        shared = [cls for cls in claims_of("teachers.common") if _can_be_said(cls)]
        also = {f"common.{cls.__name__}" if cls.__name__ in own else cls.__name__: cls for cls in shared}
        self.classes: dict[str, type[Claim]] = own | also
        """The classes by their names."""
        self.oracle = oracle
        self.kinds = frozenset(kinds)

    @classmethod
    def of(cls, oracle: Oracle, kinds: Iterable[FeedbackType] = tuple(FeedbackType)) -> "Vocabulary":
        """The vocabulary of an oracle; `kinds` as for the class."""
        return cls(oracle.claims(), oracle, kinds)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Vocabulary) and other.classes == self.classes

    __hash__ = None  # type: ignore[assignment]  # it is mutable

    @property
    def world(self) -> World[Any] | None:
        """The oracle's lab; None without an oracle."""
        return None if self.oracle is None else self.oracle.lab

    @cached_property
    def _names(self) -> dict[type[Claim], str]:
        return {cls: name for name, cls in self.classes.items()}

    def schema(self, kinds: Iterable[str] | None = None) -> dict[str, Any]:
        """The JSON Schema of a message with claims of some kinds, by default the vocabulary's."""
        wanted = self.kinds if kinds is None else set(kinds)
        forms = [self.schema_of(name) for name, cls in self.classes.items() if cls.kind in wanted]
        claims = {"type": "array", "maxItems": MOST_CLAIMS, "items": {"anyOf": forms}}
        text = {"type": "string", "maxLength": LONGEST_TEXT, "description": "The claims in words of your own."}
        return {
            "type": "object",
            "properties": {"claims": claims, "text": text},
            "required": ["claims"],
            "additionalProperties": False,
        }

    def schema_of(self, name: str) -> dict[str, Any]:
        """The JSON Schema of a class, by its name."""
        cls = self.classes[name]
        forms = _forms(cls)
        properties = {field: form.schema for field, form in forms.items()}
        if issubclass(cls, PlanClaim):
            properties["actions"] = {**properties["actions"], "minItems": 1}
        if self.world is not None:
            for field in actions_of(cls):
                properties[field] = {**properties[field], "description": self.world.action_syntax}
        return {
            "type": "object",
            "description": f"{cls.kind}: {' '.join(cleandoc(cls.__doc__ or '').split())}",
            "properties": {TYPE: {"const": name}, **properties},
            "required": [TYPE, *(field for field in forms if not may_lack(cls, field))],
            "additionalProperties": False,
        }

    def data_of(self, claim: Claim) -> dict[str, Any]:
        """A claim as JSON values; `claim_of` reads them back.

        Raises:
            ValueError: the vocabulary lacks its class.
        """
        if type(claim) not in self._names:
            raise ValueError(unknown("claim", type(claim).__name__, self.classes))
        values = {field: _plain(getattr(claim, field)) for field in _forms(type(claim))}
        return {TYPE: self._names[type(claim)], **values}

    def claim_of(self, data: Any, moment: Moment[Any] | None = None) -> Claim:
        """Read a claim from JSON values; a claim is returned as it is.

        Args:
            data: the values.
            moment: gives the student's last action to verdicts that omit it.

        Raises:
            ValueError: the values are no claim; the message names the field, what was got and what is allowed.
        """
        if isinstance(data, Claim):
            data = self.data_of(data)
        if not isinstance(data, Mapping):
            raise ValueError(f"a claim must be an object with the key {TYPE!r}, got {_shown(data)}")
        name = data.get(TYPE)
        if not isinstance(name, str) or name not in self.classes:
            raise ValueError(unknown("claim", _Shown(_shown(name)), self.classes))
        cls = self.classes[name]
        forms = _forms(cls)
        given = {key: value for key, value in data.items() if key != TYPE}
        if moment is not None and moment.before is not None:
            given |= {field: moment.action for field in forms if field not in given and may_lack(cls, field)}
        for key in given:
            if key not in forms:
                raise ValueError(f"{name} has no field {_shown(key)}; its fields: {', '.join(forms) or 'none'}")
        if missing := [field for field in forms if field not in given]:
            raise ValueError(f"{name} lacks the field {missing[0]!r}; its fields: {', '.join(forms)}")
        values = {field: self._value(f"{name}.{field}", form, given[field]) for field, form in forms.items()}
        if issubclass(cls, PlanClaim) and not values["actions"]:
            raise ValueError(f"{name}.actions must be at least one action, got none")
        if self.world is not None:
            for field in actions_of(cls):
                values[field] = self._legal(f"{name}.{field}", values[field])
            if issubclass(cls, PlanClaim):
                values["actions"] = tuple(self._legal(f"{name}.actions", each) for each in values["actions"])
        return cls(**values)

    @staticmethod
    def _value(where: str, form: "_Form", value: Any) -> Any:
        try:
            return form.read(value)
        except (TypeError, ValueError, OverflowError, RecursionError):
            raise ValueError(f"{where} must be {form.allowed}, got {_shown(value)}") from None

    def _legal(self, where: str, action: Any) -> Any:
        assert self.world is not None  # noqa: S101  # the caller has looked
        try:
            named = self.world.read(action) if isinstance(action, str) else None
            return self.world.legal(action if named is None else named)
        except (TypeError, ValueError, OverflowError):
            raise ValueError(f"{where} must be {self.world.action_syntax}, got {_shown(action)}") from None

    def read(self, message: Any, moment: Moment[Any] | None = None) -> Message:
        """Read a message: an object with a list `claims` and a `text`; both are optional."""
        if not isinstance(message, Mapping):
            return Message((), "", (f"a message must be an object with claims, got {_shown(message)}",))
        problems = [
            f"a message has no key {_shown(key)}; allowed: claims, text" for key in message if key not in _KEYS
        ][:1]
        text, listed = message.get("text", ""), message.get("claims", ())
        if text is None:
            text = ""
        if not isinstance(text, str) or len(text) > LONGEST_TEXT:
            problems.append(f"text must be a string of at most {LONGEST_TEXT} characters, got {_shown(text)}")
            text = ""
        if not isinstance(listed, list | tuple) or len(listed) > MOST_CLAIMS:
            problems.append(f"claims must be a list of at most {MOST_CLAIMS} claims, got {_shown(listed)}")
            listed = ()
        claims, left = [], MOST_CHARACTERS
        for data in listed:
            try:
                claim = self.claim_of(data, moment)
                if (size := len(f"{claim}")) > left:
                    raise ValueError(f"claims must have at most {MOST_CHARACTERS} characters, got {claim!r:.60}")
                claims.append(claim)
                left -= size
            except ValueError as error:
                problems.append(f"{error}")
        return Message(tuple(claims), storable(text).strip(), tuple(problems))

    def holds(self, claim: Claim, moment: Moment[Any]) -> bool:
        """Whether a claim is true of a moment of the episode on which the oracle has started.

        Raises:
            ValueError: it cannot be checked, or there is no oracle.
        """
        if self.oracle is None:
            raise ValueError("a claim can be checked only by an oracle; make the vocabulary by Vocabulary.of(oracle)")
        return holds(claim, moment, self.oracle)

    def texts_at_hand(self, claim: type[Claim], field: str, moment: Moment[Any]) -> Sequence[str]:
        """Texts that a claim can have in a field at a moment; empty: any text. See `Oracle.texts_at_hand`."""
        return () if self.oracle is None else self.oracle.texts_at_hand(claim, field, moment)

    def listing(self, kinds: Iterable[str] | None = None) -> str:
        """The classes of some kinds for a prompt, one a line: name, fields, and when its claims are true.

        The kinds are by default the vocabulary's.
        """
        wanted = self.kinds if kinds is None else set(kinds)
        lines = []
        for name, cls in self.classes.items():
            if cls.kind in wanted:
                parts = ", ".join(f"{field}: {form.allowed}" for field, form in _forms(cls).items())
                lines.append(f"{name}({parts}): {' '.join(cleandoc(cls.__doc__ or '').split())}")
        return "\n".join(lines)


_KEYS = ("claims", "text")


def holds(claim: Claim, moment: Moment[Any], oracle: Oracle, voice: Phrasebook | None = None) -> bool:
    """Whether a claim is true of a moment, by `holds`, or by `means` if its ground is not known.

    Args:
        claim: any claim of the oracle's vocabulary, however strange.
        moment: a moment of the episode on which the oracle has started.
        oracle: gives the lab.
        voice: must have words for the claim; None skips this.

    Raises:
        ValueError: it cannot be checked or worded: the world knows no such thing.
    """
    try:
        if voice is not None:
            voice.sentences(claim)
        if isinstance(claim, Grounded) and not claim.grounded:
            return bool(claim.means(moment, oracle))
        return bool(claim.holds(moment, oracle.lab))
    except Exception as error:  # the check of a claim of an oracle need not be ready for any field
        raise ValueError(f"{claim!r:.100} cannot be checked: the world has no such thing, nor words for it") from error


def in_own_words(atoms: Sequence[Atom], text: str, voice: Phrasebook) -> Utterance:
    """Match the sentences of a policy's text to its claims, as an utterance.

    A claim gets the sentences that exactly match one of its phrasings, apart from case, space and final punctuation.
    Other sentences have no claim and count as unchecked; a claim without a match has no text.
    """
    left, placed = sentences_of(text), []
    bare = [_bare(each) for each in left]
    for atom in atoms:
        ways = {tuple(map(_bare, sentences_of(each))) for each in voice.sentences(atom.claim)}
        found = [(i, i + len(way)) for way in ways for i in range(len(bare)) if (*bare[i : i + len(way)],) == way]
        begin, end = max(found, key=lambda span: (span[1] - span[0], -span[0]), default=(len(left), len(left)))
        placed.append((begin, atom._replace(text=" ".join(left[begin:end]))))
        bare[begin:end] = [""] * (end - begin)  # a sentence is of one claim
    return Utterance(text, tuple(atom for _, atom in sorted(placed, key=itemgetter(0))))


def _bare(sentence: str) -> str:
    return " ".join(sentence.casefold().rstrip(".!\"')] ").split())


def storable(text: str) -> str:
    """A text from outside without lone surrogates, which no file takes: a question mark stands for each."""
    if text.isascii():
        return text
    try:
        text.encode()  # takes a third of the time of making another string, which costs a poem's turn a tenth
    except UnicodeEncodeError:
        return text.encode("utf-8", "replace").decode()
    return text


def sentences_of(text: str) -> list[str]:
    """The sentences of a text, verbatim; none ends within a quotation."""
    cuts = [0, *(end.end() for end in _ENDS.finditer(text) if end[1]), len(text)]
    parts = (text[begin:end].strip() for begin, end in pairwise(cuts))
    return [part for part in parts if any(map(str.isalnum, part))]


def without(text: str, parts: Iterable[str]) -> str:
    """A text without the first occurrence of each part, such as the texts of its atoms."""
    for part in parts:
        text = text.replace(part, "", 1)
    return text


_ENDS = re.compile(r"((?:\"[^\"]*[.!?]\"|[.!?])[\"')\]]*\s|\n)|\"[^\"]*\"")  # an end of a sentence, or a quotation


def _can_be_said(cls: type[Claim]) -> bool:
    return isinstance(cls.kind, FeedbackType) and not cls.tried and not cls.placebo and cls.within is Claim.within


def actions_of(cls: Any) -> list[str]:
    """The fields that hold an action."""
    return [
        field.name
        for field in fields(cls)
        if field.type is Any or (field.name == "action" and issubclass(cls, ActionClaim))
    ]


def may_lack(cls: type[Claim], field: str) -> bool:
    """Whether JSON may omit a field: the student's own action, which the moment gives."""
    return field == "action" and issubclass(cls, ActionClaim) and cls.kind in (HP, HN)


class _Form(NamedTuple):
    """The form of a field."""

    schema: dict[str, Any]
    allowed: str
    """The allowed values, in words."""
    read: Callable[[Any], Any]
    """Converts a JSON value; raises if it is not allowed."""


def _forms(cls: Any) -> dict[str, _Form]:
    return _known_forms(cls)


@cache
def _known_forms(cls: Any) -> dict[str, _Form]:
    """The forms of a class's fields, in their order.

    Raises:
        TypeError: a field has an unsupported type, or is named like the key `TYPE`.
    """
    forms = {field.name: _form(field.type) for field in fields(cls)}
    if TYPE in forms:
        raise TypeError(f"a claim that can be said must not have a field {TYPE!r}, got {cls.__name__}")
    return forms


def _form(kind: Any, *notes: Any) -> _Form:
    """The form of a type. Two annotations count: a `Range`, and a tuple of the only allowed texts."""
    if get_origin(kind) is Annotated:
        return _form(*get_args(kind))
    if get_origin(kind) is tuple:
        return _tuple_form(get_args(kind))
    if kind is Any:
        return _Form({}, "an action", _freeze)
    if isinstance(kind, type) and issubclass(kind, Enum):
        members = {str(member): member for member in kind} | {member.value: member for member in kind}
        return _choice([str(member) for member in kind], members)
    names = next((note for note in notes if isinstance(note, tuple) and not isinstance(note, Range)), None)
    if kind is str and names:
        return _choice([*names], {name: name for name in names})
    if kind is str:
        schema = {"type": "string", "maxLength": LONGEST_TEXT}
        return _Form(schema, f"a text of at most {LONGEST_TEXT} characters", _read_text)
    if kind in (int, float):
        greatest = GREATEST_INTEGER if kind is int else GREATEST_NUMBER
        low, high = map(float, next((note for note in notes if isinstance(note, Range)), (-greatest, greatest)))
        noun = ("an integer", "integer") if kind is int else ("a number", "number")
        schema = {"type": noun[1], "minimum": kind(low), "maximum": kind(high)}
        return _Form(schema, f"{noun[0]} from {low:g} to {high:g}", lambda value: _number(value, kind, low, high))
    raise TypeError(f"a field of a claim must be a number, a text, an enumeration or a tuple of these, got {kind!r}")


def _tuple_form(parts: tuple[Any, ...]) -> _Form:
    free = parts[-1] is ...
    forms = [_form(part) for part in parts if part is not ...]
    least, most = (0, MOST_ITEMS) if free else (len(parts), len(parts))
    alike = all(form.schema == forms[0].schema for form in forms)
    items: dict[str, Any] = {"items": forms[0].schema} if alike else {"prefixItems": [form.schema for form in forms]}
    size = f"at most {most}" if free else f"{most}"

    def read(value: Any) -> Any:
        if not isinstance(value, list | tuple) or not least <= len(value) <= most:
            raise ValueError
        return tuple(form.read(item) for form, item in zip(forms * (len(value) if free else 1), value, strict=True))

    allowed = f"a list of {size}, each {forms[0].allowed}" if alike else f"a list of {most}"
    return _Form({"type": "array", **items, "minItems": least, "maxItems": most}, allowed, read)


def _choice(names: list[str], members: dict[Any, Any]) -> _Form:
    def read(value: Any) -> Any:
        if not isinstance(value, str | int) or isinstance(value, bool) or value not in members:
            raise ValueError
        return members[value]

    return _Form({"enum": names}, f"one of {', '.join(names)}", read)


def _read_text(value: Any) -> str:
    if not isinstance(value, str) or len(value) > LONGEST_TEXT:
        raise ValueError
    return storable(value)


def _number(value: Any, kind: type, low: float, high: float) -> Any:
    whole = isinstance(value, float) and value.is_integer()  # 3.0 is an integer of JSON Schema
    if isinstance(value, bool) or not (whole or isinstance(value, int if kind is int else int | float)):
        raise ValueError
    if not low <= value <= high or not math.isfinite(value):
        raise ValueError
    return kind(value)


def _freeze(value: Any, depth: int = _DEEPEST) -> Any:
    """An action as a hashable value, within all bounds."""
    if isinstance(value, list | tuple) and depth and len(value) <= MOST_ITEMS:
        return tuple(_freeze(item, depth - 1) for item in value)
    if isinstance(value, str):
        return _read_text(value)
    return value if isinstance(value, bool) else _number(value, float if isinstance(value, float) else int, *_ANY)


_ANY = (-GREATEST_NUMBER, GREATEST_NUMBER)


def _plain(value: Any) -> Any:
    """A field's value as JSON; members of enumerations become their names."""
    if isinstance(value, Enum):
        return f"{value}"
    return [_plain(item) for item in value] if isinstance(value, tuple) else value


class _Shown(str):
    """A text whose repr is the text itself."""

    __slots__ = ()
    __repr__ = str.__str__


def _shown(value: Any) -> str:
    """A short description of any value, however large or deep."""
    if isinstance(value, str):
        return f"{value!r:.60}" if len(value) <= 60 else f"{value[:50]!r} and {len(value) - 50} characters more"
    if value is None or isinstance(value, bool | float) or (isinstance(value, int) and abs(value) < 10**30):
        return f"{value!r}"
    size = f" of {len(value)}" if hasattr(value, "__len__") else ""
    return f"a {type(value).__name__}{size}"


def names_of(cls: type[Claim]) -> dict[str, list[str]]:
    """The enumeration fields of a class, each with all names."""
    return {field: form.schema["enum"] for field, form in _forms(cls).items() if "enum" in form.schema}
