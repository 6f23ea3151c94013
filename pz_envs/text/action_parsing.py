"""Reads a sentence as an action: a word of the world or a value, among words that only choose it."""

import json
import re
from collections.abc import Iterable
from functools import cache
from itertools import islice
from typing import Any

from gymnasium import spaces

from pz_envs.text.answer_place import masked, sentences
from pz_envs.text.json_values import finite_value, lenient_value
from worlds.world import World

__all__ = [
    "LONGEST",
    "TwoActions",
    "denies",
    "exact_action",
    "from_json",
    "has_truth_value",
    "names_any",
    "read_line",
    "read_sentence",
    "text_in",
    "the_one",
]

LONGEST = 1000
"""Greatest length of an answer in a world whose actions are not texts."""
_KEYS = ("action", "answer", "response", "final_answer", "move", "choice", "command", "output")
_TOOL = ("arguments", "parameters", "args", "function", "function_call", "tool_call", "tool_calls")
_BOTH = "the my now next then first please again here instead answer choice this is it"
_LEADING = frozenset(
    f"""{_BOTH} a me us our your to so thus hence therefore ok okay sure yes well just definitely certainly simply
    i i'll i'd i'm am we we'll we'd let let's will would should must shall be want plan think propose suggest recommend
    prefer choose pick select take try use using go going do say make move stick follow following teacher's advice and
    with here's final best correct right optimal decision action response command number option that - \u2013 :
    """.split()
)
"""Words before an action that only choose it."""
_TRAILING = frozenset(f"{_BOTH} turn time final best too direction way action move".split())
"""Words behind an action that do not change it."""
_AROUND = " \t\r\n*_`\"'\u201c\u201d\u2018\u2019\u00ab\u00bb"
_BRACKETS = {"[": "]", "(": ")", "{": "}", "<": ">"}
_BULLET = re.compile(r"(?:[>#*\u2022-]+|[-=]>|\u2192)[ \t]+|[0-9]{1,2}[.)][ \t]+(?=[A-Za-z*`\"])")
_YOU = re.compile(r"\A\W*you (?=(?:should|must)\b)", re.IGNORECASE)
_NEXT = re.compile(r"[\s*_`]*([A-Za-z]+)")
_WORD = re.compile(r"[^\s,;:(]+")
_OWN_CLAUSE = re.compile(r",\s+(?:(?:but|so|and|then|therefore)\s+)?(?=(?:i|i'll|i'd|i'm|we|we'll|let|let's)\s)")
_CONDITION = re.compile(r"\W*(?:if|when|unless|had|were|whether|until|before)\b", re.IGNORECASE)
_CAUSE = re.compile(r"\W{0,3}(?:because|since|as|for|so|which|that|where|in order|to(?! [\[(0-9]))\b", re.IGNORECASE)
_BUT_NOT = re.compile(r"\W{0,3}(?:(?:and |but )?not\b(?!\W*$)|instead of\b|rather than\b)", re.IGNORECASE)
_OTHERWISE = re.compile(
    r"\W*(?:or|but|if|unless|when|wait|scratch|no(?=\W*$|[,.;!]| wait)|do not|don't)\b", re.IGNORECASE
)
_REMARK = re.compile(r"\s*(?:[,;:(\u2013\u2014]|[-=] )")
_CHANGED = frozenset(
    (
        *("cm", "mm", "km", "inch", "inches", "feet", "degrees", "radians", "percent", "centimetres", "centimeters"),
        *("reverse", "reversed", "opposite", "swapped", "inverted", "negated", "flipped"),
        *("wrong", "incorrect", "rejected", "forbidden", "not"),
    )
)
"""Words of a remark that make an action another."""
_DENIAL = re.compile(
    r"\b(?:not|never|cannot|avoid|skip|except|than|instead|but|without)\b|n['\u2019]t\b", re.IGNORECASE
)
_SYMBOLS = re.compile(r"[()\[\]'\"?\\{}|/%!$+*^]+")
_NUMBER = r"[-+]?(?:[0-9]{1,40}(?:\.[0-9]{0,40})?|\.[0-9]{1,40})(?:[eE][-+]?[0-9]{1,5})?"
_NUMBERS = re.compile(rf"{_NUMBER}(?:(?:[ \t]*[,;]\s*|\s+){_NUMBER})*+(?:\s*,)?")
_PART = re.compile(rf"[\"']?([A-Za-z][A-Za-z0-9_]{{0,20}})[\"']?[ \t]*[:=][ \t]*({_NUMBER})(?=[\s,;&]|$)")
_BETWEEN = re.compile(r"(?:[\s,;&]|\band\b)*")
_SHORT = 300  # greatest length of a sentence with an action and other words
_WORDS = 12  # greatest number of words before an action, and in it
_SCANNED = 60  # words of a refused text
_PIECES = 8  # parts of a remark that may name an action
_DEPTH = 8  # greatest depth of texts within texts


class TwoActions(Exception):  # noqa: N818 (it is no error of the program)
    """An answer names different actions; the message lists them."""


