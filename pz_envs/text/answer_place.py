"""Finds where the action stands in a model's reply: behind which label, in which sentence. No meaning is read here.

The time of each function is linear in the text's length.
"""

import re
from collections.abc import Iterator
from functools import cache
from itertools import islice
from typing import NamedTuple

__all__ = [
    "AnswerPlace",
    "cleaned",
    "fenced",
    "find_place",
    "first_line",
    "marked",
    "masked",
    "plain",
    "sentences",
    "unboxed",
    "without_thoughts",
]

_NOUNS = "response|answer|action|move|choice|command|decision|output"
_BEFORE = (
    "(?:(?:my|the|your|our|final|next|best|chosen|so|now|sure|okay|ok|here is|here['\u2019]s|first|is)[,.!]?[ \t]+)*+"
)
_OLD = "(?P<old>(?:my |the |your )?(?:last|previous|prior|earlier|old|other|wrong)[ \t]+)?"
_DECORATION = r"[ \t#*_>`(\[<$-]{0,12}"
_COLON = "[:=\uff1a]"
_THOUGHT = re.compile(
    rf"(?:^{_DECORATION}|(?<=\s)[*_]{{0,3}})"
    r"(?:thoughts?|thinking|reasoning|reasons?|explanation|rationale|justification|note|why)[*_]{0,3}[ \t]?[:\uff1a?]",
    re.IGNORECASE | re.MULTILINE,
)
_TOKEN = re.compile(
    r"<\|\w+\|>(?:assistant\b|model\b)?|</?s>|<(?:bos|eos|end_of_turn)>|<start_of_turn>(?:model\b)?|\[/?INST\]"
    r"|<\uff5cend\u2581of\u2581sentence\uff5c>"
)
_UNSEEN = re.compile(r"[\u200b\u2060\ufeff]")
_FONT = re.compile(r"</?(?:b|strong|i|em|u|code|p|pre|span|mark|kbd)>", re.IGNORECASE)
_BOX = re.compile(r"\\(?:boxed|fbox)\s*\{((?:[^{}]|\{[^{}]*+\})*+)\}")
_TEX = re.compile(r"\\(?:text|textbf|mathrm|mathbf|texttt)\s*\{([^{}]*+)\}")
_FENCE = re.compile(r"^[ \t]*(?:`{3,}|~{3,})[^\n`]*$", re.MULTILINE)
_QUOTED = re.compile(r"\"(?:[^\"\\\n]|\\.)*+\"|\u201c[^\u201c\u201d\n]*+\u201d")
_BRACKETS = re.compile(r"\[[^\[\]]*+\]|\([^()]*+\)|\{[^{}]*+\}")
_CLOSING = {"[": "]", "(": ")", "<": ">"}
_END = re.compile(r"(?<=[.!?;])[ \t]+|\s*\n\s*")
_NUMBERED = re.compile(r"[*_]*[0-9]{1,2}[.)]")
_SENTENCES = 40  # from each end of a text
_BRACED = 20_000  # characters in which brackets are looked for


class AnswerPlace(NamedTuple):
    """Where an answer stands."""

    label: str
    """The last label with a text behind it, else the last one; empty if there is none, or other text before it."""
    said: str
    """The text behind the label, up to a thought; without a label the text itself."""


def cleaned(text: str) -> str:
    """The text up to the first stop token, without the start tokens of a chat template and invisible characters."""
    return next((piece for piece in _TOKEN.split(_UNSEEN.sub("", text)) if piece.strip()), "")


@cache
def _labels(names: tuple[str, ...], verbatim: bool) -> re.Pattern[str]:
    own = "|".join(map(re.escape, names)) or "(?!)"
    close = r"(?:[ \t]+is)?[*_`]*[ \t]*"
    alone = rf"{_DECORATION}{_BEFORE}(?:{own})[*_`]*[ \t]*{_COLON}[*_`]*[ \t]*$" if verbatim else "(?!)"
    nouns = _NOUNS if verbatim else f"{_NOUNS}|{own}"
    at_sentence = "(?!)" if verbatim else r"(?<=[.!?:;,)])[ \t*_`]{1,6}"
    return re.compile(
        rf"(?:^{_DECORATION}|{at_sentence}){_OLD}{_BEFORE}(?:{nouns}){close}{_COLON}[*_`]*"
        rf"|^{alone}"
        rf"|^[ \t]*(?:\#+[ \t]*|\*\*|__){_BEFORE}(?:{_NOUNS}|{own})[*_]*[ \t]*$"
        rf"|\b(?P<first>(?:first|last|previous|earlier)[ \t]+)?response[*_`]*[ \t]*{_COLON}[*_`]*",
        re.IGNORECASE | re.MULTILINE,
    )


