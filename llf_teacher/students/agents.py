"""Users' own agents in the student's seat, by specs such as `my_package.my_module:MyAgent(size=3)`.

The spec names a factory: a class or a function that takes the keyword arguments and returns an agent. Each episode
calls it again, in the process that plays the episode. The agent's methods show which of four protocols it has:

    LLF-Bench   reset(docstring)           act(observation, feedback)   two arguments, or `*args`
    Gymnasium   reset(), or none           act(observation)             one argument: the dict of three strings
    policy      reset(rng)                 act(observation, info)       two arguments, the second named `info`
    numbers     reset(), or none           act(numbers)                 one argument: the array of `numbers=True`

Arguments with a default do not count. Agents of the first two protocols read and write text. Policies read and write
the world's own observations and actions, numeric agents read the array of `StudentEnv(numbers=True)`. An attribute
`text` of the agent overrides this. An illegal action costs a turn.
"""

import importlib
import inspect
import json
from collections.abc import Awaitable, Callable, Generator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from llf_teacher.students.chat import can_answer
from llf_teacher.students.student import READS, ModelReply, Policy, Student, state_of
from pz_envs.numbers import Numbers
from pz_envs.text.actions import failure
from teachers.atoms import ParseFailure
from teachers.spec import SpecCall, call_string, unknown
from worlds.world import World

LLF, GYMNASIUM, POLICY, NUMBERS = "LLF-Bench", "Gymnasium", "policy", "numbers"
_EXPECTED = (
    "expected reset(docstring) and act(observation, feedback), or act(observation), "
    "or reset(rng) and act(observation, info), or act(numbers)"
)
_LATER = {
    "a coroutine function (`async def`)": inspect.iscoroutinefunction,
    "a generator (`yield`)": inspect.isgeneratorfunction,
    "an asynchronous generator": inspect.isasyncgenfunction,
}


class _Policy(Policy["Agent"]):
    """Calls the agent by its protocol."""

    def begin(self) -> None:
        """Reset the agent; an agent of LLF-Bench is reset in the first turn, with the instruction."""
        agent, protocol = self.spec.agent, self.spec.protocol
        self._opening = True
        self._numbers: Numbers | None = None
        if protocol == POLICY:
            agent.reset(self.rng)
        elif protocol in (GYMNASIUM, NUMBERS) and hasattr(agent, "reset"):
            agent.reset()

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """The agent's action."""
        agent, protocol = self.spec.agent, self.spec.protocol
        state = state_of(observation)
        # Plain strings: the atoms of a teacher's utterance are in the info, for agents that read atoms.
        instruction, feedback = f"{observation['instruction']!s}", f"{observation['feedback']!s}"
        opening, self._opening = self._opening, False
        if protocol == LLF:
            if opening:
                agent.reset(instruction)
            action = agent.act(state, None if opening and not feedback else feedback)
        elif protocol == NUMBERS:
            action = agent.act(self._array(state, instruction, feedback, info))
        elif protocol == GYMNASIUM:
            given = instruction if opening else ""
            action = agent.act({"observation": state, "instruction": given, "feedback": feedback})
        else:
            action = agent.act(observation | {"instruction": instruction, "feedback": feedback}, info)
        if issubclass(type(action), Awaitable | Generator):  # not `isinstance`, which an object can override
            raise TypeError(f"student {self.spec}: act must return an action, got a {type(action).__name__}")
        return as_answer(action, self.world) if self.spec.text else self._native(action)

    def _array(self, state: Any, instruction: str, feedback: str, info: dict[str, Any]) -> Any:
        """The observation of `StudentEnv(numbers=True)` in this turn."""
        if "atoms" not in info:
            raise ValueError(f"student {self.spec}: act(numbers) needs atoms; set `reads = 'atoms'` on the factory")
        if self._numbers is None:  # in the first turn all turns are left
            self._most = info["turns_left"]
            self._numbers = Numbers(self.world, self._most, getattr(self.spec.agent, "embed", None))
        turn = self._most - info["turns_left"]
        return self._numbers.of(state, turn, instruction, feedback, info["atoms"])

    def _native(self, action: Any) -> Any:
        """The action; a `ParseFailure` if it is outside the action space."""
        action = as_text(action) if issubclass(type(action), str) else action
        try:
            self.world.legal(action)
        except KeyboardInterrupt:
            raise
        except BaseException:  # a user's own values may raise anything
            return failure(as_text(action), self.world)
        return action

    def did(self, action: Any) -> None:
        """Call the agent's `did(action)`, if it has this method."""
        if callable(did := getattr(self.spec.agent, "did", None)):
            did(action)

    def record(self) -> ModelReply:
        """The result of the agent's `record()`, if it has this method."""
        if not callable(record := getattr(self.spec.agent, "record", None)):
            return {}
        reply: ModelReply = record()
        known = ModelReply.__annotations__
        for name in reply:
            if name not in known:
                raise ValueError(f"student {self.spec}: {unknown('key of its record', name, known)}")
        return reply


