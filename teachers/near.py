"""Reading sentences that are nearly a teacher's, by what the phrases themselves teach.

What can stand in a phrase's slots is looked for first, by the slot's kind: a number, a quotation, a list, a name of an
enumeration, or a pattern of the family's table. Claims whose slots the sentence fills are candidates. The other words
decide by classifiers: which of the claims they state, learnt from the family's phrases; which kind of feedback they
are, whether good or bad, and whether of what was done or is to be done, learnt from the phrases of all families; and
whether they state anything, learnt from all phrases and from sentences that state nothing. Where one of these is not
clear, the sentence is not read. The truth of the world is never looked at.

The tables are `synonyms/common.toml` and `synonyms/<family>.toml`. `words` has per word of the phrases what people say
in its place; `slots` the patterns of slots that hold neither number nor enumeration, or `<list>`, `<number>` or
`<action>`, for all claims or, as `Claim.slot`, for one (empty: any text, which only the phrases themselves can have);
`less` has per pair of slots, as `after < before`, the claims that say that the first one is the smaller number;
`nothing` has sentences that state nothing that can be checked.
"""

import itertools
import math
import re
import string
import tomllib
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from functools import cache, cached_property, partial
from importlib import resources
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
import scipy.sparse
from numpy.typing import NDArray
from rapidfuzz.distance import OSA

from teachers.atoms import FN, FP, HN, HP, ActionClaim, Claim, R
from teachers.schema import names_of

__all__ = ["Near", "Nearest", "Synonyms", "load_synonyms"]

NUMBER, QUOTED, LIST, ANY = "number", "quoted", "list", "any"
_PATTERNS = {
    QUOTED: r'"([^"]*)"|`([^`]*)`',
    LIST: r"\"?(\[[^\[\]]*\]|\([^()]*,[^()]*\))\"?",
    NUMBER: r"(?<![\w.-])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w-])",
}
CONFIDENT = 0.135
"""How clear it must be that the best claim is meant: the least of how far it is ahead, twice its own score, how far its
kind is ahead, how near the sentence is to the kind's senses, how sure and how little strained the slots are, and
how far it is ahead that the sentence states anything, with `STATES` added."""
STATES = 0.25
"""The lead that is given to stating anything, since people's words are less like the phrases than other phrases are."""
KIND = 0.15
"""How much each of the score of the kind, its senses and the strain counts for the order of claims."""
_SENSES: Mapping[str, tuple[int, int]] = {HP: (1, 1), HN: (-1, 1), FP: (1, -1), FN: (-1, -1), R: (0, 1)}
"""Per kind, whether it is good (1) or bad (-1), and whether of what was done (1) or is to be done (-1)."""
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
_LONG = [(re.compile(rf"{short}\b", re.IGNORECASE), whole) for short, whole in _SHORT.items()]


class Synonyms(NamedTuple):
    """The synonyms of a family, and the patterns of its slots."""

    words: Mapping[str, Sequence[str]]
    slots: Mapping[str, str]
    less: Mapping[str, Sequence[str]]
    """Per pair of slots, such as `after < before`, the claims whose numbers are in this order."""
    nothing: Sequence[str] = ()
    """Sentences that state nothing that can be checked."""
    doubts: Mapping[str, Sequence[str]] = MappingProxyType({})
    """Per kind of doubt, patterns of words that make a sentence state something else."""


@cache
def load_synonyms(family: str) -> Synonyms:
    """The table of a family, with that of all families."""
    files = (resources.files("teachers.synonyms").joinpath(f"{name}.toml") for name in ("common", family))
    tables = [tomllib.loads(file.read_text(encoding="utf-8")) for file in files if file.is_file()]
    mappings: dict[str, Any] = {
        name: {key: value for table in tables for key, value in table.get(name, {}).items()}
        for name in ("words", "slots", "less", "doubts")
    }
    return Synonyms(**mappings, nothing=[each for table in tables for each in table.get("nothing", ())])


