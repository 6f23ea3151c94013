"""Reading sentences that are nearly a teacher's: other numbers, order, spelling, and a small table of synonyms.

A sentence is compared with the phrases of each claim. What can stand in a phrase's slots is looked for first, by the
slot's kind: a number, a quotation, a list, a name of an enumeration, or a pattern of the family's table. What remains
are words. Two measures decide: how much of the sentence and of the nearest phrase agree, each word by how few claims
have it; and how much likelier the words are under this claim than under the next one. Where these are not clear, the
sentence is not read. The truth of the world is never looked at.

The tables are `synonyms/common.toml` and `synonyms/<family>.toml`. `words` has per word of the phrases what people say
in its place; `slots` the patterns of slots that hold neither number nor enumeration, or `<list>` or `<number>`, for all
claims or, as `Claim.slot`, for one (empty: any text, which only the phrases themselves can have);
`fillers` words that say nothing; and `senses` groups of words that turn the sense of a sentence.
"""

import math
import re
import string
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from functools import cache, cached_property, partial
from importlib import resources
from itertools import permutations
from typing import Any, NamedTuple

from rapidfuzz.distance import OSA

from teachers.atoms import FN, FP, HN, HP, ActionClaim, Claim, Grounded, Scope
from teachers.schema import names_of

__all__ = ["Near", "Nearest", "Synonyms", "load_synonyms"]

NUMBER, QUOTED, LIST = "number", "quoted", "list"
_PATTERNS = {
    QUOTED: r'"([^"]*)"|`([^`]*)`',
    LIST: r"\[[^\[\]]*\]",
    NUMBER: r"(?<![\w.-])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w-])",
}
AGREES, AGREES_ALONE, LIKELIER = 0.33, 0.45, 2.0
"""How much a sentence must agree with a phrase, with slots and without, and how much likelier a claim must be than the
next, as a log."""
OWN = 0.5
"""The share of claims below which a word is one of a claim's own, of which a sentence must have one."""
FOREIGN, STRANGE = 0.2, 1
"""The share of claims below which their words are foreign to others, and how many strange words a sentence may have."""
_PAST = frozenset("was were did had have has been got went gone pulled took brought chose came".split())  # noqa: SIM905
_NUMBERS = """two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen seventeen
eighteen nineteen twenty"""
_DIGITS = {word: number for number, word in enumerate(_NUMBERS.split(), 2)} | {"zero": 0, "thirty": 30, "forty": 40}
"""Numbers in words, without "one", which is mostly a pronoun."""
_ORDINALS = {word: i for i, word in enumerate("first second third fourth fifth sixth".split(), 1)}  # noqa: SIM905
_SHORT = {
    "n't": " not", "'re": " are", "'ve": " have", "'ll": " will", "'d": " would", "'m": " am", "cannot": "can not",
    "dont": "do not", "didnt": "did not", "isnt": "is not", "wasnt": "was not", "won not": "will not",
    "ca not": "can not",
}  # fmt: skip


class Synonyms(NamedTuple):
    """The synonyms of a family, and the patterns of its slots."""

    words: Mapping[str, Sequence[str]]
    slots: Mapping[str, str]
    fillers: frozenset[str]
    """Words that say nothing."""
    senses: tuple[frozenset[str], ...]
    """Groups of words that turn the sense of a sentence: with one it says something else than without."""


@cache
def load_synonyms(family: str) -> Synonyms:
    """The table of a family, with that of all families."""
    words: dict[str, Sequence[str]] = {}
    slots: dict[str, str] = {}
    fillers: set[str] = set()
    senses: list[frozenset[str]] = []
    for name in ("common", family):
        file = resources.files("teachers.synonyms").joinpath(f"{name}.toml")
        if file.is_file():
            table = tomllib.loads(file.read_text(encoding="utf-8"))
            words |= table.get("words", {})
            slots |= table.get("slots", {})
            fillers |= {*table.get("fillers", ())}
            senses += [frozenset(group.split()) for group in table.get("senses", ())]
    return Synonyms(words, slots, frozenset(fillers), tuple(senses))


