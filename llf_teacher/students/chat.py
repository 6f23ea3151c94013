"""A function that answers prompts, as a student: `chat:package.module:function` in specs, or `chat_student(function)`.

A function gets the conversation so far and gives the model's next answer, as a text. It may be a coroutine function.
What it gets is read from its parameter: a list of messages if that is called `messages` or annotated as a list, else
one text, the prompt.
"""

import inspect
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any, ClassVar

from llf_teacher.models.waiting import wait_for
from llf_teacher.students.conversation import Conversation, Message, as_prompt, check_manner
from llf_teacher.students.student import Student
from llf_teacher.students.talking import TalkingPolicy
from teachers.spec import read_call, read_expression, unknown

_SPEC = re.compile(r"\s*chat:(?:([A-Za-z_][\w.]*):)?(.*)", re.DOTALL)
_FORM = "`chat:package.module:function`, `chat:function`, or either with (history=..., max_prompt_tokens=...)"
_MODULE = re.compile(r"[A-Za-z_][\w.]*")
_LISTS = re.compile(r"(typing\.|collections\.abc\.)?(list|List|Sequence|Iterable)\b")
_here: dict[str, Callable[..., Any]] = {}  # functions that no module of a file has, by their names


class _Policy(TalkingPolicy["ChatStudent"]):
    """Asks the function."""

    def converse(self) -> Conversation:
        spec = self.spec
        return Conversation(self.world, history=spec.history, max_prompt_tokens=spec.max_prompt_tokens, rng=self.rng)

    def reply(self, messages: list[Message]) -> str:
        function = self.spec.function
        said = function(messages if takes_messages(function) else as_prompt(messages))
        if inspect.isawaitable(said):
            said = wait_for(_result(said))
        if not isinstance(said, str):
            raise TypeError(f"{self.spec} must give a text, got {type(said).__name__} {said!r:.80}")
        self._said = said
        return self.talk.answer(said)


@dataclass(frozen=True)
class ChatStudent(Student):
    """A function in the student's seat."""

    module: str
    """Of the function; empty: it is known in this process, by `chat_student`, or of the main module."""
    called: str
    """The function's name."""
    history: int = 20
    """How many past turns are sent along, the latest ones; the instruction always is."""
    max_prompt_tokens: int | None = None
    """Greatest length of a prompt, about; history beyond is cut in blocks. None: any."""

    reads = "words"
    text = True
    remembers = True
    policy: ClassVar[type[TalkingPolicy[Any]]] = _Policy

    def __post_init__(self) -> None:
        check_manner(self.history, self.max_prompt_tokens, "text")

    def __str__(self) -> str:
        defaults = {"history": 20, "max_prompt_tokens": None}
        given = [f"{name}={getattr(self, name)!r}" for name, value in defaults.items() if getattr(self, name) != value]
        home = f"{self.module}:" if self.module else ""
        return f"chat:{home}{self.called}" + (f"({', '.join(given)})" if given else "")

    @property
    def function(self) -> Callable[..., Any]:
        """The function.

        Raises:
            ValueError: it is not to be found.
        """
        return _found(self.module, self.called)


def chat_student(
    function: Callable[..., Any], *, history: int = 20, max_prompt_tokens: int | None = None
) -> ChatStudent:
    """A function of yours as a student, for studies, `TeacherEnv` and wherever a student may stand.

    Args:
        function: `f(prompt) -> str` or `f(messages) -> str`, or the same with `async`.
        history, max_prompt_tokens: see `Conversation`.

    Raises:
        ValueError: it cannot be called with one argument, or an option is not allowed.
    """
    if not callable(function):
        raise ValueError(f"chat_student needs a function f(prompt) or f(messages), got {function!r}")
    name = getattr(function, "__qualname__", type(function).__name__)
    module = getattr(function, "__module__", "")
    importable = _MODULE.fullmatch(module) and module not in ("__main__", "__mp_main__")
    if not importable or getattr(sys.modules.get(module), name, None) is not function:
        name = re.sub(r"\W", "_", name)  # of a notebook, or made within a function: no other process can import it
        module, _here[name] = "", function
    _check(function, f"chat:{name}")
    return ChatStudent(module, name, history, max_prompt_tokens)


def is_chat(spec: Any) -> bool:
    """Whether a spec has the form `chat:...`."""
    return isinstance(spec, str) and _SPEC.match(spec) is not None


def parse_chat(spec: str) -> ChatStudent:
    """The student that a spec names.

    Raises:
        ValueError: bad syntax, no such function, or one that cannot be called so.
    """
    module, call = _SPEC.match(spec).groups()  # type: ignore[union-attr]
    try:
        parsed = read_call(read_expression(call))
    except ValueError:
        parsed = None
    allowed = ("history", "max_prompt_tokens")
    if parsed is None:
        raise ValueError(f"bad student spec {spec!r}; expected {_FORM}")
    name, options = parsed
    if unknown_names := [option for option in options if option not in allowed]:
        raise ValueError(f"student {spec!r}: {unknown('parameter', unknown_names[0], allowed)}")
    _check(_found(module or "", name), spec)
    return ChatStudent(module or "", name, **options)


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
        raise ValueError(f"student {spec!r}: {shown} cannot be called with a prompt, or with messages, alone")


def _found(module: str, name: str) -> Callable[..., Any]:
    if module:
        try:
            home = import_module(module)
        except Exception as error:  # whatever a user's module does when it is imported
            raise ValueError(f"student chat:{module}:{name}: cannot import the module {module!r}: {error!r}") from error
        found = getattr(home, name, None)
    else:
        found = _here.get(name) or getattr(sys.modules["__main__"], name, None)
    if not callable(found):
        where = f"the module {module} has no function {name!r}" if module else f"this process knows no {name!r}"
        raise ValueError(
            f"student chat:{f'{module}:' * bool(module)}{name}: {where}; put it into a module and name that, as in "
            f"`chat:my_module:{name}`"
        )
    function: Callable[..., Any] = found
    return function


async def _result(awaitable: Any) -> Any:
    return await awaitable