class Nearest(NamedTuple):
    """What a sentence says by this layer."""

    claim: str | None
    """The name of the claim; None: the sentence is not read."""
    slots: dict[str, str]
    """The text in each slot of the nearest claim."""
    candidates: tuple[str, ...]
    """The names of the claims that came nearest, the nearest first."""
    lead: float
    """How clear it is that the nearest claim is meant, as `CONFIDENT` asks; minus infinity if it is open."""


_UNREAD = Nearest(None, {}, (), -math.inf)


class _Value(NamedTuple):
    """What can stand in a slot."""

    at: int
    kind: str
    text: str
    cues: frozenset[str]
    """The words around it, each with the side."""


class _Phrase(NamedTuple):
    """A phrase of a claim."""

    claim: str
    source: str
    kinds: dict[str, str]
    """The slots in their order, each with its kind."""
    cues: tuple[frozenset[str], ...]
    """The words around each slot."""
    words: str
    """What is not in slots."""


class _Candidate(NamedTuple):
    """A claim whose slots a sentence can fill."""

    slots: dict[str, str]
    """Empty texts: it is open which value stands in which slot."""
    strain: float = 0.0
    """How far the words around values, which could stand elsewhere, speak against what the claim's numbers must be."""
    sure: float = 1.0
    """How far the words around values speak for their slots."""
    words: str = ""
    """The other words."""


