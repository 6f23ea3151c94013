"""Text in: actions written as text, strict in meaning and tolerant in form. Nothing is ever executed.

An answer is what the world itself reads as an action (`World.read`: its words for actions), or JSON: a number, a string
with such a word, a list, an object with `action` among its keys, or, where actions are dicts, one with their keys. It
may stand behind a label such as `Response:`, in a fence, a box of TeX, a tag, in bold, quotes or brackets; a remark may
follow behind a blank line or in brackets; reasoning that is marked is cut. Two different actions are none.

Where the world's action is itself a text that is taken word for word, only reasoning, labels and fences are cut.
"""

import re
from itertools import islice
from typing import Any

from gymnasium import spaces

from pz_envs.answers import Parted, split_thought
from pz_envs.forms import behind_marker, fenced, labelled, paragraphs, spans, tagged, unlabelled, without_stops
from pz_envs.pieces import LONGEST, TwoActions, read_piece, strict_value, the_one
from teachers.atoms import ParseFailure
from worlds.world import World

__all__ = ["failure", "legal_text", "parse_action", "read_exactly", "read_text", "read_verbatim"]

_MARKER = re.compile("response:", re.IGNORECASE)
_EXCERPT = 80
_MANY = 20  # parts of a text that may each be an answer
_SEVERAL = re.compile(r"\n|[,;]|\b(?:and|then|or)\b")
_LIST = re.compile(r"[\[(][^\[\]()]{1,200}[\])]")
_WORD = re.compile(r"[A-Za-z0-9_-]+(?:\.[0-9]+)*")

EMPTY = "it holds no answer"
UNENDED = "its reasoning never ends, so that no answer follows"
NOTHING = "it names no action that there is"
MORE = "it says more than one action, and nothing marks that one as the answer"
UNFIT = "it is too long, or has characters that are not allowed"


def read_text(action: Any, world: World[Any]) -> Any:
    """What a student wrote, as an action in canonical form, or a `ParseFailure`.

    Args:
        action: a string, or what `split_thought` made of it.
        world: the world whose action it is.

    Raises:
        ValueError: it is neither.
    """
    return parse_action(_checked(action), world)


def read_verbatim(action: Any, world: World[Any]) -> Any:
    """A text, taken as it is by a world whose actions are texts, or a `ParseFailure`; as in `read_text`."""
    said = _checked(action)
    return legal_text(said.text if isinstance(said, Parted) else said, world)


def _checked(action: Any) -> str | Parted:
    if not isinstance(action, str | Parted):
        raise ValueError(f"the student's action must be a string, got {action!r}; the state is unchanged")
    return action


def parse_action(said: str | Parted, world: World[Any]) -> Any:
    """The action that a text stands for, in canonical form, or a `ParseFailure`.

    Args:
        said: the text, or what `split_thought` made of it.
        world: the world whose action it is.
    """
    thought, answer, text, unended = split_thought(said)
    unended = unended and bool(thought) and not answer
    if unended and _MARKER.search(text):
        answer = behind_marker(text) or ""  # reasoning that never ends, and yet gives an answer
    got = answer if thought and answer else text
    answer = without_stops(answer)
    if not answer.strip() and (thought or not (world.verbatim and isinstance(world.action_space, spaces.Text))):
        return failure(got, world, UNENDED if unended else EMPTY)
    try:
        return _text(answer, world) if isinstance(world.action_space, spaces.Text) else _read(answer, got, world)
    except TwoActions as error:
        return failure(got, world, f"{error}")


def read_exactly(text: str, world: World[Any]) -> Any:
    """The action of a text that is an action and nothing else, or a `ParseFailure`.

    Before it may stand anything that ends with `Response:`.
    """
    start = 0
    for marker in _MARKER.finditer(text):
        start = marker.end()
    answer = text[start:].strip()
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
    action = read_exactly(answer, world)
    if type(action) is ParseFailure:
        action = _tolerantly(answer, world)
    return failure(got, world, _reason(answer, world)) if action is None else action


def _text(answer: str, world: World[Any]) -> Any:
    """The action of a world whose actions are texts."""
    if not world.verbatim:
        action = _tolerantly(answer, world)
        action = read_exactly(answer, world) if action is None else action
        return failure(answer, world) if type(action) is ParseFailure else action
    behind = behind_marker(answer)
    text = unlabelled(answer.strip(), world.answer_names) if behind is None else behind
    blocks = set(islice(fenced(text), _MANY)) or set(tagged(text))
    if len(blocks) > 1:
        raise TwoActions("its fences hold different texts")
    text = unlabelled(blocks.pop(), world.answer_names) if blocks else text
    return legal_text(text, world)


def _tolerantly(answer: str, world: World[Any]) -> Any:
    """The one action that an answer names; None if it names none."""
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
    """The one action of a text that is marked in it, or its first paragraph; what else is there are remarks."""
    marked = [read_piece(span, world) for span in islice(spans(text), _MANY)]
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
    """Why an answer is no action."""
    pieces = islice((piece for form in (_LIST, _WORD) for piece in form.findall(answer[:LONGEST])), 200)
    the_one(named := [read_piece(piece, world) for piece in pieces])
    return MORE if any(action is not None for action in named) else NOTHING
