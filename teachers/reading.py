"""Recognition of the phrasebooks' sentences in a text, without atoms."""

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from operator import itemgetter
from typing import Any, NamedTuple

from teachers.atoms import ActionClaim, Claim
from teachers.common import Late
from teachers.phrasebook import Phrasebook
from teachers.sentences import Beginnings, Place, Sentence, Text
from teachers.voice import PLAIN


class Heard(NamedTuple):
    """A recognised sentence."""

    claim: type[Claim[Any]]
    """The class of the claim that it expresses."""
    slots: dict[str, str]
    """The text in each slot."""
    about_turn: int | None
    """The turn that the sentence names; None if it names none."""
    span: tuple[int, int]
    """Where it begins and ends in the text."""


class Reader:
    """Recognises the sentences of teachers.

    It looks for a sentence in the latest voice first, and in the other voices only if the latest does not have it.

    Args:
        phrasebook: returns the phrasebook of a voice; called when the voice is first needed.
        voices: names of the voices.
        is_action: whether a text names an action, as an action's slot must; None: any text does.
    """

    def __init__(
        self,
        phrasebook: Callable[[str], Phrasebook],
        voices: Sequence[str] = (PLAIN,),
        is_action: Callable[[str], bool] | None = None,
    ) -> None:
        self._phrasebook, self._is_action = phrasebook, is_action
        self._unread = list(reversed(voices))
        self._known: list[str] = []  # the latest voice comes first
        self._lines: Beginnings[_Line] = Beginnings()

    def read(self, text: str) -> Iterator[Heard]:
        """The recognised sentences, in order; other text is skipped. The time is linear in the text's length."""
        heard = Text(text)
        at = 0
        about: int | None = None
        while at < len(text):
            best = self._recognise(heard, at)
            if best and best.line.claim is Late:
                about, at = int(heard[best.place.slots["turn"]]), best.place.end
                continue
            if best:
                slots = {name: heard[span] for name, span in best.place.slots.items()}
                yield Heard(best.line.claim, slots, about, (at, best.place.end))
                at = best.place.end
            else:
                at = heard.next(None if self._unread else self._lines, at)
            about = None
            while at < len(text) and text[at].isspace():
                at += 1

    def _recognise(self, text: Text, at: int) -> "_Found | None":
        """The sentence that begins here, if any, or the words that name the turn of the next sentence."""
        best: _Found | None = None
        lines = text.beginning(self._lines, at)
        tried: set[tuple[Any, ...]] = set()
        for number in itertools.count() if lines or self._unread else ():
            if number == len(self._known):
                if not self._unread:
                    break
                self._learn(self._unread.pop())
                lines = text.beginning(self._lines, at)
            for line in lines:
                what = line.claim, line.sentence
                if line.voice == self._known[number] and what not in tried:
                    tried.add(what)  # many voices share it
                    if place := line.sentence.match(text, at):
                        found = self._found(line, place, text, at, number * _MANY + line.number)
                        best = found if best is None else min(best, found, key=_RANK)
            if best and not best.doubtful:
                break
        if best and best.line.claim is not Late and best.line.voice != self._known[0]:
            self._known.remove(best.line.voice)
            self._known.insert(0, best.line.voice)
        return best

    def _learn(self, voice: str) -> None:
        """Add the sentences of a voice."""
        self._known.append(voice)
        number = itertools.count()
        for claim, templates in self._phrasebook(voice).items():
            for template in templates:
                line = _Line(next(number), voice, claim, _sentence(template, claim is Late))
                for beginning in line.sentence.beginnings:
                    self._lines.add(beginning, line)

    def _found(self, line: "_Line", place: Place, text: Text, at: int, rank: int) -> "_Found":
        if line.claim is Late:
            return _Found(False, -math.inf, 0, rank, line, place)
        doubtful = any(map(text.has_end, place.slots.values()))
        if not doubtful and self._is_action and issubclass(line.claim, ActionClaim):
            span = place.slots.get(line.claim.action_slot)
            doubtful = span is not None and not self._is_action(text[span])
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
    """A reading of a sentence. The first four fields are its rank: the smallest is best."""

    doubtful: bool
    """Whether a slot holds more than one sentence, or lacks the action that it must hold."""
    size: float
    in_slots: int
    """Number of characters in slots."""
    number: int
    """Order of equal readings: the later voice, then the earlier template."""
    line: _Line
    place: Place


_MANY = 1_000_000  # more than a voice has templates
_RANK = itemgetter(slice(4))


@cache
def _sentence(template: str, late: bool) -> Sentence:
    """The sentence of a template; of a late claim only the words before the late sentence."""
    if late:
        return Sentence(template.removesuffix("{text}").replace("{turn}", "{turn:d}"), ends=False)
    return Sentence(template)
