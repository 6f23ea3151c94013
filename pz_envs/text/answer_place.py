"""Finds where the action stands in a model's reply: behind which label, in which sentence. No meaning is read here.

The time of each function is linear in the text's length.
"""

import re
from functools import cache
from typing import NamedTuple

__all__ = [
    "NOUNS",
    "PLAIN",
    "AnswerPlace",
    "brackets",
    "cleaned",
    "fenced",
    "find_place",
    "first_line",
    "masked",
    "sentences",
    "unmarked",
    "without_thoughts",
    "words",
]


def words(text: str) -> frozenset[str]:
    """The words of a text."""
    return frozenset(text.split())


NOUNS = ("action", "answer", "response", "move", "choice", "command", "decision", "output")
"""Names of an answer: labels, and keys of JSON."""
PLAIN = words(
    """a an the this that it is be my me us our your i i'll i'd i'm am we we'll we'd let let's will would should must
    shall want plan think propose suggest recommend prefer choose pick select take try use using go
    going do make stick follow following teacher's advice to and with again now then next first instead here here's so
    thus hence therefore just definitely certainly simply please sure ok okay yes well best better final correct right
    indeed optimal good chosen option number decision answer response action move command choice - \u2013 :"""
)
"""Words before an action, or a label, that only say that it is chosen."""
_THOUGHTS = "thoughts?|thinking|reasoning|reasons?|explanation|rationale|justification|note|why"
_MARKS = r"[ \t#*_>`(\[<$-]{0,12}"
_THOUGHT = re.compile(
    rf"(?:^{_MARKS}|(?<=\s)[*_]{{0,3}})(?:{_THOUGHTS})[*_]{{0,3}}[ \t]?[:\uff1a?]", re.IGNORECASE | re.MULTILINE
)
_TOKEN = re.compile(
    r"<\|\w+\|>(?:assistant\b|model\b)?|</?s>|<(?:bos|eos|end_of_turn)>|<start_of_turn>(?:model\b)?|\[/?INST\]"
    r"|<\uff5cend\u2581of\u2581sentence\uff5c>"
)
_UNSEEN = re.compile(r"[\u200b\u2060\ufeff]")
_WIDE = 40  # most spaces in a row, so that no search in them takes long
_GAP = re.compile(rf"[ \t]{{{_WIDE},}}+")
_FONT = re.compile(
    r"</?(?:b|strong|i|em|u|code|p|pre|span|mark|kbd)>|[\u2600-\u27bf\ufe0f\U0001f300-\U0001faff]", re.IGNORECASE
)
_BOX = re.compile(r"\\(?:boxed|fbox)\s*\{((?:[^{}]|\{[^{}]*+\})*+)\}")
_TEX = re.compile(r"\\(?:text|math)\w*\s*\{([^{}]*+)\}|\\[()\[\]]")
_FENCE = re.compile(r"^[ \t]*(?:`{3,}|~{3,})[^\n`]*$", re.MULTILINE)
_QUOTED = re.compile(r"(?<!\\)\"(?:[^\"\\\n]|\\.)*+\"|\u201c[^\u201c\u201d\n]*+\u201d")
_BRACKETS = re.compile(r"\[[^\[\]]*+\]|\([^()]*+\)|\{[^{}]*+\}")
_CLOSING = {"[": "]", "(": ")", "<": ">"}
_END = re.compile(r"(?<=[.!?;])[ \t]+|\s*\n\s*")
_NUMBERED = re.compile(r"(?<=\n)[ \t*_]*[0-9]{1,2}[.)](?=[ \t])")
_SENTENCES = 40  # from each end of a text
_BRACED = 20_000  # characters in which brackets are looked for
_DEEP = 6  # brackets within brackets


class AnswerPlace(NamedTuple):
    """Where an answer stands."""

    label: str
    """The last label with a text behind it, else the last one; empty if there is none, or other text before it."""
    said: str
    """The text behind the label, up to a thought; without a label the text itself. A line's end before it stays."""


def cleaned(text: str) -> str:
    """The text up to the first stop token, without start tokens of a chat, invisible characters and wide gaps."""
    return next((piece for piece in _TOKEN.split(_GAP.sub(" " * _WIDE, _UNSEEN.sub("", text))) if piece.strip()), "")


def unmarked(text: str) -> str:
    """The text without HTML's tags for fonts and emoji, and with the contents of TeX's boxes and fonts in place."""
    return _BOX.sub(r" \1 ", _TEX.sub(lambda font: font[1] or "", _FONT.sub("", text)))


