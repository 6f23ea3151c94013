"""Find the sentences of a phrasebook in a text, in linear time.

A template matches like a regular expression with a lazy group per slot, but without backtracking: it searches for the
words between two slots as a whole and takes the first place, since all that can follow a later place can follow it.
"""

import re
import string
from bisect import bisect_left
from collections.abc import Hashable
from functools import cached_property
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

_NUMBER = r"[-+]?(?:\d+(?:\.\d+)?(?:e[-+]?\d+)?|inf|nan)"  # what a slot with a format for numbers can hold
_INTEGER = r"[-+]?\d{1,9}"
_NUMBER_BEGINS = "+-0123456789in"
_END = r"(?=\s|$)"
_SENTENCE_END = r"[.!?:]\s++"
_ANYTHING = re.compile(_SENTENCE_END)
_LETTERS = 3  # of a beginning: enough to skip most places where no line begins


class Place(NamedTuple):
    """The place of a sentence in a text."""

    end: int
    slots: dict[str, tuple[int, int]]
    """Start and end of the text in each slot."""


class _Chunk:
    """The part of a template between two slots of text: words, and slots of numbers."""

    def __init__(self, pattern: str) -> None:
        self._pattern = pattern

    @cached_property
    def plain(self) -> re.Pattern[str]:
        """The pattern of the chunk."""
        return re.compile(self._pattern)

    @cached_property
    def quoted(self) -> re.Pattern[str]:
        """The pattern of the chunk after a quotation mark."""
        return re.compile(f'"{self._pattern}')


class Sentence:
    """Finds the sentences of a template in a text.

    A text slot that opens with a quotation mark ends with one if possible, and may contain sentences. A slot that
    occurs twice must have the same text.

    Args:
        template: a template with words between any two text slots.
        ends: whether a space or the end of the text must follow the sentence.
    """

    def __init__(self, template: str, *, ends: bool = True) -> None:
        parts = [""]
        self._slots: list[str] = []
        fields = list(string.Formatter().parse(template))
        for literal, slot, spec, _ in fields:
            parts[-1] += re.escape(literal)
            if slot is not None and spec:
                parts[-1] += (
                    f"(?P={slot})"
                    if f"(?P<{slot}>" in parts[-1]
                    else f"(?P<{slot}>{_INTEGER if spec == 'd' else _NUMBER})"
                )
            elif slot is not None:
                self._slots.append(slot)
                parts.append("")
        if ends:
            parts[-1] += _END
        self._first, *self._rest = map(_Chunk, parts)
        literal, _, spec, _ = fields[0]
        self.beginnings = tuple(_NUMBER_BEGINS) if spec and not literal else (literal,)
        """The possible beginnings of the sentence."""

    def match(self, text: "Text", at: int) -> Place | None:
        """The place of the sentence if it begins at `at`, else None."""
        head = self._first.plain.match(text.text, at)
        if head is None:
            return None
        slots = {name: head.span(name) for name in head.groupdict()}
        place, way = head.end(), 0
        ahead = self._ahead(text, 0, place, way)
        if ahead is None:
            text.hopeless.add(self)
            return None
        for i, (slot, chunk) in enumerate(zip(self._slots, self._rest, strict=True)):
            found, *ahead = ahead
            end = found.start()
            if text.text[place] == '"' and (closed := text.find(chunk.quoted, place + 2, way)):
                behind = self._ahead(text, i + 1, closed.end(), way | 1 << i)
                if behind is not None:
                    found, end, ahead, way = closed, closed.start() + 1, behind, way | 1 << i
            spans = {slot: (place, end), **{name: found.span(name) for name in found.groupdict()}}
            if any(name in slots and text[slots[name]] != text[span] for name, span in spans.items()):
                return None
            slots |= spans
            place = found.end()
        return Place(place, slots)

    def _ahead(self, text: "Text", i: int, at: int, way: int) -> list[re.Match[str]] | None:
        """The first places of the chunks from the i-th on, each after some text; None if a chunk is missing."""
        places = []
        for chunk in self._rest[i:]:
            found = text.find(chunk.plain, at + 1, (self, way))
            if found is None:
                return None
            places.append(found)
            at = found.end()
        return places


class _Line(Protocol):
    """An object with a sentence."""

    @property
    def sentence(self) -> Sentence: ...


