"""Phrasebooks put claims into words. The words are data, in `phrases/<family>.toml`; for tones see `teachers.voice`."""

import itertools
import tomllib
from collections.abc import Callable, Mapping, Sequence, Set
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from typing_extensions import override

from teachers.atoms import UNDECORATED, Atom, Claim, FeedbackType, Utterance, is_decorated, path_of, slots_of
from teachers.common import Late, Probably
from teachers.oracle import claims_of
from teachers.templates import Template, cache_key, slots, statements, timeless
from teachers.voice import LEAST, MOST, PLAIN, SENTENCE, Change, Tone, Voice, load_tone, rewrite, voice_names

Paraphrase = str | int | Callable[..., str]
"""`"random"`, the index of a paraphrase (modulo their number), or a function `(templates, **slots) -> str`."""

_FRAMES = (Late, Probably)  # claims with another claim, whose sentence their phrases end with
_TEXT = "text"  # the slot for that sentence


_Ways = tuple[Template, ...]


class _Templates(dict[type[Claim], _Ways]):
    """Templates by claim class."""

    def __missing__(self, cls: type[Claim]) -> tuple[Template, ...]:
        known = ", ".join(sorted(each.__name__ for each in self))
        raise ValueError(f"the claim {cls.__name__} has no phrases; there are phrases of: {known}")


