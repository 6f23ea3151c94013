"""Builds the claim that a phrase states in what people and models say to a student."""

import itertools
import json
import math
import re
import string
from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from functools import cache, lru_cache
from typing import Any, NamedTuple, Protocol

from pz_envs.text.phrases import Reader, SentenceReading
from teachers.atoms import HN, HP, ActionClaim, Claim, Moment, PlanClaim
from teachers.phrasebook import Phrasebook
from teachers.schema import Vocabulary, names_of
from teachers.templates import Template
from teachers.voice import Voice, voice_names
from worlds.world import World

MOST_BUILT = 4096
"""The most claims that are tried for a sentence."""


class Language(Protocol):
    """The phrases and the claims of a subject, as `pz_envs.subject.Subject` has them."""

    @property
    def name(self) -> str:
        """The subject's name."""

    def phrasebook(self, voice: Voice = "plain") -> Phrasebook:
        """The phrases of a voice."""

    def vocabulary(self, world: World[Any, Any, Any] | None = None) -> Vocabulary:
        """The claims that can be said; the world decides the actions."""


@dataclass(frozen=True)
class _Key:
    """A subject as the key of a cache."""

    name: str
    subject: Language = field(hash=False)  # it may have a dictionary


def make_reader(subject: Language) -> Reader:
    """A reader of a subject's phrases, before its first text; the phrases are learnt once per subject."""
    return _reader(_Key(subject.name, subject)).anew()


@lru_cache(maxsize=16)
def _reader(key: _Key) -> Reader:
    reader = Reader(key.subject.phrasebook, voice_names(), fits=_fits)
    for voice in voice_names():  # now, since threads may share it
        reader.learn(voice)
    return reader


def _fits(cls: type[Claim[Any]], slots: Mapping[str, str]) -> bool:
    """Whether slots of numbers hold numbers, and slots of enumerations hold their names."""
    numbers, names = _kinds_of(cls)  # type: ignore[arg-type]  # a class is hashable
    texts = {slot: _bare(text) for slot, text in slots.items()}
    return all(_json(texts[slot]) is not None for slot in numbers & texts.keys()) and all(
        texts[slot].casefold() in names[slot] for slot in names.keys() & texts.keys()
    )


@cache
def _kinds_of(cls: type[Claim[Any]]) -> tuple[frozenset[str], Mapping[str, frozenset[str]]]:
    """The fields that are numbers, and the names, in lower case, of each field that is an enumeration."""
    types = {each.name: getattr(each.type, "__origin__", each.type) for each in fields(cls)}  # type: ignore[arg-type]  # a dataclass
    try:
        names = {field: frozenset(map(str.casefold, each)) for field, each in names_of(cls).items()}
    except TypeError:  # no claim of this class is made from JSON, so that its fields need no form
        names = {}
    return frozenset(name for name, kind in types.items() if kind in (int, float)), names


class Built(NamedTuple):
    """The claim of a sentence, if there is one."""

    claim: Claim[Any] | None
    """None: no claim says the sentence, or several do."""
    candidates: tuple[str, ...]
    """Without a claim, the nearest: the first claims that fit, or else the name of the class."""


def build_claim(
    reading: SentenceReading, subject: Language, vocabulary: Vocabulary, moment: Moment[Any] | None = None
) -> Built:
    """The only claim of a reading's class whose phrases would fill the slots as the sentence does.

    Fields take their values from enumerations and from the sentence, never from the world's truth. A number counts as
    it is said: one that is rounded more than in the phrases fits no claim.

    Args:
        reading: a sentence, from `read_sentences`.
        subject: what is taught.
        vocabulary: makes the claims, and decides the actions of the moment.
        moment: has the student's last action, for verdicts that leave it out.
    """
    name = next((name for name, cls in vocabulary.classes.items() if cls is reading.claim), "")
    if not name:
        return Built(None, ())
    cls, specs = vocabulary.classes[name], _specs(_Key(subject.name, subject), vocabulary.classes[name])  # type: ignore[arg-type]  # a class is hashable
    forms = {key: form for key, form in vocabulary.schema_of(name)["properties"].items() if key != "type"}
    values = {key: [*_values(cls, key, form, reading.slots, specs)] for key, form in forms.items()}
    if issubclass(cls, ActionClaim) and cls.kind in (HP, HN) and cls.action_slot not in reading.slots:
        values.pop("action", None)  # it is the student's last
    found: list[Claim[Any]] = []
    if math.prod(map(len, values.values())) <= MOST_BUILT:
        for each in itertools.product(*values.values()):
            try:
                claim = vocabulary.claim_of({"type": name, **dict(zip(values, each, strict=True))}, moment)
            except ValueError:
                continue
            if claim not in found and _says(claim, reading.slots, specs):
                found.append(claim)
    if len(found) == 1:
        return Built(found[0], ())
    return Built(None, tuple(f"{claim}" for claim in found[:3]) or (name,))