class Nearest(NamedTuple):
    """What a sentence says by this layer."""

    claim: str | None
    """The name of the claim; None: the sentence is not read."""
    slots: dict[str, str]
    """The text in each slot."""
    candidates: tuple[str, ...]
    """The names of the claims that came nearest, the nearest first."""


class _Phrase(NamedTuple):
    """A phrase of a claim."""

    claim: str
    source: str
    kinds: tuple[tuple[str, str], ...]
    """The slots in their order, each with its kind."""
    cues: tuple[str, ...]
    """The word before each slot."""
    words: frozenset[str]


class _Candidate(NamedTuple):
    """A claim that a sentence may state."""

    claim: str
    agrees: float
    """How much the sentence and the nearest phrase agree, 0 to 1."""
    likely: float
    """The log of how likely the sentence's words are in phrases of the claim."""
    foreign: bool
    """Whether a word of the sentence belongs to a few other claims, or none to this one more than to most."""
    strange: int
    """Number of words that no phrase has."""
    slots: dict[str, str]


class Near:
    """The near layer for the claims of a family.

    Args:
        classes: the claims by name.
        phrases: per claim its phrases.
        table: of the family.
    """

    def __init__(
        self, classes: Mapping[str, type[Claim]], phrases: Mapping[str, Iterable[str]], table: Synonyms
    ) -> None:
        self._classes, self._table = classes, table
        phrases = {name: () if _is_vague(classes[name]) else each for name, each in phrases.items()}
        self._synonyms = [
            (
                re.compile(
                    rf"\b(?:{'|'.join(map(re.escape, sorted(others, key=len, reverse=True)))})\b", re.IGNORECASE
                ),
                word,
            )
            for word, others in table.words.items()
        ]
        self._kinds = {name: _kinds_of(cls, table) for name, cls in classes.items()}
        self._named = {
            self._kinds[name][cls.action_slot]
            for name, cls in classes.items()
            if issubclass(cls, ActionClaim) and cls.action_slot in self._kinds[name]
        } - set(_PATTERNS)
        names = {_any_of(each) for cls in classes.values() for each in names_of(cls).values()}
        whole = [rf"(?<![\w-])(?:{each})(?![\w-])" for each in sorted(names)]
        self._entities = [re.compile(each, re.IGNORECASE) for each in (*_PATTERNS.values(), *whole)]
        made = (self._phrase(name, each) for name, sources in phrases.items() for each in sources if each[-1:] != "?")
        self._phrases = [phrase for phrase in made if phrase is not None]
        self._claims: dict[str, set[str]] = defaultdict(set)
        for phrase in self._phrases:
            for word in phrase.words:
                self._claims[word].add(phrase.claim)
        count = len({phrase.claim for phrase in self._phrases})
        self._weights = {word: math.log(1 + count / len(having)) for word, having in self._claims.items()}
        self._strange = math.log(1 + count)
        self._turns: dict[str, Counter[tuple[bool, ...]]] = defaultdict(Counter)
        for phrase in self._phrases:
            self._turns[phrase.claim][self._turns_of(phrase.words)] += 1
        self._totals: Counter[str] = Counter(phrase.claim for phrase in self._phrases)
        self._having: Counter[tuple[str, str]] = Counter(
            (phrase.claim, word) for phrase in self._phrases for word in phrase.words
        )

    @cached_property
    def _known(self) -> list[str]:
        """The words that a misspelt one may stand for."""
        names = (
            word for kinds in self._kinds.values() for kind in kinds.values() for word in re.findall(r"[a-z]{4,}", kind)
        )
        return sorted({word for word in (*self._weights, *names) if len(word) >= 4})

    def read(self, sentence: str, without: str | None = None) -> Nearest:
        """Read a sentence.

        Args:
            sentence: of at most 1,000 characters; longer ones are not read, nor questions: these may mean the opposite.
            without: a phrase that is left out, for measuring.
        """
        if len(sentence) > 1000 or sentence.rstrip(" \"')`").endswith("?"):
            return Nearest(None, {}, ())
        text = self._spelt(self._plain(sentence))
        ranked = self._ranked(text, without)
        names = tuple(each.claim for each in ranked[:3])
        if not ranked:
            return Nearest(None, {}, ())
        best = ranked[0]
        rivals = [each for each in ranked[1:] if each.agrees >= best.agrees / 2]
        clear = all(best.likely - each.likely >= LIKELIER for each in rivals)
        least = AGREES if best.slots else AGREES_ALONE
        if best.agrees < least or best.foreign or best.strange > STRANGE or not clear:
            return Nearest(None, {}, names)
        return Nearest(best.claim, best.slots, names[:1])

    def fits(self, claim: str, slots: Mapping[str, str]) -> bool:
        """Whether what stands in a claim's slots is of their kinds, as far as these are known."""
        kinds = self._kinds.get(claim, {})
        patterns = {slot: _PATTERNS.get(kind, kind) for slot, kind in kinds.items()}
        return all(
            re.fullmatch(patterns[slot], value.strip('"`'), re.IGNORECASE)
            for slot, value in slots.items()
            if slot in patterns
        )

    def _ranked(self, text: str, without: str | None) -> list["_Candidate"]:
        """The claims whose slots the sentence can fill, the likeliest first."""
        seen: dict[frozenset[str], tuple[list[tuple[str, str, str]], frozenset[str]] | None] = {}
        nearest: dict[str, tuple[float, dict[str, str], frozenset[str]]] = {}
        missing: _Phrase | None = None
        for phrase in self._phrases:
            if phrase.source == without:
                missing = phrase
                continue
            kinds = frozenset(kind for _, kind in phrase.kinds)
            if kinds not in seen:
                seen[kinds] = self._parts(text, kinds)
            if (parts := seen[kinds]) is None:
                continue
            values, words = parts
            slots = self._filled(phrase, values)
            if slots is not None:
                agrees = self._agrees(words, phrase.words)
                if agrees > nearest.get(phrase.claim, (-1.0,))[0]:
                    nearest[phrase.claim] = agrees, slots, words
        found = []
        for name, (agrees, slots, words) in nearest.items():
            if not self._same_sense(words, name, missing):
                continue
            gone = missing.words if missing is not None and missing.claim == name else frozenset()
            total = self._totals[name] - bool(gone)
            has = {word: self._having[name, word] - (word in gone) for word in words}
            likely = sum(math.log((number + 0.2) / (total + 1.0)) for number in has.values())
            new = [word for word in words if not has[word] and word not in self._table.fillers]
            few = FOREIGN * len(self._totals)
            foreign = any(word in self._claims and len(self._claims[word]) < few for word in new)
            foreign |= bool(new) and not slots  # nothing but the words says what is meant
            strange = sum(word not in self._claims for word in new)
            foreign |= not any(has[word] and len(self._claims[word]) < OWN * len(self._totals) for word in words)
            found.append(_Candidate(name, agrees, likely, foreign, strange, slots))
        return sorted(found, key=lambda each: -each.likely)

    def _turns_of(self, words: frozenset[str]) -> tuple[bool, ...]:
        """Which of the groups of words that turn the sense there are; the last one is of the past."""
        return tuple(bool(words & group) for group in (*self._table.senses, _PAST))

    def _same_sense(self, words: frozenset[str], claim: str, without: _Phrase | None) -> bool:
        """Whether the words turn the sense as a phrase of the claim does, and are of the past only if one is."""
        mine = self._turns_of(words)
        turns = self._turns[claim]
        if without is not None and without.claim == claim:
            turns = turns - Counter([self._turns_of(without.words)])
        total = turns.total()
        for i, has in enumerate(mine):
            number = sum(count for each, count in turns.items() if each[i])
            if (has and not number) or (not has and number == total):
                return False
        return any(each[:-1] == mine[:-1] for each in turns)

    def _agrees(self, mine: frozenset[str], its: frozenset[str]) -> float:
        """How much the words agree: twice the weight of the shared ones over the weight of all."""
        both = sum(self._weight(word) for word in mine & its)
        return 2 * both / (sum(map(self._weight, mine)) + sum(map(self._weight, its)) or 1.0)

    def _weight(self, word: str) -> float:
        return self._weights.get(word, self._strange)

    def _plain(self, text: str) -> str:
        """A text with synonyms as the phrases have them, numbers in digits and no contractions; quotations stay."""
        parts = _KEPT.split(text)
        return "".join(part if i % 2 else self._reworded(part) for i, part in enumerate(parts))

    def _reworded(self, text: str) -> str:
        for short, whole in _SHORT.items():
            text = re.sub(rf"{short}\b", whole, text, flags=re.IGNORECASE)
        text = _ORDINAL.sub(lambda found: f"{found[2]} {_ORDINALS[found[1].lower()]}", text)
        text = _WORD_NUMBER.sub(lambda found: f"{_DIGITS[found[0].lower()]}", text)
        for pattern, word in self._synonyms:
            text = pattern.sub(word, text)
        return text

    def _spelt(self, text: str) -> str:
        """A text with words that a single slip keeps from being known ones put right."""

        def right(found: re.Match[str]) -> str:
            word = found[0].lower()
            if word in self._weights or not found[0][1:].islower():
                return found[0]
            near = [known for known in self._known if known[0] == word[0] and _slipped(word, known)]
            return near[0] if len(near) == 1 else found[0]

        parts = _KEPT.split(text)
        return "".join(part if i % 2 else _WORD.sub(right, part) for i, part in enumerate(parts))

    def _parts(self, text: str, kinds: frozenset[str]) -> tuple[list[tuple[str, str, str]], frozenset[str]] | None:
        """What can stand in slots of these kinds, each with its kind and the word before; and the other words.

        None if there is something else that could stand in a slot, or a part of an action that stands in one.
        """
        for kind in self._named - kinds:
            if re.search(rf"(?<![\w-])(?:{kind})(?![\w-])", text, re.IGNORECASE):
                return None
        found: list[tuple[int, str, str, str]] = []

        def take(kind: str, match: re.Match[str]) -> str:
            value = next((group for group in match.groups() if group is not None), match[0])
            before = re.findall(r"[\w']+", match.string[: match.start()])
            found.append((match.start(), kind, value, before[-1].lower() if before else ""))
            return "\0" * (match.end() - match.start())

        for kind in sorted(kinds, key=_looked_for):
            pattern = _PATTERNS.get(kind, kind)
            if kind not in (QUOTED, LIST, NUMBER):
                pattern = rf"(?<![\w-])[\"`]?({pattern})[\"`]?(?![\w-])"
            text = re.sub(pattern, partial(take, kind), text, flags=re.IGNORECASE)
        if any(pattern.search(text) for pattern in self._entities):
            return None
        return [part[1:] for part in sorted(found)], _words(text.replace("\0", " "))

    def _filled(self, phrase: _Phrase, values: Sequence[tuple[str, str, str]]) -> dict[str, str] | None:
        """The values in a phrase's slots, if they fit; the action of a verdict may be missing."""
        wanted = list(phrase.kinds)
        if len(values) < len(wanted):
            cls = self._classes[phrase.claim]
            if not (issubclass(cls, ActionClaim) and cls.kind in (HP, HN) and cls.action_slot):
                return None
            wanted = [(slot, kind) for slot, kind in wanted if slot != cls.action_slot]
        if sorted(kind for _, kind in wanted) != sorted(kind for kind, _, _ in values):
            return None
        slots: dict[str, str] = {}
        for kind in {kind for _, kind in wanted}:
            names = [slot for slot, its in wanted if its == kind]
            found = [(value, cue) for its, value, cue in values if its == kind]
            order = self._ordered(phrase, names, [cue for _, cue in found])
            if order is None:
                return None
            slots |= {name: found[i][0] for name, i in zip(names, order, strict=True)}
        return slots

    @staticmethod
    def _ordered(phrase: _Phrase, names: Sequence[str], cues: Sequence[str]) -> Sequence[int] | None:
        """Which of several values of a kind stands in which slot, by the words before them; None if that is open."""
        if len(names) == 1:
            return (0,)
        own = dict(zip((slot for slot, _ in phrase.kinds), phrase.cues, strict=True))
        if len(names) > 5:
            return None
        orders = permutations(range(len(names)))
        scored = [(sum(own[name] == cues[i] for name, i in zip(names, order, strict=True)), order) for order in orders]
        ranked = sorted(scored, reverse=True)
        (most, first), (next_most, _) = ranked[:2]
        return first if most > next_most and most >= len(names) - 1 else None

    def _phrase(self, name: str, source: str) -> _Phrase | None:
        """A phrase, if each of its slots has a kind."""
        text = ""
        kinds: list[tuple[str, str]] = []
        cues: list[str] = []
        for literal, slot, spec, _ in string.Formatter().parse(source):
            text += literal
            if slot is None:
                continue
            quoted = text[-1:] in ('"', "`")
            kind = self._kinds[name].get(slot) or (NUMBER if spec else QUOTED if quoted else None)
            if kind is None or slot in (known for known, _ in kinds):
                return None
            kinds.append((slot, kind))
            before = re.findall(r"[\w']+", self._reworded(text))
            cues.append(before[-1].lower() if before else "")
            text += " \0 "
        return _Phrase(
            name,
            source,
            tuple(kinds),
            tuple(cues),
            _words(self._plain(text.replace("\0", " ").replace('"', " ").replace("`", " "))),
        )


