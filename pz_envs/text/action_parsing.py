"""Reads a piece of text as an action: one of the world's words, or a value."""

import json
import re
from collections.abc import Iterable
from functools import cache
from typing import Any

from gymnasium import spaces

from pz_envs.text.json_values import finite_value
from pz_envs.text.reply_markup import peeled
from worlds.world import World

__all__ = ["LONGEST", "TwoActions", "misnamed", "read_piece", "strict_value", "text_in", "the_one"]

LONGEST = 1000
"""Greatest length of an answer in a world whose actions are not texts."""
_KEYS = ("action", "answer", "response", "final_answer", "move", "choice", "command", "output")
_TOOL = ("arguments", "parameters", "args", "function", "function_call", "tool_call", "tool_calls")
_FILLERS = frozenset(
    (
        *("i", "i'll", "i'd", "we", "we'll", "will", "let", "let's", "me", "us", "my", "the", "a", "is", "be", "to"),
        *("answer", "action", "response", "choice", "move", "number", "option", "final", "now", "next", "then", "so"),
        *("choose", "pick", "select", "take", "try", "use", "go", "going", "therefore", "please", "it", "should"),
    )
)
_LEADING = re.compile(r"([A-Za-z]+(?:['\u2019][A-Za-z]+)?)[,:]?\s+(?:#(?=[0-9]))?")
_TRAILING = re.compile(r"\s([A-Za-z]+)$")
_NUMBER = r"[-+]?(?:[0-9]{1,40}(?:\.[0-9]{0,40})?|\.[0-9]{1,40})(?:[eE][-+]?[0-9]{1,5})?"
_NUMBERS = re.compile(rf"{_NUMBER}(?:(?:[ \t]*[,;]\s*|\s+){_NUMBER})*+(?:\s*,)?")
_PART = re.compile(rf"[\"']?([A-Za-z][A-Za-z0-9_]{{0,20}})[\"']?[ \t]*[:=][ \t]*({_NUMBER})(?=[\s,;&]|$)")
_BETWEEN = re.compile(r"(?:[\s,;&]|\band\b)*")
_NUMBERED = re.compile(r"([0-9]{1,4})[ \t]*[:.)=\u2013-][ \t]+(\S.*)|(\S.*?)[ \t]*[:=\u2013-][ \t]*([0-9]{1,4})")
_QUOTED = re.compile(r"\"(?:[^\"\\]|\\.)*+(?:\"|$)|'(?:[^'\\]|\\.)*+(?:'|$)", re.DOTALL)
_UNENDED = re.compile(rf"(?P<quoted>{_QUOTED.pattern})|,(?=\s*+[\]}}])", re.DOTALL)
_SHORT = 200  # greatest length of a sentence with an action
_WORDS = 8  # greatest number of words before and after the action
_DEPTH = 8  # greatest depth of texts within texts


class TwoActions(Exception):  # noqa: N818 (it is no error of the program)
    """An answer names different actions; the message lists them."""


def read_piece(piece: str, world: World[Any], depth: int = 0, sentences: bool = True) -> Any:
    """The action of a piece in canonical form; None: it is no action.

    Raises:
        TwoActions: the piece names different actions.
    """
    longest = max(LONGEST, getattr(world.action_space, "max_length", 0))
    if depth > _DEPTH or len(piece) > 2 * longest:
        return None
    for form, remark in peeled(piece):
        action = _meaning(form, world, depth, sentences) if 0 < len(form) <= longest else None
        if action is not None:
            return the_one([action, _in_sentence(remark, world) if remark else None])
    return None


def the_one(actions: Iterable[Any], whence: str = "") -> Any:
    """The action that all readings but None agree on; None: there is none.

    Raises:
        TwoActions: the readings differ.
    """
    found = [action for action in actions if action is not None]
    for other in found[1:]:
        if other != found[0]:
            raise TwoActions(f"it names different actions{whence}, {found[0]!s:.40} and {other!s:.40}")
    return found[0] if found else None


