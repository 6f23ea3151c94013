"""Reads a student's text as an action, strict in meaning and tolerant in form. Nothing is ever executed.

- An answer is what the world itself reads as an action (`World.read`: its words for actions), or JSON: a number, a
  string with such a word, a list, an object with the key `action`, or, where actions are dicts, one with their keys.
- It may stand behind a label such as `Response:`, in a fence, a box of TeX, a tag, bold type, quotes or brackets. A
  remark may follow after a blank line or in brackets.
- Marked reasoning is cut, and so are turns that the model invents for others.
- A text with two different actions is refused, and so is an action that is denied or taken back.
- Where the world takes a text word for word, only the wrapping is cut: reasoning, labels, fences, tags, JSON, a title.
"""

import json
import re
from itertools import islice
from typing import Any

from gymnasium import spaces

from pz_envs.text.action_parsing import LONGEST, TwoActions, misnamed, read_piece, strict_value, text_in, the_one
from pz_envs.text.reply_markup import (
    behind_marker,
    fenced,
    labelled,
    paragraphs,
    spans,
    tagged,
    unlabelled,
    unquoted,
    verse,
    visible,
    without_stops,
)
from pz_envs.text.thoughts import SplitReply, split_thought, turns_of_others
from teachers.atoms import ParseFailure
from worlds.world import World

__all__ = ["failure", "first_answer", "legal_text", "parse_action", "read_exactly", "read_text", "read_verbatim"]

_MARKER = re.compile("response[:\uff1a]", re.IGNORECASE)
_EXCERPT = 80
_FEW = 5  # places where an answer may end
_MANY = 20  # parts of a text that may each be an answer
_SEVERAL = re.compile(r"\n|[,;]|\b(?:and|then|or)\b")
_LIST = re.compile(r"[\[(][^\[\]()]{1,200}[\])]")
_WORD = re.compile(r"[A-Za-z0-9_-]+(?:\.[0-9]+)*")
_CALL = re.compile(r"[A-Za-z_][\w.]*\(.*\)", re.DOTALL)
_RULE = re.compile(r"\n[ \t]*[-=*_]{3,}+$")  # a line between turns
_THOUGHT = re.compile(r"[\s*_#>]{0,9}(?:thoughts?|thinking|reasoning)[*_ ]{0,3}[:\uff1a]", re.IGNORECASE)
_NOT = re.compile(
    r"(?=[nacoris])(?:(?<!have )(?<!has )(?<!that are )(?<!which are )\bnot|(?<!have)(?<!has)n['\u2019]t"
    r"|\b(?:never|cannot|avoid|skip|except|other than|rather than|instead of|anything but))\b"
    r"(?P<what>(?>(?:[^,;.!?\n()\[\]{}]|[,.](?=[0-9])|\[[^\[\]]*\]|\([^()]*\)|\{[^{}]*\})*))",  # 3.11.2 fails on *+
    re.IGNORECASE,
)
_UNIT = r"cm|mm|km|centimet\w+|millimet\w+|inch(?:es)?|feet|degrees?|radians?|percent|%"
_BACK = re.compile(
    rf"""
    (?:^|[.!?;(\u2013\u2014-]) \s{{0,3}}+ (?=[a-z]) (?:hmm[,.]?\ )?(?: no(?=[,.!;)]|\ wait|$)
      | (?:nope|wait|hold\ on|actually|correction|oops|scratch\ that|never\ ?mind|on\ second\ thought
        |or(?!\ so\b)|i\ meant?|sorry|cancel|disregard|(?:just\ )?kidding|edit(?=:)|on\ reflection|alternatively)\b )
    | , \s{{0,3}}+ (?:no(?=[,;)])|wait\b) | \(or\b | \bchanged\ my\ mind
    | \b(?:that|this|it)(?:\ is|['\u2019]s|\ was|\ seems|\ looks)
      \ (?:wrong|incorrect|a\ mistake|not\ (?:right|correct|it|true|my\ (?:final\ )?answer))\b
    | \(\s*+(?:do\ not|don['\u2019]t)\ (?:do|take|use|try|choose)\b
    | \(\s*+(?=[a-z%])(?:(?:all|values|both|units?|are|in|the)\ )*(?:wrong|incorrect|rejected|forbidden|reversed?
      |reverse\ order|opposite|swapped|inverted|negated|not|{_UNIT})\s*\)
    | (?<=[\])]\ )(?:is|was|would\ be)\ (?:not|wrong|bad|a\ mistake)\b
    """,
    re.IGNORECASE | re.VERBOSE | re.MULTILINE,
)

