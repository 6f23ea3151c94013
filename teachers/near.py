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

import itertools
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

import numpy as np
import scipy.sparse
from rapidfuzz.distance import OSA

from teachers.atoms import HN, HP, ActionClaim, Claim
from teachers.schema import names_of

__all__ = ["Near", "Nearest", "Synonyms", "load_synonyms"]

NUMBER, QUOTED, LIST, ANY = "number", "quoted", "list", "any"
_PATTERNS = {
    QUOTED: r'"([^"]*)"|`([^`]*)`',
    LIST: r"\[[^\[\]]*\]|\([^()]*,[^()]*\)",
    NUMBER: r"(?<![\w.-])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w-])",
}
KIND = 1.0
CONFIDENT = 1.0
OPENINGS = 1
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


class _Value(NamedTuple):
    """What can stand in a slot."""

    at: int
    kind: str
    text: str
    cues: frozenset[str]
    """The words around it, each with the side."""


Kinds = Sequence[tuple[str, str]]


class _Phrase(NamedTuple):
    """A phrase of a claim."""

    claim: str
    source: str
    kinds: tuple[tuple[str, str], ...]
    """The slots in their order, each with its kind."""
    cues: tuple[frozenset[str], ...]
    """The words around each slot."""
    words: str
    """What is not in slots."""


class _Classifier:
    """Kernel ridge regression from words to labels: one-hot targets, the label with the greatest score is likeliest.

    A text is the set of its words and their triples of letters, each weighted by how few texts have it, at length 1.
    Leaving out a text needs no new fit: see Rasmussen and Williams, Gaussian Processes for Machine Learning (2006),
    section 5.4.2.

    Args:
        labels: per text its label; a pair of text and label counts once.
        ridge: the greater, the smoother.
    """

    def __init__(self, labelled: Iterable[tuple[str, str]], ridge: float, pairs_: float = 0.0) -> None:
        self._pairs = pairs_
        pairs = list(dict.fromkeys(labelled))
        self._at = {pair: i for i, pair in enumerate(pairs)}
        self.labels = sorted({label for _, label in pairs})
        parts = [_parts_of(text, pairs_) for text, _ in pairs]
        self._index = {part: i for i, part in enumerate(dict.fromkeys(itertools.chain(*parts)))}
        having = Counter(itertools.chain(*parts))
        self._rare = np.log1p(len(pairs) / np.array([having[part] for part in self._index]))
        self._rarest = math.log1p(len(pairs))
        self._texts = scipy.sparse.vstack([self._vector(each) for each in parts]).tocsr()
        kernel = (self._texts @ self._texts.T).toarray()
        self._inverse = np.linalg.inv(kernel + ridge * np.eye(len(pairs)))
        self._targets = np.array([[label == each for each in self.labels] for _, label in pairs], float)
        self._weights = self._inverse @ self._targets

    def _vector(self, parts: Mapping[str, float]) -> scipy.sparse.csr_array:
        known = [part for part in parts if part in self._index]
        at = [self._index[part] for part in known]
        values = self._rare[at] * [parts[part] for part in known]
        strange = sum((self._rarest * weight) ** 2 for part, weight in parts.items() if part not in self._index)
        length = math.sqrt(values @ values + strange) or 1.0
        return scipy.sparse.csr_array((values / length, ([0] * len(at), at)), shape=(1, len(self._index)))

    def scores(self, text: str, without: tuple[str, str] | None = None) -> dict[str, float]:
        """The score of each label; `without` a text with its label that is left out."""
        weights = self._weights
        if without in self._at:
            i = self._at[without]
            weights = weights - np.outer(self._inverse[:, i], weights[i]) / self._inverse[i, i]
        scores = (self._texts @ self._vector(_parts_of(text, self._pairs)).T).toarray()[:, 0] @ weights
        return dict(zip(self.labels, scores.tolist(), strict=True))


