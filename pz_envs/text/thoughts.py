"""Splits a chat model's reply into reasoning and answer, and finds where it begins to speak for others."""

import re
from collections.abc import Iterator
from typing import NamedTuple

__all__ = ["SplitReply", "split_thought", "turns_of_others"]

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


class SplitReply(NamedTuple):
    """A reply, split into reasoning and answer."""

    thought: str
    """The text between reasoning marks, its parts joined by blank lines."""
    answer: str
    """The text outside the marks."""
    text: str
    """The whole text."""
    unended: bool = False
    """Whether the text ends within reasoning."""


def split_thought(text: str | SplitReply) -> SplitReply:
    """Split marked reasoning from the answer; without marks the whole text is the answer.

    A `SplitReply` is returned as it is, so that each reply is searched once, where it arrives.

    Marks are `<think>...</think>` and its like (`<thinking>`, `<thought>`, `<reasoning>`, `<reflection>`,
    `<scratchpad>`, `<analysis>`; in any case), `[THINK]...[/THINK]`, those of Kimi, Seed, Gemma and OpenThinker, and
    the channels of gpt-oss. Reasoning without an end takes the rest of the text. An end without a beginning makes all
    text before it reasoning, since chat templates put the beginning into the prompt. The time is linear in the length.
    """
    if isinstance(text, SplitReply):
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
        return SplitReply("", text, text)
    (thought if thinking else answer).append(text[at:])
    thoughts = "\n\n".join(filter(None, map(str.strip, thought)))
    return SplitReply(thoughts, "\n".join(filter(None, map(str.strip, answer))), text, thinking)


def turns_of_others(text: str) -> Iterator[int]:
    """The positions where a text begins to speak for others: `Observation:`, `The teacher says:`, a heading `User`."""
    return (turn.start() for turn in _TURN.finditer(text))