def the_one(actions: Iterable[Any]) -> Any:
    """The action that all readings but None agree on; None: there is none.

    Raises:
        TwoActions: the readings differ.
    """
    found = [action for action in actions if action is not None]
    for other in found[1:]:
        if other != found[0]:
            raise TwoActions(f"it names different actions, {found[0]!s:.40} and {other!s:.40}")
    return found[0] if found else None


# Sentences.


def read_line(text: str, world: World[Any], depth: int = 0) -> Any:
    """The action of a text that is one, else that of a sentence on its first line; None: it has none."""
    if (action := exact_action(text, world, depth)) is not None:
        return action
    found = sentences(text)
    end = text.find("\n", found[0][1]) if found else 0
    line = [said for said, until in found if end < 0 or until <= end]
    return next((action for said in line if (action := read_sentence(said, world, depth)) is not None), None)


def read_sentence(text: str, world: World[Any], depth: int = 0) -> Any:
    """The action that a sentence chooses; a remark may follow. None: it chooses none.

    Raises:
        TwoActions: the remark names another action.
    """
    if (action := exact_action(text, world, depth)) is not None:
        return action
    text = _YOU.sub("", _bare(text), count=1)  # "you go north" may tell a story
    lists = isinstance(world.action_space, spaces.Text) and "[" in text
    if text.endswith("?") or (len(text) > _SHORT and not lists):
        return None
    begins = [0]
    if lists:
        begins = [] if denies(text[: text.index("[")]) else [text.index("[")]
    elif not _CONDITION.match(text):
        begins += [own.end() for own in _OWN_CLAUSE.finditer(text.lower().replace("\u2019", "'"))]
    return next((found for begin in begins if (found := _chosen(text, begin, world, depth)) is not None), None)


