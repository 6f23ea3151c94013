"""A function that answers prompts, as a student: `chat:package.module:function` in specs, or `chat_student(function)`.

The function takes the conversation so far and returns the model's next answer, a text. It may be a coroutine function.
It takes a list of messages if its parameter is called `messages` or annotated as a list, else one text, the prompt.
"""

import inspect
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any, ClassVar

from llf_teacher.models.asked import Asked, as_asked
from llf_teacher.models.waiting import awaited
from llf_teacher.students.conversation import Conversation, Message, as_prompt, check_options
from llf_teacher.students.student import ModelReply, Student
from llf_teacher.students.talking import TalkingPolicy
from teachers.schema import storable
from teachers.spec import SpecCall, call_string, unknown

CHAT = "chat"
"""The prefix of specs of functions that answer prompts."""
_OPTIONS = ("history", "max_prompt_tokens")
_MODULE = re.compile(r"[A-Za-z_][\w.]*")
_LISTS = re.compile(r"(typing\.|collections\.abc\.)?(list|List|Sequence|Iterable)\b")
_local: dict[str, Callable[..., Any]] = {}  # functions that cannot be imported, by name


class _Policy(TalkingPolicy["ChatStudent"]):
    """Calls the function."""

    def converse(self) -> Conversation:
        spec = self.spec
        return Conversation(self.world, history=spec.history, max_prompt_tokens=spec.max_prompt_tokens, rng=self.rng)

    def begin(self) -> None:
        self._asked: Asked | None = None
        super().begin()

    def record(self) -> ModelReply:
        """What the function was asked; its answer is not a model's, as far as is known."""
        return {} if self._asked is None else {"asked": self._asked}

    def reply(self, messages: list[Message]) -> str:
        self._asked = as_asked(messages)
        function = self.spec.function
        own = [{**message} for message in messages]  # the function may change them, and the record keeps what it got
        said = awaited(function(own if takes_messages(function) else as_prompt(messages)))
        if not isinstance(said, str):
            raise TypeError(f"{self.spec} must give a text, got {type(said).__name__} {said!r:.80}")
        self._said = said = storable(said)
        return self.talk.answer(said)


@dataclass(frozen=True)
class ChatStudent(Student):
    """A function in the student's seat."""

    module: str
    """The function's module; empty for a function of this process, from `chat_student` or the main module."""
    called: str
    """The function's name."""
    history: int = 20
    """Number of past turns in a prompt, the latest; the instruction is always in it."""
    max_prompt_tokens: int | None = None
    """Approximate maximum length of a prompt; older history is cut in blocks. None: no limit."""

    reads = "words"
    text = True
    remembers = True
    policy: ClassVar[type[TalkingPolicy[Any]]] = _Policy

    def __post_init__(self) -> None:
        check_options(self.history, self.max_prompt_tokens, "text")

    def __str__(self) -> str:
        defaults = {field.name: field.default for field in fields(self)}
        given = {name: getattr(self, name) for name in _OPTIONS if getattr(self, name) != defaults[name]}
        return call_string(":".join(filter(None, (CHAT, self.module, self.called))), given)

    @property
    def function(self) -> Callable[..., Any]:
        """The function.

        Raises:
            ValueError: there is no such function.
        """
        return _function(SpecCall(self.called, {}, tuple(filter(None, (CHAT, self.module)))))


def chat_student(
    function: Callable[..., Any], *, history: int = 20, max_prompt_tokens: int | None = None
) -> ChatStudent:
    """A function as a student, for studies, `TeacherEnv` and whatever else takes a student.

    Args:
        function: `f(prompt) -> str` or `f(messages) -> str`, or the same with `async`.
        history, max_prompt_tokens: see `Conversation`.

    Raises:
        ValueError: it cannot be called with one argument, or an option is not allowed.
    """
    if not callable(function):
        raise ValueError(f"function must be a function f(prompt) or f(messages), got {function!r}")
    name = getattr(function, "__qualname__", type(function).__name__)
    module = getattr(function, "__module__", "")
    importable = _MODULE.fullmatch(module) and module not in ("__main__", "__mp_main__")
    if not importable or getattr(sys.modules.get(module), name, None) is not function:
        name = re.sub(r"\W", "_", name)  # defined in a notebook or an inner scope: other processes cannot import it
        module, _local[name] = "", function
    _check(function, f"{CHAT}:{name}")
    return ChatStudent(module, name, history, max_prompt_tokens)


def make_chat_student(call: SpecCall) -> ChatStudent:
    """The student of a call whose first prefix is `chat`.

    Raises:
        ValueError: there is no such function, it cannot be called with one argument, or an option is not allowed.
    """
    for name in call.arguments:
        if name not in _OPTIONS:
            raise ValueError(f"student {call.path!r}: {unknown('parameter', name, _OPTIONS)}")
    _check(_function(call), str(call))
    return ChatStudent(":".join(call.prefix[1:]), call.name, **call.arguments)


def takes_messages(function: Callable[..., Any]) -> bool:
    """Whether a function takes a list of messages, not one text."""
    first = next(iter(inspect.signature(function).parameters.values()))
    kind = first.annotation
    if kind is first.empty:
        return first.name == "messages"
    return _LISTS.match(kind if isinstance(kind, str) else inspect.formatannotation(kind)) is not None


def can_answer(function: Callable[..., Any]) -> bool:
    """Whether a function can be called with one argument."""
    try:
        inspect.signature(function).bind(())
    except (TypeError, ValueError):
        return False
    return True


def _check(function: Callable[..., Any], spec: str) -> None:
    if not can_answer(function):
        shown = f"{getattr(function, '__name__', 'it')}{inspect.signature(function)}"
        raise ValueError(f"student {spec!r}: cannot call {shown} with a prompt, or with messages, alone")


def _function(call: SpecCall) -> Callable[..., Any]:
    """The function of a call whose first prefix is `chat`.

    Raises:
        ValueError: there is no such function.
    """
    name = call.name
    if len(call.prefix) > 1:
        where = f"the module {call.prefix[-1]}"
        _, function = call.imported("student")
    else:
        where = "this process"
        function = _local.get(name) or getattr(sys.modules["__main__"], name, None)
    if not callable(function):
        raise ValueError(
            f"student {call.path!r}: {where} has no function {name!r}; put it into a module and name that, as in "
            f"`{CHAT}:my_module:{name}`"
        )
    found: Callable[..., Any] = function
    return found
