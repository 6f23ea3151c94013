"""Answers of chat models: split reasoning from the answer, and find where a model begins to speak for others."""

import re
from collections.abc import Iterator
from typing import NamedTuple

__all__ = ["STOPS", "Parted", "split_thought", "turns_of_others"]

STOPS = ("\n\nThe teacher says:", "\n\nYou observe:", "\nWhat do you do in turn", "\nUser:")
"""Texts at which a model has gone on to speak for others; OpenAI's endpoint takes at most four."""

_NAMES = r"(?:seed:)?(?:think(?:ing)?|thoughts?|reasoning|reason|reflection|scratchpad|analysis|internal_monologue)"
_MARK = re.compile(  # all begin with a bracket, which makes the search fast
    rf"""
    [<\[\u25c1] (?:
      (?P<open> (?<=<){_NAMES}\s?> | (?<=\[)think\] | (?<=\u25c1)think\u25b7
        | (?<=<)\|(?:begin_of_thought\|> | channel>thought\b)
        | (?<=<)(?:\|start\|>assistant<)?\|channel\|>(?:analysis|commentary)[^<]{{0,80}}<\|message\|> )
    | (?P<close> (?<=<)/{_NAMES}\s?> | (?<=\[)/think\] | (?<=\u25c1)/think\u25b7
        | (?<=<)(?:\|end_of_thought\|> | channel\|>) )
    | (?P<end> (?<=<)\|end\|> )
    | (?P<say> (?<=<)(?: (?:\|start\|>assistant<)?\|channel\|>final[^<]{{0,80}}<\|message\|>
        | \|(?:begin|end)_of_solution\|> ) )
    )
    """,
    re.IGNORECASE | re.VERBOSE,
)
_OTHER = r"(?:teacher|instructor|environment|env|game|system|user|human|observation|obs|feedback|reward|tool_response)"
_TURN = re.compile(
    rf"""
    (?: ^[ \t>\#*_|-]{{0,9}}+ | (?<=[.!?])[ \t]{{1,9}}+[*_]{{0,3}}+ ) (?=[a-z])
    (?: (?:(?:the|your|my|next|new|current)[ \t])*+ {_OTHER} (?:[ \t]{_OTHER})? (?:['\u2019]s[ \t]\w+)?
        (?:[ \t]\w{{3,9}}(?<=s))? [*_\])]{{0,3}}[ \t]?[:\uff1a]
      | you[ \t](?:now[ \t])?(?:observe|see)[ \t]?:
      | what[ \t]do[ \t]you[ \t]do[ \t]in[ \t]turn | turn[ \t][0-9]+[ \t]?: )
    | ^[ \t]{{0,9}}(?: (?:\#{{1,6}}[ \t]*|\*\*|\[) {_OTHER} (?:\*\*|\])?[ \t]*$ | <{_OTHER}> )
    """,
    re.IGNORECASE | re.VERBOSE | re.MULTILINE,
)


class Parted(NamedTuple):
    """A text with its reasoning split off."""

    thought: str
    """The text between reasoning marks, its parts joined by blank lines."""
    answer: str
    """The text outside the marks."""
    text: str
    """The whole text."""
    unended: bool = False
    """Whether the text ends within reasoning."""


def split_thought(text: str | Parted) -> Parted:
    """Split the reasoning that is marked in a text from the answer; without marks the answer is the whole text.

    A `Parted` is returned as it is, so that a text is searched once, where it arrives.

    Marks are `<think>...</think>` and its like (`<thinking>`, `<thought>`, `<reasoning>`, `<reflection>`,
    `<scratchpad>`, `<analysis>`; in any case), `[THINK]...[/THINK]`, those of Kimi, Seed, Gemma and OpenThinker, and
    the channels of gpt-oss. Reasoning that never ends takes all the rest. If an end has no beginning, which a chat
    template has put into the prompt, all text before it is reasoning. The time is linear in the text's length.
    """
    if isinstance(text, Parted):
        return text
    thought: list[str] = []
    answer: list[str] = []
    thinking, at, marked = False, 0, False
    for mark in _MARK.finditer(text):
        if (mark["open"] and thinking) or (mark["end"] and not thinking):  # a word of the thought; a stop token
            continue
        piece, at, marked = text[at : mark.start()], mark.end(), True
        (thought if thinking else answer).append(piece)
        if mark["close"] and not thinking:
            thought += answer
            answer = []
        thinking = bool(mark["open"])
    if not marked:
        return Parted("", text, text)
    (thought if thinking else answer).append(text[at:])
    thoughts = "\n\n".join(filter(None, map(str.strip, thought)))
    return Parted(thoughts, "\n".join(filter(None, map(str.strip, answer))), text, thinking)


def turns_of_others(text: str) -> Iterator[int]:
    """Where a text begins to speak for others, as in `Observation:`, `The teacher says:` or a heading `User`."""
    return (turn.start() for turn in _TURN.finditer(text))