def _kinds_of(cls: type[Claim], table: Synonyms) -> dict[str, str]:
    """The kinds of a class's slots, as far as its fields and the table say."""
    kinds = {field.name: NUMBER for field in fields(cls) if _is_number(field.type)}  # type: ignore[arg-type]  # a dataclass
    for name, names in names_of(cls).items():
        kinds[name] = _any_of(names)
    for key, kind in sorted(table.slots.items(), key=lambda item: "." in item[0]):
        owner, _, name = key.rpartition(".")
        if owner in ("", cls.__name__):
            kinds[name] = {"<list>": LIST, "<number>": NUMBER}.get(kind, kind)
    return {name: kind for name, kind in kinds.items() if kind}


def _any_of(texts: Iterable[str]) -> str:
    """The pattern of some texts, the longest first."""
    return "|".join(map(re.escape, sorted(texts, key=lambda text: (-len(text), text))))


def _is_vague(cls: type[Claim]) -> bool:
    """Whether people's words for other claims are too near: advice without content, and rules of all worlds."""
    if cls.scope is Scope.FAMILY:
        return True
    return issubclass(cls, Grounded) and cls.kind in (FP, FN) and not fields(cls)  # type: ignore[arg-type]  # a dataclass


def _is_number(kind: Any) -> bool:
    return getattr(kind, "__origin__", kind) in (int, float)