def said_by(reading: SentenceReading, subject: Language, claims: Iterable[Claim[Any]]) -> list[Claim[Any]]:
    """The claims among some that the sentence says by its slots, where numbers may be rounded."""
    specs = _specs(_Key(subject.name, subject), reading.claim) if reading.claim else {}  # type: ignore[arg-type]  # a class is hashable
    return [claim for claim in claims if type(claim) is reading.claim and _says(claim, reading.slots, specs)]


def _values(
    cls: type[Claim[Any]], name: str, form: Mapping[str, Any], slots: Mapping[str, str], known: Container[str]
) -> Iterator[Any]:
    """The possible JSON values of a field: the names of an enumeration, or the text in the field's slot.

    A field that is not among the `known` slots may stand in any slot.
    """
    if "enum" in form:
        yield from form["enum"]
        return
    own = name
    if name == "action" and issubclass(cls, ActionClaim):
        own = cls.action_slot
    elif name == "actions" and issubclass(cls, PlanClaim):
        steps = slots.get(cls.plan_slot, "").split(cls.separator)
        yield from ([each(step) for step in steps] for each in (str, _bare, _json))
        return
    texts = [slots[own]] if own in slots else [] if own in known or name == "action" else [*slots.values()]
    for text in map(_bare, texts):
        kind, items = form.get("type"), form.get("items", {}).get("type")
        numbers = [_json(number) for number in _NUMBER.findall(text)]
        if kind in _NUMBERS:
            yield from numbers
        elif kind == "array" and not isinstance(_json(text), list):
            parts = [part for part in _BETWEEN.split(text) if part]
            yield numbers if items in _NUMBERS else parts
            yield [_ARTICLE.sub("", part) for part in parts]
        elif kind != "array":
            yield text
            yield _ARTICLE.sub("", text)
        if kind != "string":
            yield _json(text)


_NUMBERS = ("integer", "number")
_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?")
_BETWEEN = re.compile(r",? (?:and|or|then) |, ?")
_ARTICLE = re.compile(r"^(?:an?|the) ", re.IGNORECASE)


def _bare(text: str) -> str:
    return text.strip(' "`')


def _json(text: str) -> Any:
    """The JSON value of a text, such as a number or a list, which may stand in round brackets; None: it has none."""
    try:
        return json.loads(re.sub(r"^\((.*)\)$", r"[\1]", text).removeprefix("+"))
    except (ValueError, RecursionError):
        return None


@lru_cache(maxsize=1024)
def _specs(key: _Key, cls: type[Claim[Any]]) -> dict[str, tuple[Template, ...]]:
    """The ways in which the phrases of all voices write each slot."""
    every = dict.fromkeys(each for voice in voice_names() for each in key.subject.phrasebook(voice).templates(cls))
    found: dict[str, dict[str, None]] = {}
    for phrase in every:
        if any(other != phrase and other in phrase for other in every):
            continue  # it only frames another one
        for _, slot, spec, conversion in string.Formatter().parse(phrase):
            if slot is not None:
                written = "{" + slot + (f"!{conversion}" if conversion else "") + (f":{spec}" if spec else "") + "}"
                found.setdefault(slot, {})[written] = None
    return {slot: tuple(map(Template, ways)) for slot, ways in found.items()}


def _says(claim: Claim[Any], slots: Mapping[str, str], specs: Mapping[str, tuple[Template, ...]]) -> bool:
    """Whether the claim would fill the slots with these texts."""
    try:
        return all(
            any(_same_value(text, way.format(claim)) for way in specs.get(slot, ())) for slot, text in slots.items()
        )
    except Exception:  # what phrases compute need not be ready for any field
        return False


def _same_value(one: str, other: str) -> bool:
    """Whether two texts are the same number or list, or the same words apart from case and quotes."""
    return bool(_value(one) == _value(other))


def _value(text: str) -> Any:
    value = _json(_bare(text))
    return _bare(text).casefold() if value is None else value
