"""Recognises the phrases of phrasebooks in a text, word for word."""

import copy
import itertools
import math
import re
from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from operator import itemgetter
from typing import Any, NamedTuple

from pz_envs.text.phrase_matching import Beginnings, Place, Sentence, Text
from teachers.atoms import ActionClaim, Claim
from teachers.common import Late, Probably
from teachers.phrasebook import Phrasebook
from teachers.schema import sentences_of
from teachers.voice import PLAIN


class FoundPhrase(NamedTuple):
    """A phrase that was found in a text."""

    claim: type[Claim[Any]]
    """The class of its claim."""
    slots: dict[str, str]
    """The text in each slot."""
    about_turn: int | None
    """The turn that the phrase names; None: it names none."""
    span: tuple[int, int]
    """Its beginning and end in the text."""
    framed: int
    """The beginning of the words before it that name its turn or hedge it."""
    hedged: bool
    """Whether those words hedge it."""


class Reader:
    """Finds the phrases of all voices in texts.

    It tries the latest voice first, and the other voices only if the latest has no such phrase.

    Args:
        phrasebook: returns the phrasebook of a voice; called when the voice is first needed.
        voices: names of the voices.
        is_action: whether a text names an action, as the text in an action's slot must; None: any text does.
        fits: whether texts can fill the slots of a claim; None: any can.
    """

    def __init__(
        self,
        phrasebook: Callable[[str], Phrasebook],
        voices: Sequence[str] = (PLAIN,),
        is_action: Callable[[str], bool] | None = None,
        fits: Callable[[type[Claim[Any]], dict[str, str]], bool] | None = None,
    ) -> None:
        self._phrasebook, self._is_action, self._fits = phrasebook, is_action, fits
        self._voices = self._order = tuple(voices)  # the order has the latest voice first
        self._lines: Beginnings[_Line] = Beginnings()
        self._learnt: set[str] = set()

    def anew(self) -> "Reader":
        """The same reader before its first text; both share the phrases that they learn."""
        other = copy.copy(self)
        other._order = self._voices
        return other

    def read(self, text: str) -> Iterator[FoundPhrase]:
        """The phrases in a text, in order; other text is skipped. The time is linear in the text's length."""
        heard = Text(text)
        at = 0
        about: int | None = None
        framed, hedged = 0, False
        while at < len(text):
            best = self._recognise(heard, at)
            if best and best.line.claim in _FRAMES:
                if best.line.claim is Late:
                    about = int(heard[best.place.slots["turn"]])
                hedged |= best.line.claim is Probably
                at = best.place.end
                continue
            if best:
                slots = {name: heard[span] for name, span in best.place.slots.items()}
                yield FoundPhrase(best.line.claim, slots, about, (at, best.place.end), framed, hedged)
                at = best.place.end
            else:
                at = heard.next(self._lines if self._learnt.issuperset(self._voices) else None, at)
            about = None
            while at < len(text) and text[at].isspace():
                at += 1
            framed, hedged = at, False

    def _recognise(self, text: Text, at: int) -> "_Found | None":
        """The phrase that begins here, or the words that name the next phrase's turn or hedge it; None: neither."""
        best: _Found | None = None
        tried: set[tuple[Any, ...]] = set()
        lines = text.beginning(self._lines, at)
        for number, voice in enumerate(self._order):
            if voice not in self._learnt:
                self.learn(voice)
                lines = text.beginning(self._lines, at)
            for line in lines:
                what = line.claim, line.sentence
                if line.voice == voice and what not in tried:
                    tried.add(what)  # many voices share it
                    if place := line.sentence.match(text, at):
                        found = self._found(line, place, text, at, number * _MANY + line.number)
                        best = found if best is None else min(best, found, key=_RANK)
            if best and not best.doubtful:
                break
        if best and best.line.claim not in _FRAMES:
            self._order = best.line.voice, *(voice for voice in self._order if voice != best.line.voice)
        return best

    def learn(self, voice: str) -> None:
        """Add the phrases of a voice that is not known yet."""
        self._learnt.add(voice)
        number = itertools.count()
        for claim, templates in self._phrasebook(voice).items():
            for template in templates:
                line = _Line(next(number), voice, claim, _sentence(template, claim in _FRAMES))
                for beginning in line.sentence.beginnings:
                    self._lines.add(beginning, line)

    def _found(self, line: "_Line", place: Place, text: Text, at: int, rank: int) -> "_Found":
        if line.claim in _FRAMES:
            return _Found(False, -math.inf, 0, rank, line, place)
        doubtful = any(map(text.has_end, place.slots.values()))
        if not doubtful and self._is_action and issubclass(line.claim, ActionClaim):
            span = place.slots.get(line.claim.action_slot)
            doubtful = span is not None and not self._is_action(text[span])
        if not doubtful and self._fits:
            doubtful = not self._fits(line.claim, {name: text[span] for name, span in place.slots.items()})
        in_slots = sum(end - begin for begin, end in place.slots.values())
        own = place.end - at - in_slots
        # Of doubtful readings the shortest is best; of the others, the one with most text outside slots.
        return _Found(doubtful, place.end if doubtful else -own, in_slots, rank, line, place)


class _Line(NamedTuple):
    """A template of a phrasebook."""

    number: int
    """Counts the templates of the voice."""
    voice: str
    claim: type[Claim[Any]]
    sentence: Sentence


