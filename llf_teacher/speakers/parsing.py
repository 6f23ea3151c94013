"""Teachers by their spec strings, for every function and command that takes a teacher.

A teacher is a personality, with or without a voice (`mistake | voice(tone='curt')`), or a speaker: `llm_teacher(...)`,
`module:factory`. Readers, too: `llm_reader(model=...)`, `module:function`.
"""

import importlib
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from llf_teacher.speakers.speaker import CustomTeacher, CustomVoice, InstructionOnly, Speaker, Voiced, Wording
from pz_envs.settings import Settings
from teachers.feedback import parse_kinds
from teachers.personality import PERSONALITIES, Personality, in_turn
from teachers.spec import Spec, SpecCall, parse_calls, unknown

SPEAKERS = {
    "llm_teacher": "llf_teacher.speakers.llm_teacher:LLMTeacher",
    "rewriter": "llf_teacher.speakers.rewriter:Rewriter",
    "voice": "llf_teacher.speakers.voice:Toned",
}
"""The classes of the speakers and wordings that come with the package, by their names in specs."""

NOBODY, PHRASES, READER = "none", "exact", "llm_reader"
"""The readers of own words: none, our phrases word for word, and behind these a model."""


def parse_teacher(spec: str | Personality | Speaker) -> Personality | Speaker:
    """The teacher that a spec string describes.

    It is a personality, `llm_teacher(...)`, a user's own teacher as `package.module:Class(key=...)` (a personality, or
    the factory of a policy), or a personality with a voice, as in `oracle | voice(tone='curt')`.

    Raises:
        ValueError: bad syntax, an unknown name or parameter, or a module without such a teacher.
    """
    if isinstance(spec, Personality | Speaker):
        return spec
    expected = f"{PERSONALITIES.expected}, {', '.join(SPEAKERS)}"
    *before, last = parse_calls("teacher", spec, expected, prefixes=1)
    made = make_speaker(last, last=bool(before))
    if isinstance(made, Speaker):
        return made
    stages = [*map(PERSONALITIES.make, before)]
    return in_turn([*stages, PERSONALITIES.make(last)]) if made is None else Voiced(in_turn(stages), made)


def arguments_of(teacher: Personality | Speaker, feedback_type: str | Iterable[str]) -> dict[str, Any]:
    """The arguments of `llf_teacher.make` for a teacher; with feedback type `n` a policy gives only the instruction."""
    if isinstance(teacher, Personality):
        return {"teacher": teacher}
    arguments = teacher.arguments()
    if not isinstance(arguments["teacher"], Personality) and not parse_kinds(feedback_type):
        arguments["teacher"] = InstructionOnly(arguments["teacher"])
    return arguments


def with_teacher(settings: Settings, policies: bool = True) -> Settings:
    """The settings with the teacher of their spec string, and its voice; a teacher that is an object stays as it is.

    Args:
        settings: the settings of a lesson.
        policies: whether policies and models may teach; if not, only personalities, with or without a voice.

    Raises:
        ValueError: there is no such teacher, it is not allowed, or two voices are given.
    """
    if not isinstance(settings.teacher, str | Speaker):
        return settings
    taught = parse_teacher(settings.teacher)
    arguments = arguments_of(taught, settings.feedback_type)
    if not policies and not isinstance(arguments["teacher"], Personality):
        raise ValueError(
            f"teacher {taught} speaks for itself, and a person or a program in a seat of this environment needs a "
            "personality, whose claims can be chosen or suggested; give one of `llf list`, or a class of your own that "
            "derives from teachers.personality.Personality"
        )
    if "voice" in arguments and settings.voice != Settings.voice:
        raise ValueError(f"teacher {taught} has a voice of its own, got voice={settings.voice!r}, too; leave out one")
    return replace(settings, **arguments)


def make_speaker(call: SpecCall, *, last: bool) -> Speaker | Wording | None:
    """The speaker or wording that a part of a teacher's spec names; None if it names neither.

    Args:
        call: the part.
        last: whether it follows other parts; then it must be a wording.

    Raises:
        ValueError: a parameter is unknown or not allowed, a module cannot be imported, or the place is wrong.
    """
    made: Speaker | Wording | None
    if call.prefix:
        made = _custom(call, last)
    elif call.name in SPEAKERS:
        module, _, cls = SPEAKERS[call.name].partition(":")
        made = call.make("teacher", getattr(importlib.import_module(module), cls))
    else:
        return None
    if made is not None and isinstance(made, Wording) != last:
        place = "behind a personality, as in `oracle | " if isinstance(made, Wording) else "alone, as in `"
        raise ValueError(f"teacher {call.path!r} must stand {place}{call}`")
    return made


def _custom(call: SpecCall, last: bool) -> Speaker | Wording | None:
    """The user's own policy, or own voice in the last part; None for a personality."""
    module, found = call.imported("teacher")
    if not callable(found) or (isinstance(found, type) and issubclass(found, Spec)):
        return None
    methods = ("__call__",) if last else ("reset", "act")
    if isinstance(found, type) and not all(callable(getattr(found, method, None)) for method in methods):
        return None
    if not last or isinstance(found, type) or call.arguments:
        call.check_arguments("teacher", found)
    return (CustomVoice if last else CustomTeacher)(module.__name__, call.name, tuple(call.arguments.items()))


def needed_of(teacher: Personality | Speaker) -> Personality | str:
    """The personality that decides what an oracle must offer."""
    return teacher if isinstance(teacher, Personality) else getattr(teacher, "personality", "oracle")


def speaks_freely(teacher: Any) -> bool:
    """Whether a teacher may speak in its own words: a person, a model, a policy, or a rewriting voice."""
    return bool(getattr(teacher, "own_words", False))


def parse_reader(reader: Any) -> Any:
    """The reader of sentences that are not phrases, a `pz_envs.text.claims.Model`; None for `none` and `exact`.

    It is `llm_reader(...)`, or a user's own function, as in `module:function`.

    Raises:
        ValueError: there is no such reader.
    """
    if reader in (NOBODY, PHRASES):
        return None
    allowed = f"{NOBODY}, {PHRASES}, {READER}(model=...) or module:function"
    call, *more = parse_calls("reader", f"{reader}", allowed, prefixes=1)
    if call.name == READER and not (call.prefix or more):
        from llf_teacher.speakers.llm_reader import LLMReader

        return call.make("reader", LLMReader)
    if not call.prefix or call.arguments or more:
        raise ValueError(f"reader {call.path!r} is unknown; allowed: {allowed}")
    module, function = call.imported("reader")
    if not callable(function):
        names = [name for name, found in vars(module).items() if callable(found) and name[0] != "_"]
        raise ValueError(f"reader {call.path!r}: {unknown(f'function in {module.__name__}', call.name, names)}")
    return function


def reader_spec(reader: Any) -> str:
    """The spec of a reader in canonical form; errors as in `parse_reader`."""
    found = parse_reader(reader)
    return f"{found}" if isinstance(found, Spec) else f"{reader}"
