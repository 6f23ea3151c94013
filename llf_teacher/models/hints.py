"""Hints which setting to change, from an endpoint's reply."""

import re

from llf_teacher.models.settings import KEY

_FORM = "give another answer, such as answer='text'"
_HINTS = (
    ((401, 403), "", f"set {KEY}"),
    ((402,), "", "the account of the key has no money left"),
    ((404, 405), "", "give another model, or another base_url, which often ends in /v1"),
    ((400, 422), r"\bmodel\b.{0,80}\b(not found|not exist|unknown|invalid)", "give another model"),
    (
        (400, 413, 422, 500),
        r"context.{0,9}(length|size|window)|(prompt|request).{0,9}too (long|large)|too many.{0,9}tokens"
        r"|exceed.{0,30}number of tokens|reduce.{0,9}(length|size)",
        "give a smaller history, or a student a smaller max_prompt_tokens",
    ),
    (
        (400, 404, 422, 500),
        r"response_format|json_schema|invalid schema|structured output|grammar|tool_choice|support.{0,30}\btools?\b",
        _FORM,
    ),
    ((200,), r"\A\s*<", "this is a web page; give another base_url, which often ends in /v1"),
    (
        (200,),
        r"\A\s*(data|event|id)?:",
        "this is an event stream; give the base_url of an endpoint that does not stream",
    ),
)  # statuses, a text in the reply, the remedy


UNREACHED = "; does the endpoint run, and is base_url its address?"


def hint(status: int | None, text: str) -> str:
    """The setting to change, behind a semicolon; empty if it is unknown.

    Args:
        status: the reply's status; None: no reply.
        text: the reply's body, or the error in it.
    """
    found = [say for statuses, wanted, say in _HINTS if status in statuses and re.search(wanted, text, re.I)]
    return f"; {found[-1]}" if found else ""


def is_about_form(message: str) -> bool:
    """Whether an error's message has the hint to give another form of answer."""
    return _FORM in message


def is_page(reply: str) -> bool:
    """Whether a reply is a web page instead of a model's answer."""
    return reply.lstrip().startswith("<")
