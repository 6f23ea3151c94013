"""Agents of the user's own in the student's seat, named by specs such as `my_package.my_module:MyAgent(size=3)`.

The spec names a factory, a class or a function that takes the keyword arguments and returns an agent; it is called
anew for each episode, in the process that plays it. Which of three protocols an agent speaks is read from its methods:

    LLF-Bench   reset(docstring)           act(observation, feedback)   two arguments, or `*args`
    Gymnasium   reset(), or none           act(observation)             one argument: the dict of three strings
    policy      reset(rng)                 act(observation, info)       two arguments, the second named `info`

Arguments with a default do not count. Agents of the first two read and write text, policies what is native to the
world; an attribute `text` of the agent overrides this. What is no action of the world costs a turn, either way.
"""

import importlib
import inspect
import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from llf_teacher.students.chat import can_answer
from llf_teacher.students.student import READS, Policy, Student, Telling, state_of
from pz_envs.text_mode import failure
from teachers.spec import import_call, unknown

LLF, GYMNASIUM, POLICY = "LLF-Bench", "Gymnasium", "policy"
_SPEC = re.compile(r"\s*([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*)\s*:(.*)", re.DOTALL)
_EXPECTED = (
    "expected reset(docstring) and act(observation, feedback), or act(observation), "
    "or reset(rng) and act(observation, info)"
)


class _Policy(Policy["Agent"]):
    """Passes on what the protocol asks for."""

    def begin(self) -> None:
        """Tell the agent that an episode begins; an instruction comes with the first turn."""
        agent, protocol = self.spec.agent, self.spec.protocol
        self._opening = True
        if protocol == POLICY:
            agent.reset(self.rng)
        elif protocol == GYMNASIUM and hasattr(agent, "reset"):
            agent.reset()

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """The agent's action."""
        agent, protocol = self.spec.agent, self.spec.protocol
        state = state_of(observation)
        # Plain strings: the atoms that a teacher's utterance carries are for readers of atoms, in the info.
        instruction, feedback = f"{observation['instruction']!s}", f"{observation['feedback']!s}"
        opening, self._opening = self._opening, False
        if protocol == LLF:
            if opening:
                agent.reset(instruction)
            action = agent.act(state, None if opening and not feedback else feedback)
        elif protocol == GYMNASIUM:
            told = instruction if opening else ""
            action = agent.act({"observation": state, "instruction": told, "feedback": feedback})
        else:
            action = agent.act(observation | {"instruction": instruction, "feedback": feedback}, info)
        return as_text(action) if self.spec.text else self._native(action)

    def _native(self, action: Any) -> Any:
        """An action as it is, but for a `ParseFailure` in place of one that is outside of the action space."""
        action = as_text(action) if isinstance(action, str) else action
        try:
            self.world.legal(action)
        except Exception:  # values of a user's own may raise anything
            return failure(as_text(action), self.world)
        return action

    def record(self) -> Telling:
        """What the agent says of its last action, if it has a method of this name."""
        if not callable(tell := getattr(self.spec.agent, "record", None)):
            return {}
        said: Telling = tell()
        if unknown_names := [name for name in said if name not in Telling.__annotations__]:
            raise ValueError(
                f"student {self.spec}: {unknown('key of its record', unknown_names[0], Telling.__annotations__)}"
            )
        return said


@dataclass(frozen=True)
class Agent(Student):
    """An agent by the factory that makes it."""

    module: str
    """Dotted name of the module."""
    factory: str
    """Name of the factory within it."""
    options: tuple[tuple[str, Any], ...] = ()
    """Keyword arguments of the factory, in the order in which they were given."""

    policy = _Policy

    def __str__(self) -> str:
        options = ", ".join(f"{name}={value!r}" for name, value in self.options)
        return f"{self.module}:{self.factory}({options})" if options else f"{self.module}:{self.factory}"

    @property
    def reads(self) -> str:
        """`words`, unless the factory has an attribute `reads` that says otherwise."""
        return getattr(self.make, "reads", "words")

    @property
    def text(self) -> bool:
        """Whether the agent plays in text mode."""
        return bool(getattr(self.agent, "text", self.protocol != POLICY))

    @property
    def remembers(self) -> bool:
        """It may: within a lifetime the agent is the same."""
        return True

    @cached_property
    def make(self) -> Callable[..., Any]:
        """The factory."""
        make: Callable[..., Any] = getattr(importlib.import_module(self.module), self.factory)
        return make

    @cached_property
    def agent(self) -> Any:
        """The agent, made when it is first asked for."""
        return self.make(**dict(self.options))

    @cached_property
    def protocol(self) -> str:
        """`LLF`, `GYMNASIUM` or `POLICY`.

        Raises:
            ValueError: the agent speaks none of them.
        """
        return protocol_of(self.agent, f"{self}")


