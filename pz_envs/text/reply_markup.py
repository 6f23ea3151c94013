"""The markup of chat models' replies: labels, fences, boxes, tags, quotes, remarks. No meaning is read here.

The time of each function is linear in the text's length.
"""

import operator
import re
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import islice
from typing import NamedTuple

__all__ = [
    "behind_marker",
    "fenced",
    "labelled",
    "paragraphs",
    "peeled",
    "spans",
    "tagged",
    "unlabelled",
    "unquoted",
    "verse",
    "visible",
    "without_stops",
]

_STOP = re.compile(
    r"</s>|<\|(?:im_end|endoftext|eot_id|eom_id|end_of_text|end|return|call|eos|user|assistant|im_start|start_header_id)\|>"
    r"|<eos>|<end_of_turn>|<\uff5cend\u2581of\u2581sentence\uff5c>|\[/INST\]",
    re.IGNORECASE,
)
_START = re.compile(
    r"\s*(?:<s>|<bos>|<\|im_start\|>(?:assistant)?|<start_of_turn>(?:model)?|<\|start\|>(?:assistant)?"
    r"|<\|start_header_id\|>assistant<\|end_header_id\|>|\[INST\])\s*",
    re.IGNORECASE,
)
_DECORATION = r"[*_`\"'\[(<#>$\u201c\u2018\u00ab-]"
_CLOSING = r"[*_`\"'\])>$\u201d\u2019\u00bb]"
_NOUNS = "response|answer|action|move|choice|command|decision|output|proposal"
_WORDS = (
    "(?:my|the|your|final|next|chosen|selected|best|first|last|assistant"
    "|so|now|sure|okay|ok|well|certainly|here is|here are|here['\u2019]s)[,.!]?"
)
_COLON = "[:\uff1a]"
_ANYWHERE = re.compile(rf"(?P<open>)response(?P<shut>{_CLOSING}*+)[ \t]*{_COLON}(?P<close>{_CLOSING}*+)", re.IGNORECASE)
_BEGINNING = operator.methodcaller("start")
_RESPONSE = re.compile(rf"response{_CLOSING}*+[ \t]*{_COLON}(?:\*\*|__|`(?!`))?", re.IGNORECASE)
_MIRROR = str.maketrans("[(<\u201c\u2018\u00ab", "])>\u201d\u2019\u00bb")
_NO_BRACKETS = str.maketrans("", "", "#>-")
_FENCE = re.compile(r"^[ \t]*(?P<mark>`{3,}|~{3,})(?P<rest>[^\n]*)$", re.MULTILINE)
_LINE = re.compile(r"^[^:=\uff1a\n]{0,80}[:=\uff1a]", re.MULTILINE)
_TAGS = "answer|final_answer|action|response|output|move|command|tool_call"
_UNSEEN = re.compile(r"[\u200b\u2060\ufeff]|</?(?:b|strong|i|em|u|code|p|pre|span|mark|kbd)>", re.IGNORECASE)
_QUOTATION = re.compile(r"\"(?:[^\"\\]|\\.)*+\"|\u201c[^\u201c\u201d]*+\u201d|(?<!\w)'[^'\n]*+'(?!\w)", re.DOTALL)
_LEAD = re.compile(
    r"[^\n]{1,120}:[ \t]*\n[ \t]*\n\s*"
    r"|(?:\#+[ \t][^\n]+|title:[^\n]+|(?P<bold>\*\*|__)[^\n]{1,80}?(?P=bold))[ \t]*\n\s*+(?!(?P=bold)|\#)"
    r"|(?P<mark>[*_\"])[^\n]{1,80}?(?P=mark)[ \t]*\n[ \t]*\n\s*+(?!(?P=mark))",
    re.IGNORECASE,
)
_COUNT = re.compile(
    r"[*_(\[]{0,3}(?:syllables?:[ \t]*)?[0-9]{1,2}(?:[ \t]?[-\u2013/,][ \t]?[0-9]{1,2})+(?:[ \t]syllables)?"
    r"[*_)\]]{0,3}",
    re.IGNORECASE,
)
_BRACE = re.compile(r"\\(?:boxed|fbox)\s*\{|[{}\[\]]")
_OBJECT = re.compile(r"[\[{]\s*[\"'{]")
_PAIRS = (
    *(
        ("***", "***"),
        ("**", "**"),
        ("__", "__"),
        ("```", "```"),
        ("``", "``"),
        ("$$", "$$"),
        ("\\(", "\\)"),
        ("\\[", "\\]"),
    ),
    *(("*", "*"), ("_", "_"), ("`", "`"), ('"', '"'), ("'", "'"), ("$", "$"), ("(", ")"), ("[", "]"), ("{", "}")),
    *(("<", ">"), ("\u201c", "\u201d"), ("\u2018", "\u2019"), ("\u00ab", "\u00bb")),
    *((f"\\{name}{{", "}") for name in ("boxed", "fbox", "text", "textbf", "mathrm", "mathbf", "texttt")),
)
_AROUND = {begin[0]: tuple(pair for pair in _PAIRS if pair[0][0] == begin[0]) for begin, _ in _PAIRS}
_BULLET = re.compile(r"(?:[>#*\u2022-]+|[-=]>|\u2192)[ \t]+|[0-9]{1,2}[.)][ \t]+(?=[A-Za-z])")
_REMARK = re.compile(r"(?P<said>[^()]*[^()\s])\s+\((?P<remark>[^()]*)\)[.!]?")
_DEPTH = 12  # layers around an answer
_BRACES = 2000  # greatest number of brackets that are read