LineT = TypeVar("LineT", bound=_Line)


class Beginnings(Generic[LineT]):
    """An index of lines by their beginnings: a tree of letters."""

    def __init__(self) -> None:
        self.root: dict[str, Any] = {}
        """A tree: per letter its continuations, and under the empty string the complete lines."""
        self.size = 0
        self._short: dict[str, list[LineT]] = {}
        self._behind: dict[tuple[int, frozenset[str]], re.Pattern[str]] = {}

    def add(self, beginning: str, line: LineT) -> None:
        """Add a line."""
        node = self.root
        for letter in beginning:
            node = node.setdefault(letter, {})
        node.setdefault("", []).append(line)
        if len(beginning) < _LETTERS:
            self._short[beginning] = node[""]
        self.size += 1

    def behind_an_end(self, hopeless: set[Sentence]) -> re.Pattern[str]:
        """The pattern of a sentence's end that a line may follow, except hopeless lines."""
        dead = frozenset(
            beginning for beginning, lines in self._short.items() if all(line.sentence in hopeless for line in lines)
        )
        if (key := (self.size, dead)) not in self._behind:
            self._behind[key] = re.compile(_SENTENCE_END + f"(?={_first_letters(self.root, dead)})")
        return self._behind[key]

    def of(self, text: str) -> list[LineT]:
        """The lines whose beginnings the text has."""
        node = self.root
        found: list[LineT] = node.get("", [])
        for letter in text:
            node = node[letter]
            found = found + node.get("", [])
        return found


def _first_letters(node: dict[str, Any], dead: frozenset[str], said: str = "") -> str:
    """The pattern of the first letters of all lines, except dead short beginnings."""
    if len(said) == _LETTERS or ("" in node and said not in dead):
        return ""
    ways = [re.escape(letter) + _first_letters(node[letter], dead, said + letter) for letter in node if letter]
    return f"(?:{'|'.join(ways)})" if ways else "(?!)"


class Text:
    """A text that is read from start to end; it caches what was found."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.hopeless: set[Sentence] = set()
        """Sentences that cannot occur in the rest, since a part of them does not."""
        self._known: dict[tuple[re.Pattern[str], Hashable], tuple[int, re.Match[str] | None]] = {}
        self._behind = -1, _ANYTHING
        self._left: dict[int, tuple[int, list[Any]]] = {}

    def __getitem__(self, span: tuple[int, int]) -> str:
        return self.text[slice(*span)]

    @cached_property
    def _ends(self) -> list[int]:
        return [end.start() for end in re.finditer(r"[.!?:]\s", self.text)]

    def has_end(self, span: tuple[int, int]) -> bool:
        """Whether a part of the text holds the end of a sentence and more text."""
        i = bisect_left(self._ends, span[0])
        return i < len(self._ends) and self._ends[i] + 2 <= span[1]

    def find(self, pattern: re.Pattern[str], at: int, way: Hashable = None) -> re.Match[str] | None:
        """The first place of a pattern from `at` on. Results are cached per `way`, which only moves forwards."""
        since, found = self._known.get((pattern, way), (len(self.text) + 1, None))
        if since > at or (found is not None and found.start() < at):
            since, found = self._known[pattern, way] = at, pattern.search(self.text, at)
        return found

    def next(self, lines: Beginnings[LineT] | None, at: int) -> int:
        """The place after the next sentence end where a line can begin; without lines, after any sentence end."""
        pattern = _ANYTHING
        if lines:
            if len(self.hopeless) != self._behind[0]:
                self._behind = len(self.hopeless), lines.behind_an_end(self.hopeless)
            pattern = self._behind[1]
        end = pattern.search(self.text, at)
        return end.end() if end else len(self.text)

    def beginning(self, lines: Beginnings[LineT], at: int) -> list[LineT]:
        """The lines that may begin at `at`."""
        last, end, stop = lines.root, at, len(self.text)
        while end < stop and (node := last.get(self.text[end])):
            last, end = node, end + 1
        age = lines.size + len(self.hopeless)
        since, left = self._left.get(id(last), (-1, []))
        if since != age:
            left = [line for line in lines.of(self.text[at:end]) if line.sentence not in self.hopeless]
            self._left[id(last)] = age, left
        return left