def is_agent(spec: Any) -> bool:
    """Whether a spec has the form `package.module:...`."""
    return isinstance(spec, str) and _SPEC.match(spec) is not None


def parse_agent(spec: str) -> Agent:
    """The agent that a spec names. This imports its module; the factory is not called yet.

    Raises:
        ValueError: bad syntax, no such module or factory, or arguments that the factory does not take.
    """
    module, factory, options = import_call("student", "factory", spec)
    make = getattr(module, factory, None)
    if not callable(make):
        names = [name for name, value in vars(module).items() if callable(value) and not name.startswith("_")]
        raise ValueError(f"student {spec!r}: {unknown(f'factory in {module.__name__}', factory, sorted(names))}")
    try:
        inspect.signature(make).bind(**options)
    except TypeError as error:
        hint = ""
        if not options and not isinstance(make, type) and can_answer(make):
            hint = f"; if it answers prompts, name it as 'chat:{spec.strip()}'"
        shown = f"{factory}{inspect.signature(make)}"
        raise ValueError(f"student {spec!r}: {shown} cannot be called so: {error}{hint}") from None
    except ValueError:  # a builtin without a signature
        pass
    agent = Agent(spec.partition(":")[0].strip(), factory, tuple(options.items()))
    if agent.reads not in READS:
        raise ValueError(f"student {spec!r}: reads is {agent.reads!r}; allowed: {', '.join(READS)}")
    return agent


def protocol_of(agent: Any, name: str) -> str:
    """The protocol that an agent's methods show.

    Raises:
        ValueError: none; the message says what the methods are.
    """
    act, reset = _arguments(agent, "act"), _arguments(agent, "reset")
    if act is not None:
        if len(act) == 2 and act[1] == "info" and reset is not None and len(reset) == 1:
            return POLICY
        if act[-1:] == ["*"] or len(act) == 2:
            if reset is not None and (len(reset) == 1 or reset[-1:] == ["*"]):
                return LLF
        elif len(act) == 1 and reset in (None, [], ["*"]):
            return GYMNASIUM
    shown = ", ".join(_show(agent, method) for method in ("reset", "act"))
    raise ValueError(f"student {name!r} gave an agent with {shown}; {_EXPECTED}")


def as_text(action: Any) -> str:
    """An action as an answer in text mode: a text as it is, anything else as JSON."""
    try:
        text = action if isinstance(action, str) else json.dumps(action, default=_plain)
    except Exception:  # a circle, a key that is no text, too deep, or what a value of a user's own raises
        text = f"something of type {type(action).__name__} that is no JSON"
    return text.encode("utf-8", "replace").decode()  # half a character cannot be stored


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else repr(value)


def _arguments(agent: Any, method: str) -> list[str] | None:
    """Names of a method's required positional arguments, `*` for any number; None if it cannot be called."""
    function = getattr(agent, method, None)
    if not callable(function):
        return None
    names = []
    for parameter in inspect.signature(function).parameters.values():
        if parameter.kind is parameter.VAR_POSITIONAL:
            names.append("*")
        elif parameter.kind in (parameter.POSITIONAL_ONLY, parameter.POSITIONAL_OR_KEYWORD):
            if parameter.default is parameter.empty:
                names.append(parameter.name)
        elif parameter.kind is parameter.KEYWORD_ONLY and parameter.default is parameter.empty:
            return None
    return names


def _show(agent: Any, method: str) -> str:
    function = getattr(agent, method, None)
    return f"{method}{inspect.signature(function)}" if callable(function) else f"no {method}"