EMPTY = "it holds no answer"
UNENDED = "its reasoning never ends, so that no answer follows"
NOTHING = "it names no action that there is"
MORE = "it says more than an action, and nothing marks the action as the answer"
NOT = "it says what not to do, which is no action"
BACK = "it takes its answer back, or changes it"
CODE = "it is written as code, which nothing executes"
ORDER = "it names the numbers in another order"
UNMARKED = "it begins with a thought, and nothing marks where the answer begins"
WRAPPED = "it is JSON without the text of an answer"
UNFIT = "it is too long, or has characters that are not allowed"


def read_text(action: Any, world: World[Any]) -> Any:
    """A student's text as an action in canonical form, or a `ParseFailure`.

    Args:
        action: a string or a `SplitReply`.
        world: the world in which the student acts.

    Raises:
        ValueError: the action is neither.
    """
    return parse_action(_checked(action), world)


def read_verbatim(action: Any, world: World[Any]) -> Any:
    """A text, unchanged, as the action of a world whose actions are texts; otherwise as `read_text`."""
    if type(action) is str:
        return legal_text(action, world)
    said = _checked(action)
    return legal_text(said.text if isinstance(said, SplitReply) else said, world)


def _checked(action: Any) -> str | SplitReply:
    if not isinstance(action, str | SplitReply):
        raise ValueError(f"the student's action must be a string, got {action!r}; the state is unchanged")
    return action


def parse_action(said: str | SplitReply, world: World[Any]) -> Any:
    """The action in a text, in canonical form, or a `ParseFailure`.

    Args:
        said: a text or a `SplitReply`.
        world: the world in which the student acts.
    """
    thought, answer, text, unended = split_thought(said)
    unended = unended and bool(thought) and not answer
    if unended and _MARKER.search(text):
        answer = behind_marker(text) or ""  # reasoning without an end may still give an answer
    got = answer if thought and answer else text
    answer = without_stops(first_answer(answer, world)[0])
    if not answer.strip() and (thought or not (world.verbatim and isinstance(world.action_space, spaces.Text))):
        return failure(got, world, UNENDED if unended else EMPTY)
    try:
        return _verbatim(answer, world) if _is_verbatim(world) else _read(visible(answer), got, world)
    except TwoActions as error:
        return failure(got, world, f"{error}")


def first_answer(answer: str, world: World[Any] | None) -> tuple[str, str]:
    """An answer up to the first turn that the model invents for others, and the rest.

    A turn of others before any answer is a quotation and belongs to the answer.

    Args:
        answer: a text without reasoning.
        world: the world in which the student acts; None: only `Response:` marks an answer.
    """
    for begin in islice(turns_of_others(answer), _FEW):
        said = _RULE.sub("", answer[:begin].strip())
        if behind_marker(said) or (world is not None and said and _answers(said, world)):
            return said, answer[begin:]
    return answer, ""


def _answers(said: str, world: World[Any]) -> bool:
    """Whether a text without `Response:` is an answer."""
    if _is_verbatim(world):
        return "\n" in said and not _THOUGHT.match(said)
    return _is_action(said, world)


def _is_verbatim(world: World[Any]) -> bool:
    return world.verbatim and isinstance(world.action_space, spaces.Text)


def read_exactly(text: str, world: World[Any]) -> Any:
    """The action of a text that holds nothing else, or a `ParseFailure`.

    Any text that ends with `Response:` may precede it, but no other answer.
    """
    _, *others, answer = map(str.strip, ["", *_MARKER.split(text)])
    if any(others[1:]) and not _is_verbatim(world):
        return failure(text, world, MORE)
    if isinstance(world.action_space, spaces.Text):
        return legal_text(answer, world)
    if len(answer) > LONGEST:
        return failure(text, world)
    try:
        action = world.read(answer)
        return world.legal(strict_value(answer, world) if action is None else action)
    except (ValueError, TypeError, OverflowError, RecursionError):
        return failure(text, world)


def legal_text(text: str, world: World[Any]) -> Any:
    """The text as an action of a world whose actions are texts, or a `ParseFailure`."""
    try:
        return world.legal(text)
    except ValueError:
        return failure(text, world, UNFIT if world.verbatim else NOTHING)


def failure(text: str, world: World[Any], why: str = NOTHING) -> ParseFailure:
    """The failure to read a text, with a printable excerpt."""
    excerpt = text[:_EXCERPT] if len(text) <= _EXCERPT else text[: _EXCERPT - 3] + "..."
    return ParseFailure("".join(c if c.isprintable() else " " for c in excerpt), world.action_syntax, why)


