"""Speakers and voices by their specs: `llm_teacher(model=...)`, `module:factory`; `... | voice(tone=...)`."""

import importlib
import inspect
import re
from typing import Any

from llf_teacher.speakers.speaker import OwnTeacher, OwnVoice, Speaker, Wording
from teachers.personality import Personality
from teachers.spec import Spec, import_call, read_call, read_expression, unknown

_HOMES = {
    "llm_teacher": "llf_teacher.speakers.llm_teacher:LLMTeacher",
    "voice": "llf_teacher.speakers.voice:Toned",
    "rewriter": "llf_teacher.speakers.rewriter:Rewriter",
}
_NAME = re.compile(r"\s*([A-Za-z_]\w*)\s*(?:\(|$)")
_OWN = re.compile(r"\s*[A-Za-z_][\w.]*\s*:")


def read_special(part: str, *, last: bool) -> Speaker | Wording | None:
    """What one stage of a teacher's spec stands for that is no personality; None if it is one, or none at all.

    Args:
        part: the stage.
        last: whether others come before it, so that it is a voice.

    Raises:
        ValueError: a parameter is unknown or not allowed, or it stands in the wrong place.
    """
    made: Speaker | Wording | None
    named = _NAME.match(part)
    if named and named[1] in _HOMES:
        made = _shelved(named[1], part.strip())
    elif _OWN.match(part):
        made = _own(part.strip(), last)
    else:
        return None
    if made is not None and isinstance(made, Wording) != last:
        place = "behind a personality, as in `oracle | " if isinstance(made, Wording) else "alone, as in `"
        raise ValueError(f"teacher {part.strip()!r} must stand {place}{part.strip()}`")
    return made


def _shelved(name: str, part: str) -> Speaker | Wording:
    try:
        call = read_call(read_expression(part))
    except ValueError:
        call = None
    if call is None:
        raise ValueError(f"bad teacher spec {part!r}; expected `{name}` or `{name}(key=value)`")
    module, _, cls = _HOMES[name].partition(":")
    make: Any = getattr(importlib.import_module(module), cls)
    allowed = list(inspect.signature(make).parameters)
    if unknown_names := [key for key in call[1] if key not in allowed]:
        raise ValueError(f"teacher {part!r}: {unknown('parameter', unknown_names[0], allowed)}")
    made: Speaker | Wording = make(**call[1])
    return made


def _own(part: str, last: bool) -> Speaker | Wording | None:
    module, name, options = import_call("teacher", "Class", part)
    found = getattr(module, name, None)
    if not callable(found) or (isinstance(found, type) and issubclass(found, Spec)):
        return None
    if isinstance(found, type) and not all(
        callable(getattr(found, method, None)) for method in (("__call__",) if last else ("reset", "act"))
    ):
        return None
    makes = not last or isinstance(found, type) or bool(options)
    try:
        if makes:
            inspect.signature(found).bind(**options)
    except TypeError as error:
        raise ValueError(f"teacher {part!r}: {name}{inspect.signature(found)} cannot be called so: {error}") from None
    except ValueError:  # a builtin without a signature
        pass
    return (OwnVoice if last else OwnTeacher)(module.__name__, name, tuple(options.items()))


def needed_of(teacher: Personality | Speaker) -> Personality | str:
    """The personality whose needs an oracle has to serve."""
    return teacher if isinstance(teacher, Personality) else getattr(teacher, "personality", "oracle")