class Phrasebook:
    """The paraphrases of every claim class; those of one class all say exactly the same.

    Args:
        phrases: the templates by name of the claim class; `teachers.atoms.slots_of` gives their slots.
        claims: the classes that must have phrases, and no others.
        source: where the phrases come from, for error messages.

    Raises:
        ValueError: one error that lists every claim without phrases, phrase without claim, unknown slot,
            slot that some paraphrases leave out, duplicate, and class with fewer than 4 or more than 20 paraphrases.
    """

    def __init__(self, phrases: dict[str, list[str]], claims: Sequence[type[Claim]], source: str) -> None:
        problems = list(_problems(phrases, claims))
        if problems:
            raise ValueError(f"bad phrases in {source}:\n  " + "\n  ".join(problems))
        self._set(_Templates({cls: tuple(map(Template, phrases[cls.__name__])) for cls in claims}))

    def _set(
        self, templates: _Templates, stated: _Templates | None = None, hedges: Mapping[Any, _Ways] | None = None
    ) -> None:
        """Set the templates.

        Args:
            templates: by claim class.
            stated: those for hedged claims; None takes all that are statements.
            hedges: templates of `Probably` by kind, where they are not those of the class.
        """
        self._templates = templates
        self._stated = _Templates({c: statements(t) or t for c, t in templates.items()}) if stated is None else stated
        self._hedges = dict(hedges or {})
        self._drawn = {cls: (cache_key(cls), each, len(each)) for cls, each in templates.items() if cls not in _FRAMES}
        """What `say` needs for a random paraphrase, by claim class; those of `_FRAMES` are left out."""

    def __or__(self, other: "Phrasebook") -> "Phrasebook":
        """A phrasebook with the phrases of both."""
        both = object.__new__(Phrasebook)
        both._templates = _Templates(self._templates | other._templates)
        both._stated = _Templates(self._stated | other._stated)
        both._hedges = self._hedges | other._hedges
        both._drawn = self._drawn | other._drawn
        return both

    def toned(self, tone: Tone, own: Mapping[str, list[str]], source: str) -> "Phrasebook":
        """The phrasebook in a tone: the phrases in `own`, and for all other classes plain ones in frames.

        Raises:
            ValueError: one error that lists all problems of `own`; its slots must be those of the plain phrases.
        """
        words = Phrasebook(dict(own), [cls for cls in self._templates if cls.__name__ in own], source)
        problems = []
        for cls, templates in words._templates.items():
            plain = slots(self._templates[cls][0].source)
            if slots(templates[0].source) != plain:
                problems.append(f"{cls.__name__}: its slots must be {', '.join(sorted(plain)) or 'none'}")
        if problems:
            raise ValueError(f"bad phrases in {source}:\n  " + "\n  ".join(problems))
        framed = {cls: tuple(map(Template, tone.frame(_kind(cls), plain))) for cls, plain in self.items()}
        every = _Templates(framed | words._templates)
        # Frames surround a hedge, not the sentence in it. So that sentence is plain, except in a voice without frames.
        # Those of a verdict take it for granted, so that a hedged verdict has none.
        stated = {
            cls: (() if _kind(cls) in tone.frames else statements(each)) or self._stated[cls]
            for cls, each in every.items()
        }
        bare = [hedge.source for hedge in every.get(Probably, ())]
        hedges = {
            kind: tuple(Template(frame.replace(SENTENCE, hedge)) for frame in frames for hedge in bare)
            for kind, frames in tone.frames.items()
            if kind not in (FeedbackType.HP, FeedbackType.HN)
        }
        toned = object.__new__(Phrasebook)
        toned._set(every, _Templates(stated), hedges)
        return toned

    def __deepcopy__(self, memo: dict[int, Any]) -> "Phrasebook":
        return self  # immutable

    def templates(self, cls: type[Claim]) -> tuple[str, ...]:
        """The paraphrases of a claim class; of a hedge, also with the frames of each kind around it."""
        framed = itertools.chain.from_iterable(self._hedges.values()) if cls is Probably else ()
        return tuple(dict.fromkeys(template.source for template in (*self._templates[cls], *framed)))

    @property
    def classes(self) -> Set[type[Claim]]:
        """The claim classes."""
        return self._templates.keys()

    def items(self) -> list[tuple[type[Claim], tuple[str, ...]]]:
        """Every claim class with its paraphrases."""
        return [(cls, self.templates(cls)) for cls in self._templates]

    def sentences(self, claim: Claim) -> tuple[str, ...]:
        """The claim in each of its paraphrases."""
        return self._sentences(claim)

    def _sentences(self, claim: Claim, **within: bool) -> tuple[str, ...]:
        inner: tuple[str | None, ...] = (None,)
        if isinstance(claim, _FRAMES):
            inner = self._sentences(claim.claim, **within | _within(claim))
        return tuple(_format(template, claim, text) for text in inner for template in self._ways(claim, **within))

    def _ways(self, claim: Claim, late: bool = False, hedged: bool = False) -> _Ways:
        """The templates of a claim, as the words of one that is late or hedged."""
        cls = type(claim)
        if cls is Probably:
            ways = self._hedges.get(claim.kind) or self._templates[cls]
        else:
            ways = (self._stated if hedged else self._templates)[cls]
        return timeless(ways) if late else ways

    def has(self, atom: Atom, turn: int) -> bool:
        """Whether the text of an atom, said in this turn, is one of its claim's paraphrases."""
        claim = atom.claim if atom.about_turn == turn else Late(claim=atom.claim, turn=atom.about_turn)
        return type(atom.claim) in self._templates and atom.text in self.sentences(claim)

    def words(self, claim: Claim) -> float:
        """The mean number of words of the claim's paraphrases."""
        sentences = self.sentences(claim)
        return sum(len(sentence.split()) for sentence in sentences) / len(sentences)

    def say(self, claims: Sequence[Claim], turn: int, draws: "Draws", paraphrase: Paraphrase) -> Utterance:
        """Put claims into words. It draws one number for each claim, used or not."""
        atoms = []
        texts = []
        ways = self._drawn if paraphrase == "random" else {}
        at = draws.take(len(claims))
        numbers = draws.numbers
        for claim in claims:
            draw = numbers[at]
            at += 1
            if (way := ways.get(claim.__class__)) is not None:
                key_of, templates, count = way
                template = templates[int(draw * count)]
                if key_of is None:
                    text = template.pattern % template.values(claim)
                elif (text := template.cache.get(key := key_of(claim))) is None:
                    text = template.format_cached(key, claim)
                atoms.append(_new_atom(Atom, (claim, text, turn, "")))
            else:
                text = self._word(claim, draw, paraphrase)
                said, about = (claim.claim, claim.turn) if isinstance(claim, Late) else (claim, turn)
                atoms.append(Atom(said, text, about))
            texts.append(text)
        utterance = _new_text(Utterance, " ".join(texts))
        utterance.atoms = tuple(atoms)
        return utterance

    def sentences_of(
        self, claims: Sequence[Claim], numbers: Sequence[float], paraphrase: Paraphrase
    ) -> tuple[str, ...]:
        """The sentence that `say` makes of each claim with these numbers, before a voice rewrites it."""
        return tuple(atom.text for atom in Phrasebook.say(self, claims, 0, Drawn(numbers), paraphrase).atoms)

    def _word(self, claim: Claim, draw: float, paraphrase: Paraphrase, **within: bool) -> str:
        templates, inner = self._ways(claim, **within), None
        if isinstance(claim, _FRAMES):
            inner = self._word(claim.claim, draw, paraphrase, **within | _within(claim))
            draw = draw * 1009 % 1  # the frame uses other digits of the draw than the sentence within it
        if paraphrase == "random":
            template = templates[int(draw * len(templates))]
        elif callable(paraphrase):
            values = {name: getattr(claim, name) for name in slots_of(type(claim))}
            if inner is not None:
                values[_TEXT] = inner
            return str(paraphrase([t.source for t in templates], **values))
        else:
            template = templates[int(paraphrase) % len(templates)]
        return _format(template, claim, inner)