def _read(answer: str, got: str, world: World[Any]) -> Any:
    """The action of an answer in a world that does not take texts word for word."""
    if answer.strip().lower() in world.action_words:  # a word may be `wait` or `do not move`
        return read_exactly(answer, world)
    kept = _without_denied(answer, world)
    begin = next((label.begin for label in labelled(kept, world.answer_names)), 0)
    backs = islice(_BACK.finditer(unquoted(kept), begin), _FEW)
    if any(_is_action(kept[: back.start()], world) for back in backs):
        return failure(got, world, BACK)
    if misnamed(kept[begin:], world.action_parts):
        return failure(got, world, ORDER)
    action = _action(kept, world)
    if action is not None:
        return action
    if not isinstance(world.action_space, spaces.Text):
        return failure(got, world, NOT if kept != answer else _reason(answer, world))
    action = read_exactly(answer, world)
    if kept != answer or (type(action) is not ParseFailure and _NOT.search(unquoted(answer))):
        return failure(got, world, NOT)
    if type(action) is ParseFailure:
        return action
    code, several = _CALL.fullmatch(answer), "\n" in answer.strip()
    return failure(got, world, CODE if code else MORE) if code or several else action


def _action(text: str, world: World[Any]) -> Any:
    """The action of a text in any form; None: it has none."""
    action = None if isinstance(world.action_space, spaces.Text) else read_exactly(text, world)
    return _tolerantly(text, world) if action is None or type(action) is ParseFailure else action


def _is_action(text: str, world: World[Any]) -> bool:
    """Whether a text has at least one action."""
    try:
        return _action(text, world) is not None
    except TwoActions:
        return True


def _without_denied(answer: str, world: World[Any]) -> str:
    """The text without the actions that it denies, as in `not north`."""
    kept, at = "", 0
    for found in islice(_NOT.finditer(unquoted(answer)), _MANY):
        if _is_action(answer[slice(*found.span("what"))].strip(), world):
            kept, at = kept + answer[at : found.start()], found.end()
    return kept + answer[at:]


def _verbatim(answer: str, world: World[Any]) -> Any:
    """The action of an answer in a world that takes texts word for word."""
    behind = behind_marker(answer)
    if behind is None and _THOUGHT.match(answer):
        return failure(answer, world, UNMARKED)
    text = unlabelled(answer.strip("\u200b\ufeff \t\r\n"), world.answer_names) if behind is None else behind
    blocks = set(islice(fenced(text), _MANY)) or set(tagged(text, world.answer_names))
    if len(blocks) > 1:
        raise TwoActions("its fences hold different texts")
    text = unlabelled(blocks.pop(), world.answer_names) if blocks else text
    text = verse(text)
    if text[:1] + text[-1:] in ("{}", "[]"):
        try:
            inner = text_in(json.loads(text, strict=False), world.answer_names)
        except (ValueError, RecursionError):
            inner = None
        if inner is None and text[0] == "{":
            return failure(answer, world, WRAPPED)
        text = text if inner is None else inner
    return legal_text(text if (named := world.read(text)) is None else named, world)


def _tolerantly(answer: str, world: World[Any]) -> Any:
    """The only action that an answer names; None: it names none."""
    action = read_piece(answer, world)
    if action is not None:
        return action
    labels = list(islice(labelled(answer, world.answer_names), _MANY + 1))
    if not labels or len(labels) > _MANY:
        return None if labels else _region(answer, world)
    *others, last = (_region(label.body, world) for label in labels)
    before = (read_piece(part, world) for part in paragraphs(answer[: labels[0].begin])[:_MANY])
    return None if last is None else the_one([last, *others, *before])


def _region(text: str, world: World[Any]) -> Any:
    """The only action that a text marks or has as its first paragraph; all else is remarks. None: there is none."""
    marked = [read_piece(span, world) for span in islice(spans(text, world.answer_names), _MANY)]
    parts = paragraphs(text)[:_MANY]
    read = [read_piece(part, world) for part in parts]
    if not any(action is not None for action in (*marked, *read[:1])):
        if parts and len(pieces := _SEVERAL.split(parts[0])) <= _MANY:
            several = [read_piece(piece, world) for piece in pieces if piece.strip()]
            if None not in several:
                the_one(several)
        return None
    return the_one([*marked, *read])


def _reason(answer: str, world: World[Any]) -> str:
    """Why an answer is not an action."""
    pieces = islice((piece for form in (_LIST, _WORD) for piece in form.findall(answer[:LONGEST])), 200)
    the_one(named := [read_piece(piece, world) for piece in pieces])
    if all(action is None for action in named):
        return NOTHING
    return CODE if _CALL.search(answer[:LONGEST]) else NOT if _NOT.search(answer[:LONGEST]) else MORE
