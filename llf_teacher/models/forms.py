"""The form of a model's answers: JSON of a schema, the call of a tool, or text; `auto` is the first that is kept."""

import json
import re
from typing import Any, NamedTuple

from llf_teacher.models.replies import LENGTH, Answer
from pz_envs.text.answer_formats import form_fields

AUTO = "auto"
FORMS = ("json", "tool", "text")
"""The forms, in the order in which `auto` tries them."""
ANSWERS = (AUTO, *FORMS)
"""Values of the option `answer`."""
_EXCERPT = 80
_WORDS, _NUMBER = ("kelvin", "ampere"), r"^-[1-3]\.[0-9]{2}$"
_SCHEMA = {
    "type": "object",
    "properties": {"word": {"enum": [*_WORDS]}, "number": {"type": "string", "pattern": _NUMBER}},
    "required": ["word", "number"],
    "additionalProperties": False,
}
_ASKED = "Say hello."  # nobody answers so by chance


class AnswerForm(NamedTuple):
    """The form that is asked for."""

    name: str
    """One of `FORMS`."""
    why: str = ""
    """Why the forms before it are not used; empty if there are none, or if the form was chosen by the user."""

    def __str__(self) -> str:
        return f"{self.name} ({self.why})" if self.why else self.name


def check_answer(answer: Any) -> None:
    """Check the option `answer`.

    Raises:
        ValueError: it is not one of `ANSWERS`.
    """
    if answer not in ANSWERS:
        raise ValueError(f"answer must be one of {', '.join(ANSWERS)}, got {answer!r}")


def trial(form: str) -> dict[str, Any]:
    """The part of a request that finds out whether an endpoint keeps a form."""
    return {"messages": [{"role": "user", "content": _ASKED}], **form_fields(form, "report", "Report.", _SCHEMA)}


def broken(form: str, answer: Answer) -> str:
    """Why an answer to `trial` does not keep the form; empty if it does."""
    if answer.finish == LENGTH:
        return "was cut at its greatest length"
    if form == "tool" and not answer.call:
        return f"called no tool: {answer.text[:_EXCERPT]!r}"
    try:
        value = json.loads(answer.text)
        kept = set(value) == {"word", "number"} and value["word"] in _WORDS and re.search(_NUMBER, value["number"])
    except (ValueError, TypeError, RecursionError):
        kept = None
    return "" if kept else f"did not keep the schema: {answer.text[:_EXCERPT]!r}"