class _Classifier:
    """Kernel ridge regression from words to labels: one-hot targets; the greatest score is the likeliest label.

    A text is the set of its words, of their triples of letters, and of pairs of words, each weighted by how few texts
    have it, at length 1. A text is left out without a new fit (Rasmussen and Williams, Gaussian Processes for Machine
    Learning, 2006, section 5.4.2).

    Args:
        labelled: texts with their labels; a pair counts once.
        parts_of: gives the parts of a text with their weights.
    """

    def __init__(self, labelled: Iterable[tuple[str, str]], parts_of: Callable[[str], Mapping[str, float]]) -> None:
        self._parts_of = parts_of
        self._at = {each: i for i, each in enumerate(dict.fromkeys(labelled))}
        self._labels = sorted({label for _, label in self._at})
        parts = [parts_of(text) for text, _ in self._at]
        having = Counter(itertools.chain(*parts))
        self._index = {part: i for i, part in enumerate(having)}
        self._rare = np.log1p(len(parts) / np.array([*having.values()], float))
        self._rarest = math.log1p(len(parts))
        at, values = zip(*map(self._vector, parts), strict=True)
        rows = np.repeat(np.arange(len(at)), [*map(len, at)])
        shape = len(at), len(self._index)
        self._texts = scipy.sparse.csr_array((np.concatenate(values), (rows, np.concatenate(at))), shape)
        self._kernel = (self._texts @ self._texts.T).toarray() + np.eye(len(parts))
        targets = np.array([[label == each for each in self._labels] for _, label in self._at], float)
        self._weights = scipy.linalg.solve(self._kernel, targets, assume_a="pos")

    @cached_property
    def _inverse(self) -> NDArray[np.float64]:
        return np.linalg.inv(self._kernel)

    def _vector(self, parts: Mapping[str, float]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """The text of these parts as a vector of length 1, or less if some are not known: its places and values."""
        known = [part for part in parts if part in self._index]
        at = np.array([self._index[part] for part in known], int)
        values = self._rare[at] * [parts[part] for part in known]
        strange = sum((self._rarest * weight) ** 2 for part, weight in parts.items() if part not in self._index)
        length = math.sqrt(values @ values + strange) or 1.0
        return at, values / length

    def scores(self, text: str, without: tuple[str, str] | None = None) -> dict[str, float]:
        """The score of each label, as if a labelled text were not known."""
        weights = self._weights
        if without in self._at:
            i = self._at[without]
            weights = weights - np.outer(self._inverse[:, i], weights[i]) / self._inverse[i, i]
        vector = np.zeros(len(self._index))
        at, values = self._vector(self._parts_of(text))
        vector[at] = values
        alike = self._texts @ vector
        return dict(zip(self._labels, (alike @ weights).tolist(), strict=True))


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
        self._classes = classes
        self._synonyms = [(re.compile(rf"\b(?:{_any_of(each)})\b", re.I), word) for word, each in table.words.items()]
        self._slots = {name: _kinds_of(cls, table) for name, cls in classes.items()}
        self._less = {name: pair.split(" < ") for pair, names in table.less.items() for name in names}
        actions = {name: cls.action_slot for name, cls in classes.items() if issubclass(cls, ActionClaim)}
        known = [self._slots[name][slot] for name, slot in actions.items() if slot in self._slots[name]]
        usual = Counter(known).most_common(1)[0][0] if known else QUOTED
        for kinds in self._slots.values():
            kinds |= {slot: usual for slot, kind in kinds.items() if kind == "<action>"}
        self._named = {*known} - set(_PATTERNS)
        self._phrases = [self._phrase(name, each) for name, sources in phrases.items() for each in sources]
        plain = {word for phrase in self._phrases for word in _words(phrase.words)}
        every = {each for cls in classes.values() for names in names_of(cls).values() for each in names}
        self._entities = [re.compile(each) for each in (*_PATTERNS.values(), _whole(_any_of(every - plain)))]
        self._claim = _Classifier(((each.words, each.claim) for each in self._phrases), partial(_parts_of, pairs=0.25))
        every_kind = [(each.words, self._kind_of(each.claim)) for each in self._phrases]
        every_kind += [(self._plain(_blank(text)), kind) for text, kind in others]
        self._kind = _Classifier(every_kind, _sensed_parts_of)
        nothing = [(words, _NOTHING) for text in table.nothing for words in self._blanked(text)]
        self._states = _Classifier([*((words, _STATED) for words, _ in every_kind), *nothing], _parts_of)
        self._doubts = {kind: _doubt(tuple(each)) for kind, each in table.doubts.items()}
        self._marks = {each.source: self._marks_of(_blank(each.source)) for each in self._phrases}
        self._questions = [each for each in self._phrases if each.source.endswith("?")]

    def _kind_of(self, claim: str) -> str:
        return f"{self._classes[claim].kind}"

    @cached_property
    def _known(self) -> list[str]:
        """The words that a misspelt one may stand for."""
        texts = [phrase.words for phrase in self._phrases]
        texts += [kind for kinds in self._slots.values() for kind in kinds.values()]
        return sorted({word for text in texts for word in re.findall(r"[a-z]{4,}", text.lower())})

    def read(self, sentence: str, without: str | None = None) -> Nearest:
        """Read a sentence.

        Args:
            sentence: of at most 1,000 characters; longer ones are not read, nor questions that begin as no phrase does,
                nor what ends by taking itself back, as in "... Not!", nor what has doubts that its phrases lack.
            without: a phrase that is left out, for measuring.
        """
        if len(sentence) > 1000 or self.takes_back(sentence, before=True):
            return _UNREAD
        text = self._spelt(self._plain(sentence))
        if sentence.rstrip(" \"')`").endswith("?"):
            alike = [each for each in self._questions if _words(each.words)[:2] == _words(text)[:2]]
            if all(each.source == without for each in alike):
                return _UNREAD
        left = next((each for each in self._phrases if each.source == without), None)
        found = self._candidates(text, left)
        if not found:
            return _UNREAD
        worth: dict[str, float] = {}
        clear: dict[str, float] = {}
        for words in {each.words for each in found.values()}:
            scores = self._claim.scores(words, left and (left.words, left.claim))
            kinds = self._kind.scores(words, left and (left.words, self._kind_of(left.claim)))
            states = self._states.scores(words, left and (left.words, _STATED))
            stated = STATES + states[_STATED] - states.get(_NOTHING, 0.0)
            senses = [sum(_SENSES[kind][i] * score for kind, score in kinds.items()) for i in (0, 1)]
            for name in (name for name, each in found.items() if each.words == words):
                kind, strain = self._kind_of(name), found[name].strain
                agree = [1 - abs(sense - its) for sense, its in zip(senses, _SENSES[kind], strict=True)]
                worth[name] = scores[name] + KIND * (kinds[kind] + sum(agree) - strain)
                ahead = kinds[kind] - max((score for other, score in kinds.items() if other != kind), default=0.0)
                clear[name] = min(2 * scores[name], ahead, *agree, found[name].sure, 1 - strain, stated)
        best, *others = sorted(worth, key=lambda name: -worth[name])
        lead = min(clear[best], worth[best] - max((worth[name] for name in others), default=0.0))
        its = Counter(
            itertools.chain(
                *(self._marks[each.source] for each in self._phrases if each.claim == best and each is not left)
            )
        )
        if any(its[mark] <= its[_TURNED.get(mark, "")] for mark in self._marks_of(sentence)):
            lead = -math.inf
        return Nearest(best if lead >= CONFIDENT else None, found[best].slots, (best, *others[:2]), lead)

    def takes_back(self, sentence: str, *, before: bool) -> bool:
        """Whether a sentence says that what stands before it, or behind it, is not meant."""
        pattern = self._doubts.get("taking back")
        return bool((before and _TAKEN_BACK.search(sentence)) or (pattern and pattern.search(_written_out(sentence))))

    def _marks_of(self, text: str) -> frozenset[str]:
        """What a claim's phrases must have, too, if a text states it: doubts, bounds, and the number of negations.

        A bound is on the side where negations of its clause put it. Negations are those of the clause with most.
        """
        text = re.sub(r"\b(?:because|since)\b", ",", _written_out(_KEPT.sub(" # ", text)))
        marks = {kind for kind, pattern in self._doubts.items() if pattern.search(text)}
        negations = 0
        for clause in re.split(r"[.,;:!?]+(?!\d)", self._reworded(text)):
            denied = len(_NEGATION.findall(clause))
            if clause.count(" ", 1) > 1:  # "no, ..." denies nothing that follows
                negations = max(negations, denied)
            for found in _BOUND.finditer(clause):
                marks.add("at least" if bool(found["most"]) == denied % 2 else "at most")
        return frozenset({*marks, f"{negations} negations"})

    def fits(self, claim: str, slots: Mapping[str, str]) -> bool:
        """Whether what stands in a claim's slots is of their kinds, as far as these are known."""
        kinds = self._slots.get(claim, {})
        patterns = {slot: '[^"]*' if kind == QUOTED else _PATTERNS.get(kind, kind) for slot, kind in kinds.items()}
        return all(
            re.fullmatch(patterns[slot], value.strip('"`'), re.IGNORECASE)
            for slot, value in slots.items()
            if slot in patterns
        )

    def _blanked(self, text: str) -> list[str]:
        """The words of a sentence beside what can stand in slots, in each way in which a phrase's slots fit it."""
        kinds = {frozenset(each.kinds.values()): None for each in self._phrases}
        parts = [self._parts(self._plain(text), each) for each in kinds if ANY not in each]
        return [each[1] for each in parts if each]

    def _candidates(self, text: str, without: _Phrase | None) -> dict[str, _Candidate]:
        """The claims whose slots the sentence can fill."""
        seen: dict[frozenset[str], tuple[list[_Value], str] | None] = {}
        found: dict[str, _Candidate] = {}
        for phrase in self._phrases:
            kinds = frozenset(phrase.kinds.values())
            if phrase is without or phrase.claim in found or ANY in kinds:
                continue
            if kinds not in seen:
                seen[kinds] = self._parts(text, kinds)
            if (parts := seen[kinds]) is None:
                continue
            filled = self._filled(phrase, parts[0], without)
            if filled is not None:
                found[phrase.claim] = filled._replace(words=parts[1])
        least = min((len(each.words) for each in found.values() if each.slots), default=0)  # the rest is in slots
        return {name: each for name, each in found.items() if not each.slots or len(each.words) == least}

    def _plain(self, text: str) -> str:
        """A text with synonyms as the phrases have them, numbers in digits and no contractions; quotations stay."""
        parts = _KEPT.split(text)
        return "".join(part if i % 2 else self._reworded(part) for i, part in enumerate(parts))

    def _reworded(self, text: str) -> str:
        text = _written_out(text)
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
            around = _cues(match.string[: match.start()], match.string[match.end() :])
            found.append(_Value(match.start(), kind, value, around))
            return "\0" * (match.end() - match.start())

        for kind in sorted(kinds, key=_looked_for):
            pattern = _PATTERNS.get(kind) or rf"(?<![\w-])[\"`]?({kind})[\"`]?(?![\w-])"
            text = re.sub(pattern, partial(take, kind), text, flags=re.IGNORECASE)
        others = [re.compile(_whole(kind), re.I) for kind in self._named - kinds]
        if any(pattern.search(text) for pattern in (*self._entities, *others)):
            return None
        return sorted(found), re.sub("\0+", " # ", text)

    def _filled(self, phrase: _Phrase, values: Sequence[_Value], without: _Phrase | None) -> _Candidate | None:
        """The values in the slots of a phrase, if they fit; the action of a verdict may be missing."""
        wanted, cls = dict(phrase.kinds), self._classes[phrase.claim]
        if len(values) < len(wanted) and issubclass(cls, ActionClaim) and cls.kind in (HP, HN):
            wanted.pop(cls.action_slot, None)
        if sorted(wanted.values()) != sorted(value.kind for value in values):
            return None
        all_of_it = _Candidate({})
        for kind in {*wanted.values()}:
            names = [slot for slot, its in wanted.items() if its == kind]
            found = [value for value in values if value.kind == kind]
            part = self._ordered(phrase.claim, names, found, without)
            strain, sure = max(all_of_it.strain, part.strain), min(all_of_it.sure, part.sure)
            all_of_it = _Candidate(all_of_it.slots | part.slots, strain, sure)
        return all_of_it

    def _ordered(
        self, claim: str, names: Sequence[str], found: Sequence[_Value], without: _Phrase | None
    ) -> _Candidate:
        """Which of several values stands in which slot, as the words around them, their order and size say."""
        orders = [*itertools.permutations(range(len(names)))] if len(names) <= 5 else [tuple(range(len(names)))]
        if len(orders) == 1:
            return _Candidate(dict(zip(names, (value.text for value in found), strict=True)))
        can = orders
        if {*(pair := self._less.get(claim, ()))} <= {*names} and pair:
            less, more = map(names.index, pair)
            sizes = [float(value.text.split()[0]) for value in found]
            can = [order for order in orders if sizes[order[less]] < sizes[order[more]]]
        if not can:
            return _Candidate(dict.fromkeys(names, ""), sure=0.0)
        fits = dict.fromkeys(orders, 0)
        phrases = 1
        for phrase in self._phrases:
            cues = dict(zip(phrase.kinds, phrase.cues, strict=True))
            if phrase.claim == claim and phrase is not without and set(names) <= set(cues):
                phrases += 1
                mine = [name for name in cues if name in names]
                for order in orders:
                    fits[order] += sum(len(cues[name] & found[i].cues) for name, i in zip(names, order, strict=True))
                    fits[order] += mine == [names[i] for i in np.argsort(order)]
        best, *others = sorted(can, key=lambda order: -fits[order])
        sure = (fits[best] - fits[others[0]]) / phrases if others else 1.0
        slots = {name: found[i].text if sure else "" for name, i in zip(names, best, strict=True)}
        return _Candidate(slots, min(1.0, (max(fits.values()) - fits[best]) / phrases), sure)

    def _phrase(self, name: str, source: str) -> _Phrase:
        """A phrase; where a slot's values have no known form, its kind is `ANY`."""
        parts = [*string.Formatter().parse(source), ("", None, None, None)]
        kinds: dict[str, str] = {}
        cues: list[frozenset[str]] = []
        text = ""
        for (literal, slot, spec, _), (behind, *_) in itertools.pairwise(parts):
            text += literal
            if slot is not None:
                free = NUMBER if spec else QUOTED if text[-1:] in ('"', "`") else ANY
                if slot not in kinds:
                    cues.append(_cues(self._reworded(text), self._reworded(behind)))
                kinds[slot] = ANY if slot in kinds else self._slots[name].get(slot) or free
                text += " # "
        words = self._plain(text.replace('"', " ").replace("`", " "))
        return _Phrase(name, source, kinds, tuple(cues), words)


def _kinds_of(cls: type[Claim], table: Synonyms) -> dict[str, str]:
    """The kinds of a class's slots, as far as its fields and the table say."""
    kinds: dict[str, str] = {field.name: NUMBER for field in fields(cls) if _is_number(field.type)}  # type: ignore[arg-type]  # a dataclass
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


def _parts_of(text: str, pairs: float = 0.5) -> dict[str, float]:
    """The parts by which a text is compared, each with its weight; words behind a negation are parts of their own."""
    words = [re.sub(r"(?<=...)(?:ing|ed|ly|es|s|er|est|e)$", "", word) for word in _words(text)]
    parts = dict.fromkeys(words, 1.0)
    parts |= {f"{word[i : i + 3]}_": 0.3 for word in words if len(word) >= 4 for i in range(len(word) - 2)}
    for i, word in enumerate(words):
        if word in _NOT:
            parts |= {f"not {each}": 0.7 for each in words[i + 1 : i + 5]}
    return parts | {f"{one} {other}": pairs for one, other in itertools.pairwise(["", *words, ""])}


_STATED, _NOTHING = "stated", "nothing"  # labels
_NOT = frozenset({"not", "no", "never", "nothing", "without", "none", "nowhere", "nobody", "neither", "nor"})
_NEGATION = re.compile(rf"\b(?:{'|'.join(sorted(_NOT))})\b", re.IGNORECASE)
_BOUND = re.compile(
    r"\b(?:(?P<most>at most|less than|fewer than|lower than|under|below|within)"
    r"|at least|more than|higher than|over|above|beyond)\b[^\d#.,;:!]{0,12}[-+]?[\d#]",
    re.IGNORECASE,
)
_TURNED = {"at least": "at most", "at most": "at least"}
_TAKEN_BACK = re.compile(rf"(?:^|[.,;:!])\s*(?:{'|'.join(sorted(_NOT))})\W*$", re.IGNORECASE)  # "Pull arm 3. Not!"


def _sensed_parts_of(text: str) -> dict[str, float]:
    """The parts of a text, once more with the sign turned by each negation before them in their clause, and these."""
    turned: dict[str, float] = defaultdict(float)
    for clause in re.split("[.,;:!]+", text):
        for i, segment in enumerate(_NEGATION.split(clause)):
            turned["~not"] -= 4 * (i > 0)
            for part, weight in _parts_of(segment).items():
                turned[f"~{part}"] += (-1) ** i * weight
    return _parts_of(text) | turned


@cache
def _doubt(patterns: tuple[str, ...]) -> re.Pattern[str]:
    return re.compile(rf"(?<![\w'])(?:{'|'.join(patterns)})(?!\w)", re.IGNORECASE)


def _written_out(text: str) -> str:
    """A text without contractions."""
    for short, whole in _LONG:
        text = short.sub(whole, text)
    return text


def _words(text: str) -> list[str]:
    return re.findall(r"[a-z0-9']+|[#?]", text.lower())


def _whole(pattern: str) -> str:
    """A pattern of whole words; an empty one fits nowhere."""
    return rf"(?<![\w-])(?:{pattern or '(?!)'})(?![\w-])"


def _cues(before: str, after: str) -> frozenset[str]:
    """The last two words before a slot, the last one twice, and the first behind it."""
    left, right = re.findall(r"[\w']+", before.lower())[-2:], re.findall(r"[\w']+", after.lower())[:1]
    return frozenset(
        [*(f"{word} _" for word in left), *(f"{word} #" for word in left[-1:]), *(f"_ {word}" for word in right)]
    )


def _blank(source: str) -> str:
    """A phrase with a sign in place of each slot."""
    parts = string.Formatter().parse(source)
    return "".join(literal + " # " * (slot is not None) for literal, slot, *_ in parts)


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


_KEPT = re.compile(r"(\"?\[[^\[\]]*\]\"?|\"[^\"]*\"|`[^`]*`|\{[^{}]*\})")  # what is not put into other words
_WORD = re.compile(r"(?<![\w-])[A-Za-z]{4,}(?![\w-])(?! \d)")
_ORDINAL = re.compile(rf"\b({'|'.join(_ORDINALS)}) (\w+)\b", re.IGNORECASE)
_WORD_NUMBER = re.compile(rf"\b(?:{'|'.join(sorted(_DIGITS, key=len, reverse=True))})\b", re.IGNORECASE)
