"""Reads a student's text as an action, by one rule. Nothing is ever executed.

1. What stands between thinking tags, or behind `Thought:`, is a thought. What a model goes on to say for others is cut.
2. The answer stands behind the last label `Response:`, `Answer:`, `Action:` or the like; without one it is the text.
3. An answer that is an action is it, and so are the first paragraph behind a label, and JSON with an action. A line for
   each part of an action, such as `- x1: 0.5`, is a list in brackets.
4. Else it is a sentence: behind a label the first one on the line that is an action; without a label the first or the
   last one or the text in a fence, if no sentence is another action.
5. A sentence is an action if plain words alone stand before it, such as "I go", and if what stands behind it leaves it
   as it is: plain words, a cause, "not ...", or a remark without another action.
6. Else a sentence is the only action that it names, if a verb or a noun beside it says that it is to be done ("You
   should go", "the right way is"), and no word denies, doubts, asks, compares, or tells of the past, of later times or
   of others. It is the first one behind a label or of at most four, the last of two, or one before a warning of another
   action. Behind "your action is" a list of numbers is chosen.
7. An answer that is taken back, as by "Wait, ...", is none, and neither is all else.

A text that is taken word for word, such as a poem, is all that stands behind the label, up to a thought, or the whole
answer.
"""

import json
import re
from itertools import islice
from typing import Any

from gymnasium import spaces

from pz_envs.text.action_parsing import (
    LONGEST,
    TwoActions,
    exact_action,
    in_brackets,
    in_json,
    is_stated,
    names_any,
    on_first_line,
    only_named,
    read_sentence,
    taken_back,
    text_in,
    the_one,
    unfit,
    warns,
)
from pz_envs.text.answer_place import (
    cleaned,
    fenced,
    find_place,
    first_line,
    sentences,
    unmarked,
    without_thoughts,
)
from pz_envs.text.json_values import finite_value
from pz_envs.text.thoughts import SplitReply, split_thought, turns_of_others
from teachers.atoms import ParseFailure
from worlds.world import World

__all__ = ["failure", "first_answer", "legal_text", "parse_action", "read_exactly", "read_text", "read_verbatim"]

_EXCERPT = 80
_FEW = 5  # places where an answer may end
_SENTENCES = 4  # of a paragraph that may begin with an action
_LOOKED_AT = 300  # characters of a refused text in which actions are looked for
_TITLES = re.compile(r"""("[^"]{1,60}[^".](?:",\s*"[^"]{1,60}[^".])*")\.?""")
_OPENED = re.compile(r"\s*(?:```\w*\s*)?\{\s*[\"']")

EMPTY = "it holds no answer"
UNENDED = "its reasoning never ends, so that no answer follows"
NOTHING = "it names no action that there is"
LONG = "it is long, and does not plainly choose an action"
MORE = "it names an action, but does not plainly choose it"
BACK = "it takes its answer back, or changes it"
UNMARKED = "it is a thought, and no answer follows"
WRAPPED = "it looks like JSON, but holds no complete action that there is"
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
    thought, answer, text, unended = split_thought(said)  # step 1
    answer = cleaned(first_answer(answer, world)[0])
    if not answer.strip() and (thought or text.strip() or not _is_verbatim(world)):
        return failure(text, world, UNENDED if unended and thought else EMPTY)
    try:
        return _verbatim(answer, world) if _is_verbatim(world) else _read(in_brackets(unmarked(answer), world), world)
    except TwoActions as error:
        return failure(_found(answer, world), world, f"{error}")


def first_answer(answer: str, world: World[Any] | None) -> tuple[str, str]:
    """An answer up to the first turn that the model invents for others, and the rest.

    A turn of others before any answer is a quotation and belongs to the answer.

    Args:
        answer: a text without reasoning.
        world: the world in which the student acts; None: only a label marks an answer.
    """
    for begin in islice(turns_of_others(answer), _FEW):
        said = answer[:begin].strip().rstrip("-=*_ \n")
        if (find_place(said).label and find_place(said).said) or (world is not None and said and _answers(said, world)):
            return said, answer[begin:]
    return answer, ""


def _answers(said: str, world: World[Any]) -> bool:
    """Whether a text without a label is an answer."""
    if _is_verbatim(world):
        return "\n" in said and bool(without_thoughts(said))
    try:
        return type(_read(said, world)) is not ParseFailure
    except TwoActions:
        return True


def _is_verbatim(world: World[Any]) -> bool:
    return world.verbatim and isinstance(world.action_space, spaces.Text)


def read_exactly(text: str, world: World[Any]) -> Any:
    """The action of a text that holds nothing else, or a `ParseFailure`."""
    if isinstance(world.action_space, spaces.Text):
        return legal_text(text.strip(), world)
    if len(text) > LONGEST:
        return failure(text, world)
    try:
        action = world.read(text.strip())
        return world.legal(_strict_value(text.strip(), world) if action is None else action)
    except (ValueError, TypeError, OverflowError, RecursionError):
        return failure(text, world)


def _strict_value(text: str, world: World[Any]) -> Any:
    """The value of a text that is JSON or a list in round brackets; the only key of an object must be `action`."""
    value = finite_value(f"[{text[1:-1]}]" if text[:1] + text[-1:] == "()" else text)
    keys = world.action_space.spaces.keys() if isinstance(world.action_space, spaces.Dict) else ()
    if isinstance(value, dict) and list(value) == ["action"] and "action" not in keys:
        value = value["action"]
    if isinstance(value, dict) and not keys:
        raise ValueError("the only key of an object must be `action`")
    if unfit(value):
        raise ValueError("a truth value is not an action")
    action = world.read(value) if isinstance(value, str) else None
    return value if action is None else action