class Labelled(NamedTuple):
    """The text from a label to the next one."""

    body: str
    """The text, without what closes the label."""
    begin: int
    """The label's position in the text."""


def without_stops(text: str) -> str:
    """The text up to the first stop token, without the start tokens of a chat template."""
    while begin := _START.match(text):
        text = text[begin.end() :]
    stop = _STOP.search(text)
    return text[: stop.start()] if stop else text


def visible(text: str) -> str:
    """The text without HTML tags and invisible characters."""
    return _UNSEEN.sub("", text)


def unquoted(text: str) -> str:
    """The text with spaces in place of each quotation; the length stays."""
    return _QUOTATION.sub(lambda found: " " * len(found[0]), text)


def verse(text: str) -> str:
    """A poem without the marked title or announcement before it and the syllable count behind it."""
    lead = _LEAD.match(text)
    text = text[lead.end() :] if lead else text
    lines, _, last = text.rstrip().rpartition("\n")
    return lines.rstrip() if lines and _COUNT.fullmatch(last.strip()) else text


@cache
def _heading(nouns: tuple[str, ...]) -> re.Pattern[str]:
    own = "".join(f"|{re.escape(noun)}" for noun in nouns)
    name = rf"(?:(?:{_WORDS})[ \t]+)*+(?:{_NOUNS}{own})"
    return re.compile(
        rf"\s*+(?:\#+[ \t]*{name}[ \t]*{_COLON}?[ \t]*(?:\n|$)"
        rf"|(?P<bold>\*\*|__){name}[ \t]*(?:{_COLON}[ \t]*(?P=bold)|(?P=bold)[ \t]*{_COLON}?)"
        rf"|{name}[ \t]*{_COLON}[ \t]*(?:\n|$))",
        re.IGNORECASE,
    )


@cache
def _label(nouns: tuple[str, ...]) -> re.Pattern[str]:
    own = "".join(f"|{re.escape(noun)}" for noun in nouns)
    return re.compile(
        rf"[ \t]*(?P<open>(?:{_DECORATION}[ \t]*)*+)(?:(?:{_WORDS})[ \t]+)*+(?:{_NOUNS}{own})(?:[ \t]+is)?"
        rf"(?P<shut>{_CLOSING}*+)[ \t]*[:=\uff1a](?P<close>{_CLOSING}*+)",
        re.IGNORECASE,
    )


def labelled(text: str, nouns: Sequence[str] = ()) -> Iterator[Labelled]:
    """The texts after labels such as `**Response:**` or `Final answer:`, in order.

    A label begins a line; only `Response:` may stand anywhere.

    Args:
        text: an answer.
        nouns: further names of labels.
    """
    at_line = _label(tuple(nouns))
    labels = [found for line in _LINE.finditer(text) if (found := at_line.match(text, line.start()))]
    known = {found.end("shut") for found in labels}
    labels += [found for found in _ANYWHERE.finditer(text) if found.end("shut") not in known]
    labels.sort(key=_BEGINNING)
    ends = [*(label.start() for label in labels[1:]), len(text)][: len(labels)]
    for label, end in zip(labels, ends, strict=True):
        if closed := _tag(tuple(nouns), "/").search(text, label.end(), end):
            end = closed.start()
        body = text[label.end() : end].strip()
        before = text[max(0, label.start() - 2) : label.start()]
        opened = label["open"].translate(_NO_BRACKETS).strip() or (before if before in ("**", "__") else "")
        closing = opened[::-1].translate(_MIRROR)
        if opened and not label["shut"] and not label["close"] and body.endswith(closing):
            body = body.removesuffix(closing).strip()
        elif not opened and label["close"]:  # these open the answer, they do not close the label
            body = text[label.start("close") : end].strip()
        yield Labelled(body, label.start())


