"""Reading: a student who knows the phrasebook recognises its sentences in a text, without any atoms."""

import re
import string
from collections.abc import Iterator
from typing import NamedTuple

from teachers.atoms import Claim
from teachers.common import Late
from teachers.phrasebook import Phrasebook

_SENTENCE_END = re.compile(r"[.!?:]\s+")


class Heard(NamedTuple):
    """A recognised sentence."""

    claim: type[Claim]
    """The class of claim that it words."""
    slots: dict[str, str]
    """The text that stands in each slot."""
    about_turn: int | None
    """The turn that it says it is about; None if it does not say."""


class Reader:
    """Recognises the sentences of a phrasebook."""

    def __init__(self, phrasebook: Phrasebook) -> None:
        self._sentences = [
            (cls, re.compile(_pattern(template) + r"(?=\s|$)", re.DOTALL))
            for cls, templates in phrasebook.items()
            if cls is not Late
            for template in templates
        ]
        self._frames = [
            re.compile(_pattern(template.removesuffix("{text}"))) for template in phrasebook.templates(Late)
        ]

    def read(self, text: str) -> Iterator[Heard]:
        """The sentences that are recognised, in order; what is not is skipped."""
        at = 0
        about: int | None = None
        while at < len(text):
            frame = next(filter(None, (frame.match(text, at) for frame in self._frames)), None)
            if frame:
                about, at = int(frame["turn"]), frame.end()
                continue
            # Where several patterns fit, those that take in more than one sentence are longer.
            fitting = [(cls, found) for cls, sentence in self._sentences if (found := sentence.match(text, at))]
            if fitting:
                cls, found = min(fitting, key=lambda each: each[1].end())
                yield Heard(cls, found.groupdict(), about)
                at = found.end()
            else:
                end = _SENTENCE_END.search(text, at)
                at = end.end() if end else len(text)
            about = None
            while at < len(text) and text[at].isspace():
                at += 1


def _pattern(template: str) -> str:
    """A regular expression whose groups are the template's slots; a slot that comes twice must read the same."""
    parts, seen = [], set()
    for literal, slot, _, _ in string.Formatter().parse(template):
        parts.append(re.escape(literal))
        if slot is not None:
            parts.append(f"(?P={slot})" if slot in seen else f"(?P<{slot}>.+?)")
            seen.add(slot)
    return "".join(parts)
