"""Words for people in place of codes: of kinds of feedback, feedback and instruction types, and labels.

Also words that phrases of several families make of names.
"""

from collections.abc import Iterable
from typing import Any, NamedTuple

from teachers.atoms import KINDS, FeedbackType, Label

__all__ = [
    "INSTRUCTIONS",
    "KIND_COLOURS",
    "KIND_MEANINGS",
    "KIND_WORDS",
    "VERDICTS",
    "VerdictWord",
    "article",
    "coded_words",
    "feedback_words",
    "kind_word",
    "listed",
    "type_words",
]

KIND_WORDS: dict[FeedbackType | None, str] = dict([*((kind, kind.word) for kind in KINDS), (None, "instruction")])
"""The word of each kind; the key None has the word for claims of no kind."""
_MEANINGS = (
    "reward (r): how well it went",
    "praise (hp, hindsight positive): what was good",
    "blame (hn, hindsight negative): what was bad",
    "advice (fp, future positive): what to do next",
    "warning (fn, future negative): what to avoid next",
    "instruction or notice",
)
KIND_MEANINGS: dict[FeedbackType | None, str] = dict(zip((*KINDS, None), _MEANINGS, strict=True))
"""What each kind means, with its code."""
KIND_COLOURS: dict[FeedbackType | None, str] = dict(
    zip((*KINDS, None), ("purple", "green", "red", "blue", "orange", "muted"), strict=True)
)
"""The colour of each kind, by its name in `worlds.pictures.themes.Theme`."""
INSTRUCTIONS = {"b": "basic", "p": "with practice", "c": "complete"}
"""The word of each instruction type."""
_WHOLE = {"a": "all kinds", "n": "none", "m": "random kinds"}


class VerdictWord(NamedTuple):
    """What the simulator says of a sentence."""

    holds: bool | None
    """None if it is neither true nor false."""
    word: str

    def __str__(self) -> str:
        return f"{'✓' if self.holds else '✗' if self.holds is False else '~'} {self.word}"


VERDICTS = {
    Label.TRUTHFUL: VerdictWord(True, "true"),
    Label.LATE: VerdictWord(True, "true, late"),
    Label.PLACEBO: VerdictWord(True, "true, beside the point"),
    Label.HEDGED: VerdictWord(None, "hedged"),
    Label.DISTORTED: VerdictWord(False, "false"),
}
"""The verdict for each label of a checked claim."""


def verdict_of(label: Label, elsewhere: bool | None) -> VerdictWord:
    """The verdict for a label; for a claim of another lesson also whether it holds there."""
    here = VERDICTS[label]
    return here if elsewhere is None else here._replace(word=f"{here.word} here, {str(elsewhere).lower()} elsewhere")


def kind_word(kind: FeedbackType | None, opening: bool = False) -> str:
    """The word of a sentence's kind; a sentence of no kind is an instruction at the opening, and later just words."""
    return KIND_WORDS[kind] if kind is not None or opening else "words"


def type_words(instruction_type: str, feedback_type: str) -> str:
    """An instruction type and a feedback type in words: `basic, all kinds` for b and a."""
    return f"{INSTRUCTIONS[instruction_type]}, {feedback_words(feedback_type)}"


def coded_words(codes: Iterable[str]) -> str:
    """Instruction types, or kinds, in words with their codes: `basic (b), complete (c)`, `reward (r), praise (hp)`."""
    return ", ".join(f"{INSTRUCTIONS.get(code) or KIND_WORDS[FeedbackType(code)]} ({code})" for code in codes)


def feedback_words(feedback_type: str) -> str:
    """A feedback type in words: `all kinds` for a, `reward, praise` for r+hp."""
    if feedback_type in _WHOLE:
        return _WHOLE[feedback_type]
    return ", ".join(KIND_WORDS[FeedbackType(kind)] for kind in feedback_type.split("+"))


def article(name: str) -> str:
    """A name with its indefinite article: `a mug`, `an apple`."""
    return f"{'an' if name[0].lower() in 'aeiou' else 'a'} {name}"


def listed(items: Iterable[Any], last: str = "or") -> str:
    """Items as a list with a word before the last: `1, 4 or 7`."""
    *rest, end = map(str, items)
    return f"{', '.join(rest)} {last} {end}" if rest else end