@dataclass(frozen=True)
class Agent(Student):
    """An agent, by its factory."""

    module: str
    """Dotted name of the module."""
    factory: str
    """Name of the factory within it."""
    options: tuple[tuple[str, Any], ...] = ()
    """Keyword arguments of the factory, in the given order."""

    policy = _Policy

    def __str__(self) -> str:
        return call_string(f"{self.module}:{self.factory}", dict(self.options))

    @property
    def reads(self) -> str:
        """The factory's attribute `reads`; by default `atoms` of a class with `act(numbers)`, `words` of others."""
        default = "atoms" if (_arguments(self.make, "act") or [])[-1:] == [NUMBERS] else "words"
        return getattr(self.make, "reads", default)

    @property
    def text(self) -> bool:
        """Whether the agent plays in text mode."""
        return bool(getattr(self.agent, "text", self.protocol not in (POLICY, NUMBERS)))

    @property
    def remembers(self) -> bool:
        """True: within a lifetime the agent stays the same object."""
        return True

    def check(self, environment: Mapping[str, str]) -> None:
        """Check the methods of a factory that is a class; it is not called."""
        _check_calls(self.make, f"{self}")

    @cached_property
    def make(self) -> Callable[..., Any]:
        """The factory."""
        make: Callable[..., Any] = getattr(importlib.import_module(self.module), self.factory)
        return make

    @cached_property
    def agent(self) -> Any:
        """The agent, made on first use."""
        return self.make(**dict(self.options))

    @cached_property
    def protocol(self) -> str:
        """`LLF`, `GYMNASIUM`, `POLICY` or `NUMBERS`.

        Raises:
            ValueError: the agent's methods fit none of them.
        """
        return protocol_of(self.agent, f"{self}")


def make_agent(call: SpecCall) -> Agent:
    """The agent for a call with a module prefix; imports the module, does not call the factory.

    Raises:
        ValueError: there is no such module or factory, or it does not take the arguments.
    """
    module, factory = call.imported("student")
    if not callable(factory):
        names = [name for name, value in vars(module).items() if callable(value) and not name.startswith("_")]
        raise ValueError(f"student {call.path!r}: {unknown(f'factory in {module.__name__}', call.name, sorted(names))}")
    try:
        call.check_arguments("student", factory)
    except ValueError as error:
        hint = ""
        if not call.arguments and not isinstance(factory, type) and can_answer(factory):
            hint = f"; a function that answers prompts is named 'chat:{call}'"
        raise ValueError(f"{error}{hint}") from None
    agent = Agent(call.prefix[-1], call.name, tuple(call.arguments.items()))
    if agent.reads not in READS:
        raise ValueError(f"student {call.path!r}: {unknown('value of reads', agent.reads, READS)}")
    return agent


def protocol_of(agent: Any, name: str) -> str:
    """The protocol that an agent's methods show.

    Raises:
        ValueError: the methods fit no protocol; the message shows them.
    """
    _check_calls(agent, name)
    act, reset = _arguments(agent, "act"), _arguments(agent, "reset")
    if act is not None:
        if len(act) == 2 and act[1] == "info" and reset is not None and len(reset) == 1:
            return POLICY
        if act[-1:] == ["*"] or len(act) == 2:
            if reset is not None and (len(reset) == 1 or reset[-1:] == ["*"]):
                return LLF
        elif act == [NUMBERS] and reset in (None, [], ["*"]):
            return NUMBERS
        elif len(act) == 1 and reset in (None, [], ["*"]):
            return GYMNASIUM
    shown = ", ".join(_show(agent, method) for method in ("reset", "act"))
    raise ValueError(f"student {name!r} gave an agent with {shown}; {_EXPECTED}")


def _check_calls(agent: Any, name: str) -> None:
    """Check that the methods of an agent, or of its class, are ordinary functions, not `async` or generators.

    Raises:
        ValueError: a method is not.
    """
    for method in ("reset", "act"):
        function: Any = inspect.unwrap(getattr(agent, method, None))  # type: ignore[arg-type]
        for kind, is_kind in _LATER.items():
            if is_kind(function):
                raise ValueError(
                    f"student {name!r} gave an agent whose {method} is {kind}; expected a method that returns its "
                    "result when it is called: define it by `def`, with `return`"
                )


def as_answer(action: Any, world: World[Any]) -> str | ParseFailure:
    """An action as text: a text stays, an array becomes a JSON list; a failure if the action has no JSON form."""
    text = _json(action)
    return failure(as_text(action), world) if text is None else text


def as_text(action: Any) -> str:
    """An action as text: a text stays, anything else becomes JSON, or a phrase with its type."""
    text = _json(action)
    return f"something of type {type(action).__name__} that is no JSON" if text is None else text


def _json(action: Any) -> str | None:
    """A text, or the JSON of a value; None if the value has no JSON form."""
    try:
        text = action if isinstance(action, str) else json.dumps(action, default=lambda value: value.tolist())
        return text.encode("utf-8", "replace").decode()  # a lone surrogate cannot be stored
    except KeyboardInterrupt:
        raise
    except BaseException:  # bytes, cycles, keys that are not strings, deep nesting, errors of a user's own value
        return None


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