class Near:
    """The near layer for the claims of a family.

    Args:
        classes: the claims by name.
        phrases: per claim its phrases.
        table: of the family.
        others: phrases of other families, each with the kind of its claim.
    """

    def __init__(
        self,
        classes: Mapping[str, type[Claim]],
        phrases: Mapping[str, Iterable[str]],
        table: Synonyms,
        others: Iterable[tuple[str, str]] = (),
    ) -> None:
        self._classes, self._table = classes, table
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
        actions = Counter(
            self._kinds[name].get(cls.action_slot, QUOTED) for name, cls in classes.items() if issubclass(cls, ActionClaim) and cls.action_slot
        )
        usual = actions.most_common(1)[0][0] if actions else QUOTED
        for name in ("first", "second"):
            self._kinds["Better"][name] = usual
        every = {kind for each in self._kinds.values() for kind in each.values()} | set(_PATTERNS)
        self._ids = {kind: f"{i}x" for i, kind in enumerate(sorted(every))}
        self._named = {
            self._kinds[name][cls.action_slot]
            for name, cls in classes.items()
            if issubclass(cls, ActionClaim) and cls.action_slot in self._kinds[name]
        } - set(_PATTERNS)
        self._phrases = [self._phrase(name, each) for name, sources in phrases.items() for each in sources]
        plain = {word for phrase in self._phrases for word in re.findall(r"[a-z]+", phrase.words.lower())}
        names = {name for cls in classes.values() for each in names_of(cls).values() for name in each if name not in plain}
        whole = [rf"(?<![\w-])(?:{_any_of(names)})(?![\w-])"] if names else []
        self._entities = [re.compile(each, re.IGNORECASE) for each in (*_PATTERNS.values(), *whole)]
        self._claim = _Classifier(((phrase.words, phrase.claim) for phrase in self._phrases), 1.0, 0.25)
        kinds = [(_untyped(phrase.words), f"{classes[phrase.claim].kind}") for phrase in self._phrases]
        self._kind = _Classifier([*kinds, *((self._plain(_blank(text)), kind) for text, kind in others)], 0.5, 0.5)
        self._openings: dict[str, set[tuple[str, str]]] = defaultdict(set)
        for phrase in self._phrases:
            if phrase.source.endswith("?"):
                self._openings[_opening(phrase.words)].add((phrase.claim, phrase.source))

    @cached_property
    def _known(self) -> list[str]:
        """The words that a misspelt one may stand for."""
        texts = [*(phrase.words for phrase in self._phrases), *(k for each in self._kinds.values() for k in each.values())]
        return sorted({word for text in texts for word in re.findall(r"[a-z]{4,}", text.lower())})

    def read(self, sentence: str, without: str | None = None) -> Nearest:
        """Read a sentence.

        Args:
            sentence: of at most 1,000 characters; longer ones are not read, nor questions that do not begin as phrases
                of several claims do.
            without: a phrase that is left out, for measuring.
        """
        confidence, claim, slots, names = self.nearest(sentence, without)
        return Nearest(claim if confidence >= CONFIDENT else None, slots if confidence >= CONFIDENT else {}, names)

    def nearest(self, sentence: str, without: str | None = None) -> tuple[float, str | None, dict[str, str], tuple[str, ...]]:
        if len(sentence) > 1000:
            return -math.inf, None, {}, ()
        text = self._spelt(self._plain(sentence))
        if sentence.rstrip(" \"')`").endswith("?"):
            openings = {claim for claim, source in self._openings[_opening(text)] if source != without}
            if len(openings) < OPENINGS:
                return -math.inf, None, {}, ()
        left = next((phrase for phrase in self._phrases if phrase.source == without), None)
        found = self._candidates(text, without)
        if not found:
            return -math.inf, None, {}, ()
        scored: dict[str, tuple[float, float, float]] = {}
        for words in {words for words, _ in found.values()}:
            claims = self._claim.scores(words, left and (left.words, left.claim))
            kinds = self._kind.scores(_untyped(words), left and (_untyped(left.words), f"{self._classes[left.claim].kind}"))
            for name, (its, _) in found.items():
                if its == words:
                    kind = f"{self._classes[name].kind}"
                    scored[name] = claims[name], kinds[kind], max(each for other, each in kinds.items() if other != kind)
        ranked = sorted(scored, key=lambda name: -(scored[name][0] + KIND * scored[name][1]))
        best, rivals = ranked[0], [scored[name] for name in ranked[1:]]
        claim, kind, other = scored[best]
        total = claim + KIND * kind - max((each[0] + KIND * each[1] for each in rivals), default=0.0)
        alone = claim - max((each[0] for each in rivals), default=0.0)
        self.scored = dict(scored)
        self.features = (total, alone, kind - other, claim)
        return total + alone + (kind - other), best, found[best][1], tuple(ranked[:3])

    def _candidates(self, text: str, without: str | None) -> dict[str, tuple[str, dict[str, str]]]:
        """The claims whose slots the sentence can fill, with its other words and the slots."""
        seen: dict[frozenset[str], tuple[list[_Value], str] | None] = {}
        found: dict[str, tuple[str, dict[str, str]]] = {}
        for phrase in self._phrases:
            kinds = frozenset(kind for _, kind in phrase.kinds)
            if phrase.source == without or phrase.claim in found or ANY in kinds:
                continue
            if kinds not in seen:
                seen[kinds] = self._parts(text, kinds)
            if (parts := seen[kinds]) is None:
                continue
            slots = self._filled(phrase.claim, phrase.kinds, parts[0], without)
            if slots is not None:
                found[phrase.claim] = parts[1], slots
        left = min((len(words) for words, slots in found.values() if slots), default=0)
        return {name: each for name, each in found.items() if not each[1] or len(each[0]) == left}

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
            if word in self._known or not found[0][1:].islower():
                return found[0]
            near = [known for known in self._known if known[0] == word[0] and _slipped(word, known)]
            return near[0] if len(near) == 1 else found[0]

        parts = _KEPT.split(text)
        return "".join(part if i % 2 else _WORD.sub(right, part) for i, part in enumerate(parts))

    def _parts(self, text: str, kinds: frozenset[str]) -> tuple[list[_Value], str] | None:
        """What can stand in slots of these kinds, each with its kind and the word before; and the other words.

        None if there is something else that could stand in a slot, or a part of an action that stands in one.
        """
        found: list[_Value] = []

        def take(kind: str, match: re.Match[str]) -> str:
            value = next((group for group in match.groups() if group is not None), match[0])
            found.append(_Value(match.start(), kind, value, _cues(match.string[: match.start()], match.string[match.end() :])))
            return "\0" * (match.end() - match.start())

        for kind in sorted(kinds, key=_looked_for):
            pattern = _PATTERNS.get(kind, kind)
            if kind not in (QUOTED, LIST, NUMBER):
                pattern = rf"(?<![\w-])[\"`]?({pattern})[\"`]?(?![\w-])"
            text = re.sub(pattern, partial(take, kind), text, flags=re.IGNORECASE)
        if any(pattern.search(text) for pattern in self._entities) or any(
            re.search(rf"(?<![\w-])(?:{kind})(?![\w-])", text, re.IGNORECASE) for kind in self._named - kinds
        ):
            return None
        for value in sorted(found, reverse=True):
            text = f"{text[:value.at]} # {text[value.at:].lstrip(chr(0))}"
        return sorted(found), text.replace(chr(0), " ")

    def _filled(self, claim: str, kinds: Kinds, values: Sequence[_Value], without: str | None) -> dict[str, str] | None:
        """The values in the slots of a claim, if they fit; the action of a verdict may be missing."""
        wanted = list(kinds)
        cls = self._classes[claim]
        if len(values) < len(wanted) and issubclass(cls, ActionClaim) and cls.kind in (HP, HN) and cls.action_slot:
            wanted = [(slot, kind) for slot, kind in wanted if slot != cls.action_slot]
        if sorted(kind for _, kind in wanted) != sorted(value.kind for value in values):
            return None
        slots: dict[str, str] = {}
        for kind in {kind for _, kind in wanted}:
            names = [slot for slot, its in wanted if its == kind]
            found = [value for value in values if value.kind == kind]
            order = self._ordered(claim, names, found, without)
            slots |= {name: found[i].text for name, i in zip(names, order, strict=True)}
        return slots

    def _ordered(self, claim: str, names: Sequence[str], found: Sequence[_Value], without: str | None) -> Sequence[int]:
        """Which of several values of a kind most likely stands in which slot, by the words around it and their order."""
        if len(names) == 1 or len(names) > 5:
            return range(len(names))
        phrases = [each for each in self._phrases if each.claim == claim and each.source != without]

        def fit(order: Sequence[int]) -> float:
            fits = 0.0
            for phrase in phrases:
                cues = dict(zip((slot for slot, _ in phrase.kinds), phrase.cues, strict=True))
                if set(names) <= set(cues):
                    alike = [len(cues[name] & found[i].cues) for name, i in zip(names, order, strict=True)]
                    as_it = [name for name in cues if name in names] == [names[i] for i in np.argsort(order)]
                    fits += sum(alike) + as_it
            return fits

        return max(itertools.permutations(range(len(names))), key=fit)

    def _phrase(self, name: str, source: str) -> _Phrase:
        """A phrase; a slot whose values have no known form is of the kind `ANY`, and the sentence is not read."""
        parts = [(literal, slot, spec) for literal, slot, spec, _ in string.Formatter().parse(source)]
        kinds: list[tuple[str, str]] = []
        cues: list[frozenset[str]] = []
        text = ""
        for i, (literal, slot, spec) in enumerate(parts):
            text += literal
            if slot is None:
                continue
            quoted = text[-1:] in ('"', "`")
            kind = self._kinds[name].get(slot) or (NUMBER if spec else QUOTED if quoted else None)
            kind = kind or ANY
            kinds.append((slot, kind))
            cues.append(_cues(self._reworded(text), self._reworded(parts[i + 1][0] if i + 1 < len(parts) else "")))
            text += " # "
        words = self._plain(text.replace('"', " ").replace("`", " "))
        return _Phrase(name, source, tuple(kinds), tuple(cues), words)


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