def strict_value(answer: str, world: World[Any]) -> Any:
    """The value of a text that is JSON or a list in round brackets; the only key of an object must be `action`.

    Raises:
        ValueError, RecursionError: the text is neither.
    """
    if answer.startswith("(") and answer.endswith(")"):
        answer = f"[{answer[1:-1]}]"
    value = finite_value(answer)
    space = world.action_space
    keys = space.spaces.keys() if isinstance(space, spaces.Dict) else ()
    if isinstance(value, dict) and list(value) == ["action"] and "action" not in keys:
        value = value["action"]
    if isinstance(value, dict) and not keys:
        raise ValueError("the only key of an object must be `action`")
    if isinstance(value, str):
        action = world.read(value)
        return value if action is None else action
    if _has_truth_value(value):
        raise ValueError("a truth value is not an action")
    return value


def _meaning(form: str, world: World[Any], depth: int, sentences: bool) -> Any:
    """The action of a bare form; None if it is not an action."""
    for read in (_word, _values, _numbers, _numbered):
        action = read(form, world)
        if action is not None:
            return action
    action = _from_value(_decoded(form), world, depth)
    return _in_sentence(form, world) if action is None and sentences else action


def _legal(action: Any, world: World[Any]) -> Any:
    try:
        return world.legal(action)
    except (ValueError, TypeError, OverflowError, RecursionError):
        return None


def _word(form: str, world: World[Any]) -> Any:
    """The action for one of the world's words, or for a number if actions are numbers; else None."""
    try:
        action = world.read(form)
    except (ValueError, TypeError, OverflowError, RecursionError):
        return None
    if action is None and isinstance(world.action_space, spaces.Discrete) and form.isascii():
        try:
            action = finite_value(form)
        except (ValueError, RecursionError):
            return None
        return _legal(action, world) if type(action) is int else None
    return None if action is None else _legal(action, world)


def _numbers(form: str, world: World[Any]) -> Any:
    """The action of a list of numbers without brackets, separated by commas or spaces; else None."""
    shape = getattr(world.action_space, "shape", None)
    if isinstance(world.action_space, spaces.Discrete) or shape is None or len(shape) > 1:
        return None
    form = form.replace("\u2212", "-")
    if not _NUMBERS.fullmatch(form):
        return None
    numbers = [_number(each) for each in re.findall(_NUMBER, form)]
    return _legal(numbers if shape else numbers[0] if len(numbers) == 1 else None, world)


def _values(form: str, world: World[Any]) -> Any:
    """The action of numbers with names, as in `x1 = 1, x2 = 2`; else None."""
    names = world.action_parts
    if not names or len(form) > LONGEST:
        return None
    named: dict[str, Any] = {}
    at = 0
    if header := _listing(names).match(form):  # as in `[x1, x2] = [1, 2]`
        return read_piece(form[header.end() :], world, _DEPTH, sentences=False)
    form = form.replace("\u2212", "-")
    while part := _PART.match(form, at):
        if part[1].lower() in named:
            return None
        named[part[1].lower()] = _number(part[2])
        between = _BETWEEN.match(form, part.end())
        at = between.end() if between else part.end()
    if at < len(form) or named.keys() != set(names):
        return None
    return _legal([named[name] for name in names], world)


@cache
def _listing(names: tuple[str, ...]) -> re.Pattern[str]:
    return re.compile(r"[\[(]?\s*" + r"\s*,\s*".join(names) + r"\s*[\])]?\s*[:=]", re.IGNORECASE)


def misnamed(text: str, names: tuple[str, ...]) -> bool:
    """Whether a text lists all names of an action's numbers in another order."""
    name = rf"\b(?:{'|'.join(names)})\b"
    listed = re.findall(rf"{name}(?:\s*,\s*{name})+", text.lower().replace("x_", "x")) if names else ()
    words = [tuple(re.split(r"\W+", each)) for each in listed]
    return any(each != names and sorted(each) == sorted(names) for each in words)


def text_in(value: Any, names: Iterable[str]) -> str | None:
    """The text in a JSON value: a string, a list of lines, or an object with one of these names; None without a text.

    Raises:
        TwoActions: it has different texts.
    """
    if isinstance(value, list) and value and all(isinstance(line, str) for line in value):
        return "\n".join(value)
    if isinstance(value, dict):
        lower = {key.lower(): each for key, each in value.items()}
        found = [text_in(lower[key], names) for key in (*_KEYS, *names, *_TOOL) if key in lower]
        text: str | None = the_one(found)
        return text
    return value if isinstance(value, str) else None