def names_any(text: str, world: World[Any]) -> bool:
    """Whether some words of a text, in a row, are an action; the first `_SCANNED` words are read."""
    for form in (text, _SYMBOLS.sub(" ", text)):
        words = list(islice(_WORD.finditer(masked(form)), _SCANNED))
        spans = ((first.start(), last.end()) for at, first in enumerate(words) for last in words[at : at + _WORDS // 2])
        if any(exact_action(form[begin:end], world) is not None for begin, end in spans):
            return True
    return False


def denies(text: str) -> bool:
    """Whether the words before an action deny it; of an announcement that ends with a colon, its first four do."""
    clause = re.split(r"[.!?;\n]", masked(text))[-1].rstrip("*_`$\\( ")
    return bool(_DENIAL.search(" ".join(clause.split()[:4]) if clause.endswith(":") else clause))


def _chosen(text: str, begin: int, world: World[Any], depth: int) -> Any:
    """The action that a clause names behind words that only choose it."""
    own = {part for word in world.action_words for part in word.split()}
    leading = (_LEADING | set(world.action_fillers) | set(world.answer_names)) - own
    words = list(islice(_WORD.finditer(masked(text), begin), 3 * _WORDS))
    for at, word in enumerate(words[:_WORDS]):
        for last in reversed(words[at : at + _WORDS]):
            if (action := exact_action(text[word.start() : last.end()], world, depth)) is not None:
                return action if _fits(text[last.end() :], action, world) else None
        said = text[word.start() : word.end()].strip(_AROUND + ".").replace("\u2019", "'").lower()
        if said and said not in leading:
            return None
    return None


def _fits(remark: str, action: Any, world: World[Any]) -> bool:
    """Whether the words behind an action leave it as it is.

    Raises:
        TwoActions: they name another action.
    """
    if (cause := _CAUSE.match(remark)) and world.action_words:  # as in `north to south`
        return _chosen(remark[cause.end() :], 0, world, _DEPTH) in (None, action)
    if cause or _BUT_NOT.match(remark):
        return True
    own = {part for word in world.action_words for part in word.split()}
    trailing = (_TRAILING | set(world.action_fillers)) - own
    while (word := _NEXT.match(remark)) and word[1].lower() in trailing:
        remark = remark[word.end() :]
    remark = remark.rstrip(f"{_AROUND}.!,;")
    words = re.findall(r"[a-z0-9_]+|%", remark.lower())
    if not remark.strip(f"{_AROUND}.,;!)"):
        return True
    if _OTHERWISE.match(remark) or words == ["%"] or (len(words) <= 4 and _CHANGED.intersection(words)):
        return False
    listed = tuple(word.replace("_", "") for word in words if word.replace("_", "") in world.action_parts)
    if listed != world.action_parts and sorted(listed) == sorted(world.action_parts):
        return False
    if _CAUSE.match(remark) or (remark[:1] in (",", "(") and _BUT_NOT.match(remark)):
        return True
    if not _REMARK.match(remark):
        return False
    bare = remark.strip(f"{_AROUND}()[],.;:=!\u2013\u2014-") if "[" not in remark else remark.strip(f"{_AROUND},.;:=!-")
    pieces = [bare, *re.split(r"[,;()]|\b(?:and|or|then)\b", remark), *re.findall(r"\[[^\[\]]*\]", remark)]
    the_one([action, *(_chosen(piece, 0, world, _DEPTH) for piece in pieces[:_PIECES])])
    other = remark.lstrip()[0] in "-=" and not bare.startswith(("a ", "an ", "the "))
    return not other or _chosen(bare, 0, world, _DEPTH) is not None


# Actions without other words.


def _bare(text: str) -> str:
    """A text without a bullet, and marks around it."""
    text = text.strip(_AROUND)
    text = text.strip("$") if text[:1] == text[-1:] == "$" else text
    bullet = _BULLET.match(text)
    return (text[bullet.end() :] if bullet else text).strip(_AROUND).rstrip(".,;!").strip(_AROUND)


def exact_action(text: str, world: World[Any], depth: int = 0) -> Any:
    """The action of a text that is one and nothing else, but for marks around it; None: it is no action."""
    longest = max(LONGEST, getattr(world.action_space, "max_length", 0))
    form = text
    for _ in range(4 if len(text) <= 2 * longest else 0):
        if 0 < len(form) <= longest:
            for read in (_word, _named, _numbers):
                if (action := read(form, world)) is not None:
                    return action
            value = lenient_value(form) if form[:1] in ("{", "[", "(", '"') else None
            if (action := from_json(value, world, depth)) is not None:
                return action
        inner = _bare(form)
        if inner == form and _BRACKETS.get(form[:1]) == form[-1:]:
            inner = form[1:-1].strip()
        if inner == form:
            break
        form = inner
    return None


def _legal(action: Any, world: World[Any]) -> Any:
    try:
        return world.legal(action)
    except (ValueError, TypeError, OverflowError, RecursionError):
        return None


def _word(form: str, world: World[Any]) -> Any:
    """The action for one of the world's words, or for a number if actions are numbers; else None."""
    try:
        action = world.read(form)
        if action is None and isinstance(world.action_space, spaces.Discrete) and form.isascii():
            action = finite_value(form[1:] if form[:1] == "#" and form[1:2].isdigit() else form)
            action = action if type(action) is int else None
    except (ValueError, TypeError, OverflowError, RecursionError):
        return None
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


def _named(form: str, world: World[Any]) -> Any:
    """The action of numbers with names, as in `x1 = 1, x2 = 2` or `[x1, x2] = [1, 2]`; else None."""
    names = world.action_parts
    if not names or len(form) > LONGEST:
        return None
    named: dict[str, Any] = {}
    at = 0
    if header := _listing(names).match(form):
        return exact_action(form[header.end() :], world, _DEPTH)
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
    spelled = (re.sub(r"([a-z])([0-9])", r"\1_?\2", name) for name in names)
    return re.compile(r"[\[(]\s*" + r"\s*,\s*".join(spelled) + r"\s*[\])]\s*[:=]", re.IGNORECASE)


def from_json(value: Any, world: World[Any], depth: int = 0) -> Any:
    """The action of a JSON value; None: it is no action, or nested too deeply."""
    try:
        return _from_value(value, world, depth)
    except RecursionError:
        return None


def _from_value(value: Any, world: World[Any], depth: int) -> Any:
    if isinstance(value, str):
        return read_line(value, world, depth + 1) if depth < _DEPTH else None
    if isinstance(value, dict):
        return _from_object(value, world, depth)
    if value is None or has_truth_value(value):
        return None
    if isinstance(world.action_space, spaces.Box) and isinstance(value, list):
        value = [_number(n) if isinstance(n, str) and re.fullmatch(_NUMBER, n) else n for n in value]
    action = _word(json.dumps(value), world) if isinstance(world.action_space, spaces.Text) else _legal(value, world)
    if action is None and isinstance(value, list) and len(value) == 1 and depth < _DEPTH:
        return from_json(value[0], world, depth + 1)
    return action


def _from_object(value: dict[str, Any], world: World[Any], depth: int) -> Any:
    """The action of a JSON object or of one of its keys; None without an action."""
    space = world.action_space
    keys = set(space.spaces) if isinstance(space, spaces.Dict) else set()
    if keys and value.keys() == keys:
        return None if has_truth_value(value) else _legal(value, world)
    lower = {key.lower(): each for key, each in value.items()}
    wanted = [key for key in (*_KEYS, *world.answer_names) if key in lower and key not in keys]
    if not wanted:
        wanted = [key for key in _TOOL if isinstance(lower.get(key), dict | list | str)]
    if not wanted and (names := world.action_parts) and lower.keys() >= set(names):
        return from_json([lower[name] for name in names], world, depth)
    if depth >= _DEPTH:
        return None
    actions = [from_json(lower[key], world, depth + 1) for key in wanted]
    return the_one(actions) if actions and actions[0] is not None else None


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


def _number(digits: str) -> int | float:
    return int(digits) if digits.lstrip("+-").isdigit() else float(digits)


def has_truth_value(value: Any) -> bool:
    """Whether a JSON value is a truth value or has one."""
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return isinstance(value, bool) or any(map(has_truth_value, parts))