def _is_number(kind: Any) -> bool:
    return getattr(kind, "__origin__", kind) in (int, float)


def _parts_of(text: str, pairs: float) -> dict[str, float]:
    """The stems of a text's words, their triples of letters, and its pairs of words, each with its weight."""
    words = [_stem(word) for word in re.findall(r"[a-z0-9']+|#\w*|[?]", text.lower())]
    parts = dict.fromkeys(words, 1.0)
    parts |= {f"{word[i : i + 3]}_": 0.3 for word in words if len(word) >= 4 for i in range(len(word) - 2)}
    for i, word in enumerate(words):
        if word in _NOT:
            parts |= {f"not {each}": 0.7 for each in words[i + 1 : i + 5]}
    if pairs:
        parts |= {f"{one} {other}": pairs for one, other in itertools.pairwise(["", *words, ""])}
    return parts


_NOT = frozenset({"not", "no", "never", "nothing", "without", "none"})


def _stem(word: str) -> str:
    """A word without its ending."""
    return re.sub(r"(?<=...)(?:ing|ed|ly|es|s|er|est|e)$", "", word)


def _cues(before: str, after: str) -> frozenset[str]:
    """The last two words before a slot, the last one twice, and the first behind it."""
    left, right = re.findall(r"[\w']+", before.lower())[-2:], re.findall(r"[\w']+", after.lower())[:1]
    return frozenset([*(f"{word} _" for word in left), *(f"{word} #" for word in left[-1:]), *(f"_ {word}" for word in right)])


def _untyped(t):
    return re.sub(r"#\w+", "#", t)


def _opening(text: str) -> str:
    """The first three words."""
    return " ".join(re.findall(r"[a-z0-9']+", text.lower())[:2])


def _blank(source: str) -> str:
    """A phrase without its slots."""
    return "".join(literal + " # " * (slot is not None) for literal, slot, *_ in string.Formatter().parse(source))


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