def behind_marker(text: str) -> str | None:
    """The text after the last `Response:`, which may be in bold or in a tag; None without it."""
    ends = [marker.end() for marker in _RESPONSE.finditer(text)]
    return _tag((), "/").split(text[ends[-1] :])[0].strip() if ends else None


def unlabelled(text: str, nouns: Sequence[str] = ()) -> str:
    """A text without a label before it that is in bold or alone on its line; all other lines stay."""
    found = _heading(tuple(nouns)).match(text)
    return text[found.end() :].strip() if found else text


def fenced(text: str) -> Iterator[str]:
    """The texts in fences of three backticks or tildes; an open fence has the rest of the text."""
    begin, mark = 0, ""
    for fence in _FENCE.finditer(text):
        if not mark and fence["mark"][0] not in fence["rest"]:
            begin, mark = fence.end(), fence["mark"]
        elif mark and fence["mark"].startswith(mark) and not fence["rest"].strip():
            yield text[begin : fence.start()].strip()
            mark = ""
    if mark:
        yield text[begin:].strip()


@cache
def _tag(nouns: tuple[str, ...], end: str = "/?") -> re.Pattern[str]:
    return re.compile(rf"<(?P<end>{end})(?P<name>{'|'.join((_TAGS, *map(re.escape, nouns)))})>", re.IGNORECASE)


def tagged(text: str, nouns: Sequence[str] = ()) -> list[str]:
    """The texts in tags such as `<answer>`; an open tag has the rest of the text."""
    found = []
    opened: tuple[str, int] | None = None
    for tag in _tag(tuple(nouns)).finditer(text):
        name = tag["name"].lower()
        if not tag["end"]:
            opened = name, tag.end()
        elif opened and opened[0] == name:
            found.append(text[opened[1] : tag.start()].strip())
            opened = None
    return [*found, text[opened[1] :].strip()] if opened else found


def spans(text: str, nouns: Sequence[str] = ()) -> Iterator[str]:
    """The parts of a text that a fence, a tag, a box of TeX or JSON of texts marks as the answer."""
    yield from fenced(text)
    yield from tagged(text, nouns)
    braces: list[tuple[int, int]] = []
    for brace in islice(_BRACE.finditer(text), _BRACES):
        if brace[0] not in "]}":
            braces.append((brace.start(), brace.end()))
        elif braces:
            begin, inside = braces.pop()
            if inside - begin > 1:
                yield text[inside : brace.start()].strip()
            elif not braces and _OBJECT.match(text, begin):
                yield text[begin : brace.end()]


def paragraphs(text: str) -> list[str]:
    """The parts of a text between blank lines."""
    return [part for part in map(str.strip, re.split(r"\n[ \t\r]*\n", text)) if part]


def peeled(text: str) -> Iterator[tuple[str, str]]:
    """An answer with one outer layer less each time: quotes, brackets, bold, bullets, remarks.

    Each comes with the remark in brackets that followed it.
    """
    remark = ""
    for _ in range(_DEPTH):
        text = text.strip()
        yield text, remark
        inner = _inner(text)
        if inner == text and (said := _REMARK.fullmatch(text)):
            inner, remark = said["said"], said["remark"]
        if inner == text:
            return
        text = inner


def _inner(text: str) -> str:
    for begin, end in _AROUND.get(text[:1], ()):
        if len(text) > len(begin) + len(end) and text.startswith(begin) and text.endswith(end):
            inner = text[len(begin) : -len(end)]
            if (begin[-1] not in inner and end not in inner) or _balanced(inner, begin[-1], end):
                return inner
    bullet = _BULLET.match(text)
    if bullet and bullet.end() < len(text):
        return text[bullet.end() :]
    return text[:-1].rstrip() if text[-1:] in (".", ",", ";", "!") else text


def _balanced(inner: str, begin: str, end: str) -> bool:
    """Whether all brackets in a text are closed; False for marks that open and close with the same character."""
    depth = 0 if begin != end else -1
    for character in inner:
        depth += (character == begin) - (character == end)
        if depth < 0:
            return False
    return depth == 0