def _words(text: str) -> frozenset[str]:
    return frozenset(re.findall(r"[a-z0-9']+", text.lower()))


def _slipped(word: str, known: str) -> bool:
    """Whether two letters are exchanged, or one is missing or too many."""
    if len(word) == len(known):
        return OSA.distance(word, known) == 1 and sorted(word) == sorted(known)
    if f"{word}s" == known or word == f"{known}s":  # both are words
        return False
    return len(word) >= 5 and abs(len(word) - len(known)) == 1 and OSA.distance(word, known) == 1


def _looked_for(kind: str) -> tuple[int, int]:
    """Quotations and lists are looked for first, numbers last, long patterns before short ones."""
    return {QUOTED: 1, LIST: 0, NUMBER: 3}.get(kind, 2), -len(kind)


_BLANK = str.maketrans('\0"`', "   ")
_KEPT = re.compile(r"(\"[^\"]*\"|`[^`]*`|\[[^\[\]]*\]|\{[^{}]*\})")  # what is not put into other words
_WORD = re.compile(r"(?<![\w-])[A-Za-z]{4,}(?![\w-])(?! \d)")
_ORDINAL = re.compile(rf"\b({'|'.join(_ORDINALS)}) (\w+)\b", re.IGNORECASE)
_WORD_NUMBER = re.compile(rf"\b(?:{'|'.join(sorted(_DIGITS, key=len, reverse=True))})\b", re.IGNORECASE)