@cache
def _tag(names: tuple[str, ...]) -> re.Pattern[str]:
    return re.compile(rf"<(/?)(?:final_)?(?:{'|'.join((_NOUNS, 'tool_call', *map(re.escape, names)))})>", re.IGNORECASE)


def find_place(text: str, names: tuple[str, ...] = (), verbatim: bool = False) -> AnswerPlace:
    """Where the answer stands in a text without marked reasoning.

    Args:
        text: the text.
        names: further names of labels.
        verbatim: whether a label must begin a line, and one of `names` be alone on it.
    """
    text = _tag(names).sub(lambda tag: "\n" if tag[1] else "\nAnswer: ", text)
    seen = text if verbatim else _QUOTED.sub(lambda quoted: " " * len(quoted[0]), text)
    labels = [label for label in _labels(names, verbatim).finditer(seen) if not (label["old"] or label["first"])]
    ends = [*(label.start() for label in labels[1:]), len(text)]
    for label, end in zip(reversed(labels), reversed(ends), strict=False):
        said = thoughtless(text[label.end() : end], verbatim).strip()
        if said.strip("*_`# \n"):
            opened = label[0].strip()[:1]
            return AnswerPlace(label[0].strip(), said.removesuffix(_CLOSING[opened]) if opened in _CLOSING else said)
    if labels and not thoughtless(text[: labels[0].start()], verbatim).strip():
        return AnswerPlace(labels[-1][0].strip(), "")
    return AnswerPlace("", text[: labels[0].start()] if labels else text)


def thoughtless(text: str, verbatim: bool = False) -> str:
    """The text up to the first thought, as in `Thought: ...`."""
    seen = text if verbatim else _QUOTED.sub(lambda quoted: " " * len(quoted[0]), text)
    for thought in _THOUGHT.finditer(seen):
        if not verbatim or text.rfind("\n", 0, thought.start() + 1) + 1 >= thought.start():
            return text[: thought.start()]
    return text


def without_thoughts(text: str) -> str:
    """The text without paragraphs that begin with a thought's label."""
    return "\n\n".join(filter(None, (thoughtless(each).strip() for each in re.split(r"\n[ \t]*\n", text))))


def masked(text: str) -> str:
    """The text with `_` in place of each quotation and of what stands in brackets; the length stays."""
    text = _QUOTED.sub(lambda found: "_" * len(found[0]), text)
    if len(text) > _BRACED:
        return text
    for _ in range(3):
        text = _BRACKETS.sub(lambda found: "_" * len(found[0]), text)
    return text


def sentences(text: str, lists: bool = True) -> list[tuple[str, int]]:
    """The sentences of a text and the positions behind them; lines end sentences, and fences are no sentences.

    Args:
        text: the text.
        lists: whether a number and a dot that begin a line number it, and do not end a sentence.
    """
    found, at = [], 0
    for end in [*_END.finditer(masked(text)), None]:
        until = len(text) if end is None else end.start()
        said = text[at:until].strip()
        if (
            lists
            and end is not None
            and "\n" not in end[0]
            and _NUMBERED.fullmatch(said)
            and (at == 0 or "\n" in text[at - 1])
        ):
            continue
        if said and not _FENCE.fullmatch(said):
            found.append((said, until))
        at = until if end is None else end.end()
    return found if len(found) <= 2 * _SENTENCES else found[:_SENTENCES] + found[-_SENTENCES:]


def fenced(text: str) -> list[str]:
    """The texts in fences of three backticks or tildes; an open fence has the rest of the text."""
    marks = [(mark.start(), mark.end()) for mark in _FENCE.finditer(text)]
    ends = [*(begin for begin, _ in marks[1::2]), len(text)]
    return [text[end:until].strip() for (_, end), until in zip(marks[::2], ends, strict=False)]


def plain(text: str) -> str:
    """The text without HTML's tags for fonts."""
    return _FONT.sub("", text)


def unboxed(text: str) -> str:
    """The text with the contents of boxes and fonts of TeX in their place."""
    return _BOX.sub(r" \1 ", _TEX.sub(r"\1", text))


def marked(text: str) -> Iterator[tuple[str, str]]:
    """The texts in fences and boxes of TeX, each with the words before it on its line."""
    text = _TEX.sub(r"\1", text)
    for each in islice(fenced(text), _SENTENCES):
        yield each, ""
    for box in islice(_BOX.finditer(text), _SENTENCES):
        yield box[1], text[text.rfind("\n", 0, box.start()) + 1 : box.start()]


def first_line(text: str) -> str:
    """The first line of a text that has words, without fences."""
    return next((line.strip() for line in text.splitlines() if line.strip() and not _FENCE.fullmatch(line)), "")
