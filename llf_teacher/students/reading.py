"""Reading: a student who knows the phrasebooks recognises their sentences in a text, without any atoms."""

import re
import string
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from operator import itemgetter
from typing import Any, NamedTuple

from teachers.atoms import ActionClaim, Claim
from teachers.common import Late
from teachers.phrasebook import Phrasebook
from teachers.voice import PLAIN

_SENTENCE_END = re.compile(r"[.!?:]\s+")
_NUMBER = r"[-+]?(?:\d+(?:\.\d+)?(?:e[-+]?\d+)?|inf|nan)"  # what a slot with a format for numbers can hold

_TEXT = r'(?:".+?"|.+?)'  # what opens with a quotation mark closes with one, whatever sentences are in it


class Heard(NamedTuple):
    """A recognised sentence."""

    claim: type[Claim[Any]]
    """The class of claim that it words."""
    slots: dict[str, str]
    """The text that stands in each slot."""
    about_turn: int | None
    """The turn that it says it is about; None if it does not say."""


class Reader:
    """Recognises the sentences of teachers.

    A sentence is looked up in the voice that was heard last, and in the others only if it is not understood in that.

    Args:
        phrasebook: the words of a voice; not asked for one before it is needed.
        voices: those that it knows.
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
        self._known: list[_Book] = []  # the one of the voice that was heard last comes first

    def read(self, text: str) -> Iterator[Heard]:
        """The sentences that are recognised, in order; what is not is skipped."""
        at = 0
        about: int | None = None
        while at < len(text):
            best, frame = self._recognise(text, at)
            if frame:
                about, at = int(frame["turn"]), frame.end()
                continue
            if best:
                yield Heard(best.claim, best.slots, about)
                at = best.end
            else:
                end = _SENTENCE_END.search(text, at)
                at = end.end() if end else len(text)
            about = None
            while at < len(text) and text[at].isspace():
                at += 1

    def _recognise(self, text: str, at: int) -> tuple["_Found | None", re.Match[str] | None]:
        """The sentence that begins here, if any, or the words that tell which turn the next one is about."""
        best: _Found | None = None
        for book in self._books():
            frame = next(filter(None, (frame.match(text, at) for frame in book.frames)), None)
            if frame:
                return None, frame
            for cls, sentence in book.sentences:
                if match := sentence.match(text, at):
                    found = self._found(cls, match, book)
                    best = found if best is None else min(best, found, key=_RANK)
            if best and not best.doubtful:
                break
        if best and best.book is not self._known[0]:
            self._known.remove(best.book)
            self._known.insert(0, best.book)
        return best, None

    def _books(self) -> Iterator["_Book"]:
        yield from tuple(self._known)
        while self._unread:
            book = _Book(self._phrasebook(self._unread.pop()))
            self._known.append(book)
            yield book

    def _found(self, cls: type[Claim[Any]], match: re.Match[str], book: "_Book") -> "_Found":
        slots = match.groupdict()
        doubtful = any(map(_SENTENCE_END.search, slots.values()))
        if self._is_action and issubclass(cls, ActionClaim) and cls.action_slot in slots:
            doubtful = doubtful or not self._is_action(slots[cls.action_slot])
        in_slots = sum(map(len, slots.values()))
        own = match.end() - match.start() - in_slots
        # What is doubtful should take in little; of the rest, what says most in words of its own is meant.
        return _Found(doubtful, match.end() if doubtful else -own, in_slots, match.end(), cls, slots, book)


class _Book:
    """A phrasebook as regular expressions."""

    def __init__(self, phrasebook: Phrasebook) -> None:
        self.sentences = [
            (cls, _pattern(template, r"(?=\s|$)"))
            for cls, templates in phrasebook.items()
            if cls is not Late
            for template in templates
        ]
        self.frames = [_pattern(template.removesuffix("{text}")) for template in phrasebook.templates(Late)]


class _Found(NamedTuple):
    """What a sentence may be. The first three are its rank: the least is meant."""

    doubtful: bool
    """Whether a slot holds more than one sentence, or no action where it must."""
    size: int
    in_slots: int
    """Number of characters in slots."""
    end: int
    claim: type[Claim[Any]]
    slots: dict[str, str]
    book: _Book


_RANK = itemgetter(slice(3))


@cache
def _pattern(template: str, end: str = "") -> re.Pattern[str]:
    """A regular expression whose groups are the template's slots; a slot that comes twice must read the same."""
    parts, seen = [], set()
    for literal, slot, spec, _ in string.Formatter().parse(template):
        parts.append(re.escape(literal))
        if slot is not None:
            parts.append(f"(?P={slot})" if slot in seen else f"(?P<{slot}>{_NUMBER if spec else _TEXT})")
            seen.add(slot)
    return re.compile("".join(parts) + end, re.DOTALL)
