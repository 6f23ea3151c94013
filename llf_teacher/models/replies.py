"""Replies of chat completions, read without trusting them: the answer, the thought beside it, what it cost."""

import json
import math
from typing import Any, NamedTuple

from pz_envs.answers import split_thought

_TOKENS = 1e6  # prices are per million
_MOST_TOKENS = 10**9  # of one reply; more is no count
LENGTH, FILTERED = "length", "content_filter"
"""Why an answer ended before its end."""


class Prices(NamedTuple):
    """USD per million tokens."""

    input: float
    output: float
    cached: float | None = None
    """Of input that the endpoint had in its cache; None: as other input."""


class Usage(NamedTuple):
    """What an answer cost."""

    input_tokens: int | None = None
    """None if the endpoint does not say, or says what cannot be; so with the others."""
    output_tokens: int | None = None
    usd: float | None = None
    """None if the tokens or the prices are unknown."""
    cached_tokens: int | None = None
    """How many of `input_tokens` the endpoint had in its cache."""


class Answer(NamedTuple):
    """What a model said."""

    raw: str
    """Its words as they came; of a tool's call the arguments, JSON."""
    reasoning: str = ""
    """What the endpoint gave apart from them as the model's thoughts."""
    finish: str = ""
    """Why it ended, such as `stop` or `length`; empty if the endpoint does not say."""
    model: str = ""
    """The endpoint's own name for the model."""
    usage: Usage = Usage()
    seconds: float = 0.0
    """From asking to having it."""
    call: str = ""
    """Id of the tool's call; empty if it is none."""
    unsent: tuple[str, ...] = ()
    """Parameters that were asked for and that the endpoint does not take."""

    @property
    def text(self) -> str:
        """The words without thoughts."""
        return split_thought(self.raw).answer

    @property
    def thought(self) -> str:
        """What was thought before the answer, whichever way it was given; empty if nothing."""
        return "\n\n".join(filter(None, (self.reasoning, split_thought(self.raw).thought)))


def read(reply: str, prices: Prices | None) -> tuple[Answer | None, Usage]:
    """The answer in a reply and what it cost; None if there is no answer in it."""
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
    calls = [_part(call, "function", "arguments") for call in message.get("tool_calls") or ()]
    calls = [call for call in calls if isinstance(call, str)]
    apart = (message.get(name) for name in ("reasoning_content", "reasoning"))
    answer = Answer(
        raw="\n".join(calls) or raw,
        reasoning=next((each for each in apart if each and isinstance(each, str)), reasoning),
        finish=_text(_part(choice, "finish_reason")),
        model=_text(_part(data, "model")),
        usage=usage,
        call=_text(_part(message, "tool_calls", 0, "id")) or "call_0" if calls else "",
    )
    return answer, usage


def served(reply: str, model: str) -> str | None:
    """What a list of models says that is served under a model's name, as `root` or otherwise; None if nothing."""
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
    """What is there in JSON values; None if nothing is."""
    for step in path:
        try:
            data = data[step]
        except (LookupError, TypeError):
            return None
    return data


def _text(value: Any) -> str:
    return value if isinstance(value, str) else ""


def _said(content: Any) -> tuple[str, str] | None:
    """Words and thoughts of a message's content: a text, parts of which each has a type, or none."""
    if content is None or isinstance(content, str):  # none: all tokens went into thoughts, or into a call
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
    """A number of tokens; None for what is none: a text, a negative number, `Infinity`, more than can be."""
    return value if type(value) is int and 0 <= value <= _MOST_TOKENS else None