class Rewriting(Phrasebook):
    """A phrasebook whose sentences a function rewrites."""

    def __init__(self, book: Phrasebook, voice: Callable[[str], str]) -> None:
        self._set(book._templates, book._stated, book._hedges)
        self._voice = voice
        self.changes: tuple[Change, ...] = ()
        """Changes of numbers and names in the last utterance."""

    def __deepcopy__(self, memo: dict[int, Any]) -> "Rewriting":
        twin = Rewriting(self, self._voice)
        twin.changes = self.changes
        return twin

    def say(self, claims: Sequence[Claim], turn: int, draws: "Draws", paraphrase: Paraphrase) -> Utterance:
        """Put claims into words and rewrite the sentences."""
        said, self.changes = rewrite(super().say(claims, turn, draws, paraphrase), self._voice)
        return said


def _kind(cls: type[Claim]) -> FeedbackType | None:
    """The kind whose frames surround a class's phrases; None for classes of no fixed kind or not about the student."""
    return cls.kind if isinstance(cls.kind, FeedbackType) and not cls.tried else None


class Draws:
    """Uniform random numbers from a generator, drawn many at a time."""

    _BULK = 256

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self.numbers: list[float] = []
        """The drawn numbers, in [0, 1)."""
        self._left = 0  # of these, from their beginning on

    def take(self, n: int) -> int:
        """Take the next `n` numbers; return the index of the first in `numbers`."""
        end = self._left
        if end < n:
            self.numbers[end:] = self._rng.random(self._BULK + n).tolist()
            end = len(self.numbers)
        self._left = begin = end - n
        return begin


class Drawn(Draws):
    """Numbers from an earlier draw.

    Args:
        numbers: one for each claim.
    """

    def __init__(self, numbers: Sequence[float]) -> None:
        self.numbers = list(numbers)

    @override
    def take(self, n: int) -> int:
        return 0


# With the cached sentences of templates, these bare constructors take a sixth off a turn of bandits.
_new_atom = tuple.__new__
_new_text = str.__new__


def check_paraphrase(paraphrase: Paraphrase) -> Paraphrase:
    """Return the argument if it is valid.

    Raises:
        ValueError: it has none of the three forms.
    """
    if (
        paraphrase == "random"
        or callable(paraphrase)
        or (isinstance(paraphrase, int) and not isinstance(paraphrase, bool))
    ):
        return paraphrase
    raise ValueError(
        f"paraphrase must be 'random', an integer or a callable (templates, **slots) -> str, got {paraphrase!r}"
    )


def _format(template: Template, claim: Claim, inner: str | None) -> str:
    """The sentence for a claim; `inner` is the sentence of the claim that it wraps, if any."""
    if inner is None:
        return template.format(claim)
    own = {name: getattr(claim, name) for name in slots(template.source) - {_TEXT}}
    return template.source.format(**own, **{_TEXT: inner})


def _within(claim: Late | Probably) -> dict[str, bool]:
    """The argument of `_ways` for the claim in another claim."""
    return {"late": True} if isinstance(claim, Late) else {"hedged": True}


def _slots(cls: type[Claim]) -> set[str]:
    """The allowed slots of a class."""
    own = set(slots_of(cls))
    return own - {"claim"} | {_TEXT} if cls in _FRAMES else own