@cache
def _labels(names: tuple[str, ...], verbatim: bool) -> re.Pattern[str]:
    own = "|".join(map(re.escape, names)) or "(?!)"
    nouns, plain = "|".join(NOUNS), "|".join(map(re.escape, sorted(PLAIN, reverse=True)))
    before = rf"(?:(?:{plain}|you)[,.!]?[ \t]+){{0,6}}"
    colon = r"(?:[ \t]+is)?[*_`]*[ \t]*[:=\uff1a][*_`]*"
    at_line = rf"^{_MARKS}{before}"
    if verbatim:  # the name of a poem is alone on its line
        forms = [rf"{at_line}(?:{nouns}){colon}", rf"{at_line}(?:{own}){colon}[ \t]*$"]
    else:
        forms = [rf"(?:{at_line}|(?<=[.!?:;,)])[ \t*_`]{{1,6}}{before})(?:{nouns}|{own}){colon}"]
    heading = rf"^[ \t]*(?:\#+[ \t]*|\*\*|__){before}(?:{nouns}|{own})[*_]*[ \t]*$"
    return re.compile("|".join([*forms, heading, rf"\bresponse{colon}"]), re.IGNORECASE | re.MULTILINE)


@cache
def _tag(names: tuple[str, ...]) -> re.Pattern[str]:
    return re.compile(rf"<(/?)(?:final_)?(?:{'|'.join((*NOUNS, 'tool_call', *map(re.escape, names)))})>", re.IGNORECASE)


def find_place(text: str, names: tuple[str, ...] = (), verbatim: bool = False) -> AnswerPlace:
    """Where the answer stands in a text without marked reasoning.

    Args:
        text: the text.
        names: further names of labels.
        verbatim: whether a label must begin a line, and one of `names` be alone on it.
    """
    text = _tag(names).sub(lambda tag: "\n" if tag[1] else "\nAnswer: ", text)
    labels = [*_labels(names, verbatim).finditer(_unquoted(text))]
    ends = [*(label.start() for label in labels[1:]), len(text)]
    for label, end in zip(reversed(labels), reversed(ends), strict=False):
        said = thoughtless(text[label.end() : end]).rstrip().lstrip(" \t")
        if said.strip("*_`# \n"):
            opened = label[0].strip()[:1]
            return AnswerPlace(label[0].strip(), said.removesuffix(_CLOSING[opened]) if opened in _CLOSING else said)
    if labels and not thoughtless(text[: labels[0].start()]).strip():
        return AnswerPlace(labels[-1][0].strip(), "")
    return AnswerPlace("", text[: labels[0].start()] if labels else text)


def thoughtless(text: str) -> str:
    """The text up to the first thought, as in `Thought: ...`."""
    thought = _THOUGHT.search(_unquoted(text))
    return text[: thought.start()] if thought else text


def without_thoughts(text: str) -> str:
    """The text without paragraphs that begin with a thought's label."""
    return "\n\n".join(filter(None, (thoughtless(each).strip() for each in re.split(r"\n[ \t]*\n", text))))


def _unquoted(text: str) -> str:
    return _QUOTED.sub(lambda quoted: " " * len(quoted[0]), text)


def masked(text: str, mask: str = "_") -> str:
    """The text with `_` for each character of a quotation, and `mask` for each of what stands in brackets."""
    text = _QUOTED.sub(lambda found: "_" * len(found[0]), text)
    for _ in range(_DEEP if len(text) <= _BRACED else 0):
        text = _BRACKETS.sub(lambda found: mask * len(found[0]), text)
    return text


def brackets(text: str) -> list[tuple[int, int]]:
    """The beginnings and ends of all that stands in brackets, the outermost ones."""
    return [found.span() for found in re.finditer("\0+", masked(text.replace("\0", " "), "\0"))]


def sentences(text: str) -> list[tuple[str, int]]:
    """The sentences of a text and the positions behind them; lines end sentences, and fences are no sentences.

    A number and a dot behind the end of a line number the next one, and are no sentence.
    """
    seen = _NUMBERED.sub(lambda number: "_" * len(number[0]), masked(text))
    found, at = [], 0
    for begin, end in [*(end.span() for end in _END.finditer(seen)), (len(text), len(text))]:
        if (said := text[at:begin].strip()) and not _FENCE.fullmatch(said):
            found.append((said, begin))
        at = end
    return found if len(found) <= 2 * _SENTENCES else found[:_SENTENCES] + found[-_SENTENCES:]


def fenced(text: str) -> list[str]:
    """The texts in fences of three backticks or tildes; an open fence has the rest of the text."""
    marks = [(mark.start(), mark.end()) for mark in _FENCE.finditer(text)]
    ends = [*(begin for begin, _ in marks[1::2]), len(text)]
    return [text[end:until].strip() for (_, end), until in zip(marks[::2], ends, strict=False)]


def first_line(text: str) -> str:
    """The first line of a text that has words, without fences."""
    return next((line.strip() for line in text.splitlines() if line.strip() and not _FENCE.fullmatch(line)), "")
