"""Replies of chat completions, which may be malformed: the answer, the thought beside it, the cost."""

import json
import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

from pz_envs.text.thoughts import SplitReply, split_thought

_TOKENS = 1e6  # prices are per million
LONGEST = 1_000_000
"""Maximum length of an answer, and of the thoughts beside it, in characters; the rest is dropped, as if never sent."""
_MOST_TOKENS = 10**9  # of one reply; a greater number is not a count
LENGTH, FILTERED, REFUSED = "length", "content_filter", "refusal"
"""Reasons why an answer is incomplete or refused."""


class Prices(NamedTuple):
    """USD per million tokens."""

    input: float
    output: float
    cached: float | None = None
    """Price of input from the endpoint's cache; None: as other input."""


class Usage(NamedTuple):
    """The cost of an answer."""

    input_tokens: int | None = None
    """Number of tokens; None, here and below, if the endpoint gives no number or an impossible number."""
    output_tokens: int | None = None
    usd: float | None = None
    """None if the tokens or the prices are unknown."""
    cached_tokens: int | None = None
    """Number of `input_tokens` from the endpoint's cache."""


@dataclass(frozen=True)
class Answer:
    """A model's answer."""

    raw: str
    """The text as it came; for a tool call its arguments, JSON."""
    reasoning: str = ""
    """The model's thoughts, if the endpoint has a field for them."""
    finish: str = ""
    """Why the answer ended, such as `stop` or `length`; empty if the endpoint does not say."""
    model: str = ""
    """The endpoint's own name for the model."""
    usage: Usage = field(default_factory=Usage)
    seconds: float = 0.0
    """Time from the request to the reply."""
    call: str = ""
    """Id of the tool call; empty if the answer is not a tool call."""
    unsent: tuple[str, ...] = ()
    """Parameters of the request that the endpoint does not accept."""

    @cached_property
    def split(self) -> SplitReply:
        """The text with its reasoning split off."""
        return split_thought(self.raw)

    @property
    def text(self) -> str:
        """The text without thoughts."""
        return self.split.answer

    @property
    def thought(self) -> str:
        """The thoughts, from the endpoint's own field and from between marks; empty if there are none."""
        return "\n\n".join(filter(None, (self.reasoning, self.split.thought)))


def read(reply: str, prices: Prices | None) -> tuple[Answer | None, Usage]:
    """The answer in a reply, None if there is none, and its cost."""
    try:
        data = json.loads(reply)
    except (ValueError, RecursionError):
        return None, Usage()
    usage = _usage(_part(data, "usage"), prices)
    choice = _part(data, "choices", 0)
    message = _part(choice, "message")
    if not isinstance(message, dict):
        return None, usage
    said = _said(message.get("content"))
    if said is None:
        return None, usage
    raw, reasoning = said
    listed = message.get("tool_calls")
    calls = [_part(call, "function", "arguments") for call in (listed if isinstance(listed, list) else ())]
    calls = [json.dumps(call, ensure_ascii=False) if isinstance(call, dict) else call for call in calls]
    calls = [call for call in calls if isinstance(call, str)]
    apart = (message.get(name) for name in ("reasoning_content", "reasoning"))
    reasoning = next((each for each in apart if each and isinstance(each, str)), reasoning)
    finish, declined = _text(_part(choice, "finish_reason")), _text(message.get("refusal"))
    if declined and not (raw or calls):
        raw, finish = declined, REFUSED
    elif finish == "stop" and not (raw or calls):  # the endpoint counted the whole answer as thoughts
        raw, reasoning = reasoning, ""
    raw = "\n".join(calls) or raw
    answer = Answer(
        raw=raw[:LONGEST],
        reasoning=reasoning[:LONGEST],
        finish=finish if len(raw) <= LONGEST else LENGTH,
        model=_text(_part(data, "model")),
        usage=usage,
        call=_text(_part(message, "tool_calls", 0, "id")) or "call_0" if calls else "",
    )
    return answer, usage


def served(reply: str, model: str) -> str | None:
    """The model under a name in an endpoint's list of models; None if the list lacks the name."""
    try:
        models = _part(json.loads(reply), "data")
    except (ValueError, RecursionError):
        return None
    for each in models if isinstance(models, list) else ():
        if _part(each, "id") == model:
            size = _part(each, "meta", "n_params")
            return f"{_part(each, 'root') or model}{f' of {size} parameters' if size else ''}"
    return None


def _part(data: Any, *path: str | int) -> Any:
    """The value at a path in JSON values; None if there is none."""
    for step in path:
        try:
            data = data[step]
        except (LookupError, TypeError):
            return None
    return data


def _text(value: Any) -> str:
    return value if isinstance(value, str) else ""


def _said(content: Any) -> tuple[str, str] | None:
    """Text and thoughts of a message's content: a string, a list of typed parts, or null."""
    if content is None or isinstance(content, str):  # null: all tokens went into thoughts, or into a call
        return content or "", ""
    if not isinstance(content, list):
        return None
    thought = [_inner(part["thinking"]) for part in content if _part(part, "type") == "thinking" and "thinking" in part]
    return _inner(content), "\n\n".join(filter(None, thought))


def _inner(parts: Any) -> str:
    if isinstance(parts, str):
        return parts
    return "".join(_text(_part(part, "text")) for part in parts) if isinstance(parts, list) else ""


def _usage(usage: Any, prices: Prices | None) -> Usage:
    asked, said = _count(_part(usage, "prompt_tokens")), _count(_part(usage, "completion_tokens"))
    if asked is None or said is None:
        return Usage()
    known = _count(_part(usage, "prompt_tokens_details", "cached_tokens"))
    if known is not None and known > asked:
        known = None
    if prices is None:
        return Usage(asked, said, None, known)
    cheap = 0 if known is None or prices.cached is None else known
    parts = ((asked - cheap) * prices.input, cheap * (prices.cached or 0.0), said * prices.output)
    return Usage(asked, said, math.fsum(parts) / _TOKENS, known)


def _count(value: Any) -> int | None:
    """A number of tokens; None for anything else: a text, a negative number, `Infinity`, an impossibly large one."""
    return value if type(value) is int and 0 <= value <= _MOST_TOKENS else None