def _numbered(form: str, world: World[Any]) -> Any:
    """The action of a word with its number, as in `2: west`, if both agree; else None."""
    found = _NUMBERED.fullmatch(form) if world.action_words and len(form) <= _SHORT else None
    if not found:
        return None
    number, word = _word(found[1] or found[4], world), _word(found[2] or found[3], world)
    return None if number is None or word is None else the_one([number, word])


def _in_sentence(form: str, world: World[Any]) -> Any:
    """The action in a sentence of fillers, as in `I choose arm 3`; else None."""
    if len(form) > _SHORT:
        return None
    own = {part for word in world.action_words for part in word.split()}
    fillers = (_FILLERS | set(world.action_fillers)) - own
    for _ in range(_WORDS):
        trailing = _TRAILING.search(form)
        if not trailing or trailing[1].lower() not in fillers:
            break
        form = form[: trailing.start()].rstrip(" ,")
    for _ in range(_WORDS):
        action = read_piece(form, world, _DEPTH, sentences=False)
        leading = _LEADING.match(form)
        if action is not None or not leading or leading[1].replace("\u2019", "'").lower() not in fillers:
            return action
        form = form[leading.end() :]
    return None


def _from_value(value: Any, world: World[Any], depth: int) -> Any:
    """The action of a JSON value; None if it is not an action."""
    if isinstance(value, str):
        return read_piece(value, world, depth + 1)
    if isinstance(value, dict):
        return _from_object(value, world, depth)
    if value is None or _has_truth_value(value):
        return None
    if isinstance(world.action_space, spaces.Box) and isinstance(value, list):
        value = [_number(n) if isinstance(n, str) and re.fullmatch(_NUMBER, n) else n for n in value]
    action = _word(json.dumps(value), world) if isinstance(world.action_space, spaces.Text) else _legal(value, world)
    if action is None and isinstance(value, list) and len(value) == 1 and depth < _DEPTH:
        return _from_value(value[0], world, depth + 1)
    return action


def _from_object(value: dict[str, Any], world: World[Any], depth: int) -> Any:
    """The action of a JSON object or of one of its keys; None without an action."""
    space = world.action_space
    keys = set(space.spaces) if isinstance(space, spaces.Dict) else set()
    if keys and value.keys() == keys:
        return None if _has_truth_value(value) else _legal(value, world)
    lower = {key.lower(): each for key, each in value.items()}
    wanted = [key for key in (*_KEYS, *world.answer_names) if key in lower and key not in keys]
    if not wanted:
        wanted = [key for key in _TOOL if isinstance(lower.get(key), dict | list | str)]
    if not wanted and (names := world.action_parts) and lower.keys() >= set(names):
        return _from_value([lower[name] for name in names], world, depth)
    if depth >= _DEPTH:
        return None
    actions = [_from_value(lower[key], world, depth + 1) for key in wanted]
    action = the_one(actions, f" by {' and '.join(map(repr, wanted))}")
    return action if actions and actions[0] is not None else None


def _decoded(form: str) -> Any:
    """The value of a text in JSON, with single or double quotes; None if it has none."""
    if form[:1] not in ("{", "[", '"', "("):
        return None
    for text in (form, _double_quoted(form), _UNENDED.sub(_without_comma, _double_quoted(form))):
        try:
            return finite_value(f"[{text[1:-1]}]" if text.startswith("(") and text.endswith(")") else text)
        except (ValueError, RecursionError):
            continue
    return None


def _without_comma(found: re.Match[str]) -> str:
    """A quotation as it is; nothing for a comma behind the last part."""
    return found["quoted"] or ""


def _double_quoted(text: str) -> str:
    return _QUOTED.sub(lambda found: _requoted(found[0]), text)


def _requoted(quoted: str) -> str:
    if quoted[0] == '"':
        return quoted
    inner = quoted[1:-1] if len(quoted) > 1 and quoted[-1] == "'" else quoted[1:]
    return '"' + inner.replace("\\'", "'").replace('"', '\\"') + '"'


def _number(digits: str) -> int | float:
    return int(digits) if digits.lstrip("+-").isdigit() else float(digits)


def _has_truth_value(value: Any) -> bool:
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return isinstance(value, bool) or any(map(_has_truth_value, parts))