class _Found(NamedTuple):
    """A candidate for a phrase. The first four fields are its rank: the smallest is best."""

    doubtful: bool
    """Whether a slot holds more than one sentence, or no action where it must hold one."""
    size: float
    in_slots: int
    """Number of characters in slots."""
    number: int
    """Order of equal readings: the later voice, then the earlier template."""
    line: _Line
    place: Place


_FRAMES = (Late, Probably)  # claims around another claim, whose sentence is read without the words before it
_MANY = 1_000_000  # more than a voice has templates
_RANK = itemgetter(slice(4))


@cache
def _sentence(template: str, frame: bool) -> Sentence:
    """The sentence of a template; of a frame only the words before the other claim's sentence."""
    if frame:
        words = template.removesuffix("{text}")
        return Sentence(words.replace("{turn}", "{turn:d}").replace("{percent}", "{percent:d}"), ends=False)
    return Sentence(template)


class SentenceReading(NamedTuple):
    """A sentence of people or models, and the claim that it states if it is word for word a phrase."""

    text: str
    claim: type[Claim[Any]] | None
    """The class of the claim; None: the sentence is no phrase."""
    slots: dict[str, str]
    """The text in each slot of the phrase; a verdict on the last action may lack the action."""
    about_turn: int | None
    """The turn that the sentence names; None: it names none."""
    hedged: bool
    """Whether the sentence only hedges the claim, and is neither true nor false."""


def read_sentences(reader: Reader, text: str) -> list[SentenceReading]:
    """The readings of all sentences of a text, in order, phrases or not.

    A phrase is read if it is a whole sentence. Quotations are not read, nor sentences beside one that takes them back.
    """
    phrases: list[tuple[SentenceReading | None, tuple[int, int]]]
    phrases = [(None, (0, 0)), *_phrases_in(reader, text), (None, (len(text), len(text)))]
    gaps = [(at, end) for (_, (_, at)), (_, (end, _)) in itertools.pairwise(phrases)]
    marks = [mark.start() for gap in gaps for mark in _MARK.finditer(text, *gap)]

    def is_quoted(begin: int, said: str) -> bool:
        first = begin + next(i for i, letter in enumerate(said) if letter.isalnum())
        i = bisect_left(marks, first)
        return i % 2 == 1 and i < len(marks) and (marks[i - 1] < begin or marks[i] >= begin + len(said.rstrip(_ENDS)))

    found: list[SentenceReading] = []
    for (at, end), (reading, _) in zip(gaps, phrases[1:], strict=True):
        for sentence in sentences_of(text[at:end]):
            at = text.index(sentence, at)
            found.append(_unread(sentence) if is_quoted(at, sentence) else _alone(reader, sentence))
            at += len(sentence)
        if reading:
            found.append(_unread(reading.text) if is_quoted(end, reading.text) else reading)
    for order, before in ((range(len(found))[::-1], True), (range(len(found)), False)):
        back = False
        for i in order:
            if found[i].claim is None:
                back = bool(_TAKES_BACK.search(found[i].text) or (before and _NOT.search(found[i].text)))
            elif back:
                found[i] = _unread(found[i].text)
    return found


def _phrases_in(reader: Reader, text: str) -> Iterator[tuple[SentenceReading, tuple[int, int]]]:
    """The phrases in a text that are whole sentences, and their places."""
    last = 0
    for heard in reader.read(text):
        begin, end = span = heard.framed, heard.span[1]
        between = text[last:begin].rstrip(" ")
        if not between or between[-1] == "\n" or between.rstrip(_ENDS[3:])[-1:] in _ENDS[:3]:
            last = end
            yield SentenceReading(text[begin:end], heard.claim, heard.slots, heard.about_turn, heard.hedged), span


def _alone(reader: Reader, sentence: str) -> SentenceReading:
    """The reading of one sentence, which may be a phrase as a whole."""
    whole = (reading for reading, span in _phrases_in(reader, sentence) if span == (0, len(sentence)))
    return next(whole, _unread(sentence))


def _unread(text: str) -> SentenceReading:
    return SentenceReading(text, None, {}, None, False)


_ENDS = ".!?\"')]\u201d\u2019"  # quotation marks of books close, too
_OPEN, _CLOSED = "['\u2018]", "['\u2019]"
_MARK = re.compile(rf'["\u201c\u201d\u201e\u00ab\u00bb]|(?<!\w){_OPEN}(?=\w)|(?<=[.!?,]){_CLOSED}(?!\w)')
_NOT = re.compile(r"(?:^|[.,;:!])\s*(?:not|no|never|nothing|none|nowhere|nobody|neither)\W*$", re.I)  # "Go west. Not!"
_TAKES_BACK = re.compile(
    r"(?<![\w'])(?:kidding|joking|teasing|jokes?|(?:forget|scratch|strike|ignore) (?:it|that|this|what)|never mind"
    r"|(?:take|taking|took) (?:it|that|this) back|liars?|lied|lying|lies|untrue|not true|opposite|april fool\w*|psych"
    r"|gotcha|or not|not listen|not really|disregard|nonsense|rubbish|hoax|made (?:it|that) up|meant the other"
    r"|far from (?:it|the truth)|on second thoughts?|correction|wait, no|(?:did not|didn't) mean|not serious|not trust"
    r")(?!\w)",
    re.I,
)
"""Words of a sentence that takes back the sentences beside it; they only keep sentences from being read."""