def legal_text(text: str, world: World[Any]) -> Any:
    """The text as an action of a world whose actions are texts, or a `ParseFailure`."""
    try:
        return world.legal(text)
    except ValueError:
        return failure(text, world, UNFIT if world.verbatim else NOTHING)


def failure(text: str, world: World[Any], why: str = NOTHING) -> ParseFailure:
    """The failure to read a text, with the beginning of its first line; control characters are escaped."""
    line = first_line(text[:LONGEST])
    shown = "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in line[: _EXCERPT + 1])
    return ParseFailure(shown if len(shown) <= _EXCERPT else f"{shown[: _EXCERPT - 3]}...", world.action_syntax, why)


# Worlds that look for the action in a text.


def _read(answer: str, world: World[Any]) -> Any:
    """The action of an answer in a world that does not take texts word for word."""
    label, said = find_place(answer, world.answer_names)  # step 2
    listed = world.text_items and label and _TITLES.fullmatch(said.strip())  # titles without the brackets of a list
    for whole in (answer, f"[{listed[1]}]" if listed else said.strip() if label else ""):  # step 3
        if (action := _whole(whole, world)) is not None:
            return action
    action, rest = on_first_line(said, world) if label else _anywhere("\n" + without_thoughts(said), world)
    if action is None:
        action, rest = _only_named(first_line(said) if label else without_thoughts(said), world, bool(label))  # step 6
    if action is None:
        return failure(_found(answer, world), world, _reason(label, said, world))
    if taken_back(rest):  # step 7
        return failure(_found(answer, world), world, BACK)
    return action


def _whole(text: str, world: World[Any]) -> Any:
    """The action of a text that is one as a whole; None: it is none."""
    if not isinstance(world.action_space, spaces.Text):
        action = read_exactly(text, world)
        if type(action) is not ParseFailure:
            return action
    return exact_action(text, world)


def _anywhere(text: str, world: World[Any]) -> tuple[Any, str]:
    """The action of a text without a label, in JSON, a sentence or a fence, and what follows it."""
    if (found := in_json(text, world))[0] is not None or _OPENED.match(text):
        return found
    read = [(read_sentence(sentence, world), until) for sentence, until in sentences(text)]
    at = [number for number, (each, _) in enumerate(read) if each is not None]
    action = the_one(each for each, _ in read)
    if at and (at[0] == 0 or at[-1] == len(read) - 1):
        return action, text[read[at[-1]][1] :]
    return the_one(exact_action(each, world) for each in fenced(text)), ""  # other sentences may tell a story


def _only_named(text: str, world: World[Any], labelled: bool) -> tuple[Any, str]:
    """The action that a sentence of a first paragraph names alone, and what follows it; None: there is none.

    It is one before a warning of another action, or the first one, if there are few, or if the answer begins there; of
    two sentences it is also the last one.
    """
    said = [] if _OPENED.match(text) else sentences(text.strip().partition("\n\n")[0])
    begins = len(said) <= _SENTENCES or labelled or is_stated(text)
    read = [only_named(sentence, world) for sentence, _ in said]
    at = next((number for number, action in enumerate(read) if action is not None), None)
    if at is None:
        return None, ""
    warned = any(warns(sentence, read, world) for sentence, _ in said[at + 1 :]) and not text.rstrip().endswith("?")
    if (at == 0 and begins) or len(said) == 2 or warned:
        return the_one(read), text.strip()[said[at][1] :]
    return None, ""


def _found(answer: str, world: World[Any]) -> str:
    """What to quote of an answer: the last label with the line behind it, or the answer."""
    label, said = find_place(answer, world.answer_names, _is_verbatim(world))
    return f"{label} {first_line(said)}" if label else answer


def _reason(label: str, said: str, world: World[Any]) -> str:
    """Why a text is not an action."""
    if not label and said.strip() and not without_thoughts(said):
        return UNMARKED
    if not said.strip():
        return EMPTY
    if said.lstrip().startswith("{"):
        return WRAPPED
    looked_at = first_line(said) if label else said
    if len(looked_at) > _LOOKED_AT:
        return LONG
    return MORE if names_any(looked_at, world) else NOTHING


# Worlds that take a text word for word.


def _verbatim(answer: str, world: World[Any]) -> Any:
    """The action of an answer in a world that takes texts word for word."""
    label, said = find_place(answer, world.answer_names, verbatim=True)
    if not label and answer.strip() and not without_thoughts(answer).startswith(answer.strip()[:1]):
        return failure(answer, world, UNMARKED)
    text = said.strip()
    if label and not text:
        return failure(label, world, EMPTY)
    blocks = {block for block in fenced(text) if block}
    text = re.sub(r"\n[ \t]*(?:`{3,}|~{3,})\s*\Z", "", text)
    if len(blocks) > 1:
        raise TwoActions("its fences hold different texts")
    if blocks:
        text = find_place(blocks.pop(), world.answer_names, verbatim=True).said.strip()
    if text[:1] + text[-1:] in ("{}", "[]") or text.startswith('{"'):
        try:
            inner = text_in(json.loads(text, strict=False), world.answer_names)
        except (ValueError, RecursionError):
            inner = None
        if inner is None and text[0] == "{":
            return failure(answer, world, WRAPPED)
        text = text if inner is None else inner
    return legal_text(text if (named := world.read(text)) is None else named, world)