def _problems(phrases: dict[str, list[str]], claims: Sequence[type[Claim]]) -> Any:
    names = {cls.__name__ for cls in claims}
    yield from (f"{name}: there is no claim of this name" for name in phrases if name not in names)
    seen: dict[str, str] = {}
    for cls in claims:
        if not is_decorated(cls):
            yield f"{cls.__name__}: {path_of(cls)} {UNDECORATED}"
            continue
        name, fields = cls.__name__, _slots(cls)
        templates = phrases.get(name)
        if templates is None:
            yield f"{name}: has no phrases"
            continue
        if not isinstance(templates, list) or not all(isinstance(template, str) for template in templates):
            yield f"{name}: must be a list of strings"
            continue
        if not LEAST <= len(templates) <= MOST:
            yield f"{name}: has {len(templates)} paraphrases; allowed: {LEAST} to {MOST}"
        used: dict[str, set[str]] = {}
        for template in templates:
            try:
                has = slots(template)
            except ValueError as error:
                yield f"{name}: {template!r}: {error}"
                continue
            used[template] = has & fields
            for slot in sorted(has - fields):
                yield f"{name}: {template!r} has a slot {slot!r}; allowed: {', '.join(sorted(fields)) or 'none'}"
            if template in seen:
                yield f"{name}: {template!r} is also a phrase of {seen[template]}"
            seen[template] = name
        for template, has in used.items():
            for slot in sorted(set().union(*used.values()) - has):
                yield f"{name}: {template!r} has no slot {slot!r}, which other paraphrases have"


_COMMON = "teachers.phrases:common.toml"
Phrases = Mapping[Any, Any] | str | Path
"""A user's own phrases; see `make_phrasebook`."""


@cache
def _tables(source: str) -> dict[str, dict[str, list[str]]]:
    package, _, file = source.partition(":")
    return tomllib.loads(resources.files(package).joinpath(file).read_text(encoding="utf-8"))


@cache
def _load(source: str, module: str, voice: str) -> Phrasebook:
    file, tables = source.rpartition(":")[2], _tables(source)
    book = Phrasebook(tables.get(PLAIN, {}), claims_of(module), f"{file} [{PLAIN}]")
    tone = load_tone(voice)
    return book.toned(tone, tables.get(tone.name, {}), f"{file} [{tone.name}]") if tone else book


@cache
def _load_common(voice: str) -> Phrasebook:
    book = _load(_COMMON, "teachers.common", PLAIN)
    tone = load_tone(voice)
    return book.toned(tone, tone.phrases, f"voice {tone.name} [phrases]") if tone else book


def load_phrasebook(source: str, module: str, voice: Voice = PLAIN) -> Phrasebook:
    """The phrases of a family together with the common ones.

    Args:
        source: the TOML file, as `package:file`.
        module: name of the module of the family's claims, as for `claims_of`.
        voice: the tone: a name, the path of a file, or a function that rewrites a sentence.

    Raises:
        ValueError: the voice is unknown, or a file is not valid.
    """
    if callable(voice):
        return Rewriting(load_phrasebook(source, module), voice)
    if f"{voice}" not in voice_names():  # a file may change
        return _load.__wrapped__(source, module, f"{voice}") | _load_common.__wrapped__(f"{voice}")
    return _load(source, module, f"{voice}") | _load_common(f"{voice}")


def make_phrasebook(phrases: Phrases, claims: Sequence[type[Claim]], voice: Voice = PLAIN) -> Phrasebook:
    """A user's own phrases together with the common ones.

    Args:
        phrases: the paraphrases by claim class or name of the class; or the path of a TOML file that has them by name,
            at its top or in one table per voice; `plain` must be complete.
        claims: the classes that phrases can name.
        voice: the tone: a name, the path of a file, or a function that rewrites a sentence.

    Raises:
        ValueError: the voice is unknown, or the phrases are not valid.
    """
    if callable(voice):
        return Rewriting(make_phrasebook(phrases, claims), voice)
    source, tone = "the given phrases", load_tone(voice)
    table: Mapping[Any, Any] = {}
    if isinstance(phrases, Mapping):
        table = phrases
    else:
        source = str(phrases)
        try:
            table = tomllib.loads(Path(phrases).read_text(encoding="utf-8-sig"))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise ValueError(f"cannot read phrases from {source}: {error}") from None
    own: Mapping[Any, Any] = {}
    if table and all(isinstance(value, Mapping) for value in table.values()):
        own = table.get(tone.name, {}) if tone else {}
        table = table.get(PLAIN, {})
        source = f"{source} [{PLAIN}]"
    if any(isinstance(key, type) for key in table):
        claims = [key for key in table if isinstance(key, type)]
    book = Phrasebook(_by_name(table), claims, source)
    if tone:
        book = book.toned(tone, _by_name(own), f"{source.removesuffix(f' [{PLAIN}]')} [{tone.name}]")
    return book | _load_common.__wrapped__(f"{voice}")


def _by_name(table: Mapping[Any, Any]) -> dict[str, Any]:
    return {
        key.__name__ if isinstance(key, type) else key: list(value) if isinstance(value, tuple) else value
        for key, value in table.items()
    }
