"""Personalities choose, delay, change or withhold an oracle's claims.

A personality is a frozen value in a module of its name under `teachers/personalities/`. Without memory it is a
function, decorated by `personality`; with memory it is a dataclass, whose fields are its parameters, and a `Stage`,
which holds the memory of one episode. Personalities compose left to right with `|`, and their strings round-trip:
`mistake(eps=0.1) | delayed(turns=2)`.
"""

import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Sequence
from dataclasses import Field, dataclass
from types import FunctionType
from typing import Any, ClassVar, Concatenate, Generic, ParamSpec, Protocol, TypeVar, get_type_hints, overload

import numpy as np
from typing_extensions import override

from teachers import personalities
from teachers.atoms import Claim
from teachers.batches import Kinds, Moments, OracleBatch
from teachers.oracle import ABILITIES, Oracle
from teachers.spec import Registry, Spec, fits, unknown
from teachers.view import View
from worlds.batches import Floats

__all__ = [
    "PERSONALITIES",
    "Claims",
    "Personality",
    "PersonalityError",
    "Pipeline",
    "Stage",
    "View",
    "check_served",
    "parse_personality",
    "personality",
    "stages_of",
]

Claims = Sequence[Claim[Any]]
"""Claims in speaking order."""
P = ParamSpec("P")
S = TypeVar("S", bound="Personality")


class PersonalityError(TypeError):
    """A class, or what it returns, has not the form of a personality."""


class Stage(ABC, Generic[S]):
    """A personality in one episode."""

    def __init__(self, spec: S, rng: np.random.Generator) -> None:
        self.spec = spec
        """The personality, for its parameters."""
        self.rng = rng
        """Its own random stream."""
        self.begin()

    def begin(self) -> None:
        """Set up the memory of the episode."""

    @abstractmethod
    def speak(self, claims: Claims, view: View) -> Claims:
        """The claims to say, given those of the oracle or of the previous stage. Called once a turn."""


class Personality(Spec):
    """Base of all personalities: a frozen value that starts a `Stage` for each episode."""

    package: ClassVar[str] = personalities.__name__
    stage: ClassVar[type[Stage[Any]]]
    """The class of its stages."""
    source: ClassVar[str] = "ours"
    """The source of the definition."""

    # A subclass sets these, as in `honest = False`, or computes them from its parameters in a property.

    def __init_subclass__(cls, **options: Any) -> None:
        """Check the attributes that the class sets.

        Raises:
            PersonalityError: one is not of the form that is wanted.
        """
        super().__init_subclass__(**options)
        for name, (form, has_it) in _FORMS.items():
            value = vars(cls).get(name)
            if name in vars(cls) and not _computed(value) and not has_it(value):
                raise PersonalityError(f"{cls.__module__}:{cls.__qualname__}: {name} must be {form}, got {value!r}")

    @property
    def needs(self) -> frozenset[str]:
        """The `teachers.oracle.ABILITIES` that the oracle must have."""
        return frozenset()

    @property
    def honest(self) -> bool:
        """Whether all its claims are true, given true claims."""
        return True

    @property
    def elsewhere(self) -> bool:
        """Whether its claims are those of other moments: true there, and here by chance; see `View.displace`."""
        return False

    @property
    def reveals(self) -> bool:
        """Whether it may reveal the action to take; if not, audits check that it does not."""
        return True

    @property
    def evidence(self) -> str:
        """What it sees in place of the truth, one of `teachers.partial.EVIDENCE`; empty if it sees the truth."""
        return ""

    @property
    def transparent(self) -> bool:
        """Whether it passes on every claim unchanged; then it is not called."""
        return False

    @property
    def mute(self) -> bool:
        """Whether it withholds every claim; then neither it nor the oracle is called."""
        return False

    def start(self, rng: np.random.Generator) -> Stage[Any]:
        """The stage for one episode.

        Raises:
            PersonalityError: the class has no stage.
        """
        if getattr(self, "stage", None) is None:
            raise PersonalityError(
                f"{type(self).__module__}:{type(self).__qualname__} lacks `stage`: set it to a subclass of "
                "teachers.personality.Stage with a method speak(claims, view), or write the personality as a function "
                "with the decorator `personality`"
            )
        return self.stage(self, rng)

    # In arrays: for a class that only withholds or delays kinds of claims, what it overrides beside `stage`.

    row_memory: ClassVar[int] = 0
    """How many numbers its stage remembers per row, in addition to `row_delay`; all are 0 at the opening."""

    @property
    def row_delay(self) -> int:
        """By how many turns it delays all claims; its stage remembers one number more for each."""
        return 0

    def speak_rows(self, kinds: Kinds, memory: Floats, moments: Moments[Any], oracle: OracleBatch[Any]) -> Kinds:
        """The kinds to say in some rows: `Stage.speak` in arrays.

        Args:
            kinds: the kinds that the oracle or the previous stage says.
            memory: what the stage remembers, shape (rows, numbers); changed in place.
            moments: the moments to speak about, in the same rows.
            oracle: computes values and stakes of their states.
        """
        return np.zeros_like(kinds) if self.mute else kinds

    @classmethod
    def in_arrays(cls) -> bool:
        """Whether it has a form in arrays."""
        always: tuple[Any, ...] = cls.mute, cls.transparent
        return True in always or fits(cls, "stage", "speak_rows")

    def __or__(self, after: "Personality") -> "Pipeline":
        """A pipeline: the second personality gets the claims that the first passes on.

        The order matters: `harsh | mistake(eps=1)` turns blame into false praise; `mistake(eps=1) | harsh` turns all
        claims false and keeps the false blame.
        """
        if not isinstance(after, Personality):
            raise TypeError(f"what stands behind | must be a personality, such as harsh(), got {after!r}")
        return Pipeline((*stages_of(self), *stages_of(after)))


def _computed(value: Any) -> bool:
    """Whether an attribute is a property or the field of a dataclass, whose value its object has."""
    return isinstance(value, Field) or (hasattr(value, "__get__") and not isinstance(value, FunctionType))


_FORMS: dict[str, tuple[str, Callable[[Any], bool]]] = {
    "needs": (
        "a frozenset of abilities of the oracle, as in needs = frozenset({'values'}); allowed: "
        f"{', '.join(ABILITIES)}",
        lambda value: isinstance(value, frozenset) and value <= {*ABILITIES},
    ),
    "stage": (
        "a subclass of teachers.personality.Stage, as in stage = MyStage",
        lambda value: isinstance(value, type) and issubclass(value, Stage),
    ),
    **dict.fromkeys(
        ("honest", "elsewhere", "reveals", "transparent", "mute"),
        ("True or False, or a property", lambda value: isinstance(value, bool)),
    ),
}
"""For attributes that a personality may set, the form that is wanted, and whether a value has it."""


def check_said(said: Any, stage: Stage[Any]) -> tuple[Claim[Any], ...]:
    """What a stage has said, as claims.

    Raises:
        PersonalityError: it said something else.
    """
    try:
        claims = tuple(said)
    except TypeError:
        claims = (None,)
    if isinstance(said, str) or not all(isinstance(claim, Claim) for claim in claims):
        own = stage.spec if isinstance(stage, _Turn) else stage
        where = f"{type(own).__module__}:{type(own).__qualname__}"
        code = getattr(type(stage).speak, "__code__", None)
        line = "" if code is None or own is not stage else f" (speak begins in line {code.co_firstlineno})"
        raise PersonalityError(
            f"{where}{line} must return claims, such as some of those that it is given, or () to say nothing, got "
            f"{said!r:.80}; words of its own need a policy with reset and act, or a voice behind a personality"
        )
    return claims


class _Turn(Stage["Memoryless"]):
    """Calls the function of a personality without memory."""

    def speak(self, claims: Claims, view: View) -> Claims:
        return self.spec.says(claims, view, self.rng, **vars(self.spec))


class Memoryless(Personality):
    """Base of the personalities that are functions; see `personality`."""

    says: ClassVar[Callable[..., Claims]]
    """The claims to say, given claims, view, random stream and parameters."""
    stage = _Turn


class _Decorator(Protocol):
    """Turns a function into a class; type checkers see a function of the parameters."""

    @overload
    def __call__(
        self, function: Callable[Concatenate[Claims, View, np.random.Generator, P], Claims], /
    ) -> Callable[P, Personality]: ...

    @overload
    def __call__(self, function: Callable[Concatenate[Claims, View, P], Claims], /) -> Callable[P, Personality]: ...


def personality(
    *,
    source: str = Personality.source,
    needs: Collection[str] = (),
    honest: bool = True,
    reveals: bool = True,
    transparent: bool = False,
    mute: bool = False,
) -> _Decorator:
    """Return a decorator that turns a function into a personality without memory; it is called once a turn.

    The function takes the claims, the view and, if it draws, a random stream; then the parameters by keyword, each with
    a default. The decorator makes a frozen class with the function's name and these parameters: `mistake(eps=0.2)` is
    a personality.

        @personality(source="B-Pref eps_mistake", honest=False)
        def mistake(claims: Claims, view: View, rng: np.random.Generator, *, eps: Share = 0.1) -> Claims:

    The arguments are the attributes of `Personality`.

    Raises:
        TypeError: the function has another signature.
        ValueError: an ability in `needs` is unknown, or a default is out of range.
    """
    for need in needs:
        if need not in ABILITIES:
            raise ValueError(unknown("ability", need, ABILITIES))

    def make(function: Callable[..., Claims]) -> Callable[..., Personality]:
        draws, defaults = _read(function)
        hints = get_type_hints(function, include_extras=True)

        def says(claims: Claims, view: View, rng: np.random.Generator, **parameters: Any) -> Claims:
            return function(claims, view, rng, **parameters) if draws else function(claims, view, **parameters)

        members = {
            "__module__": function.__module__,
            "__qualname__": function.__qualname__,
            "__doc__": function.__doc__,
            "__annotations__": {name: hints.get(name, Any) for name in defaults},
            "says": staticmethod(says),
            "source": source,
            "needs": frozenset(needs),
            "honest": honest,
            "reveals": reveals,
            "transparent": transparent,
            "mute": mute,
        }
        cls: Any = dataclass(frozen=True, kw_only=True)(type(function.__name__, (Memoryless,), members | defaults))
        cls()  # checks the defaults
        made: Callable[..., Personality] = cls
        return made

    return make


def _read(function: Callable[..., Claims]) -> tuple[bool, dict[str, Any]]:
    """Whether the function of a personality takes a random stream, and its parameters with their defaults."""
    signature = inspect.signature(function)
    each = signature.parameters.values()
    first = [str(one.replace(annotation=one.empty)) for one in each if one.kind is not one.KEYWORD_ONLY]
    defaults = {one.name: one.default for one in each if one.kind is one.KEYWORD_ONLY}
    free = not any(
        default is inspect.Parameter.empty or hasattr(Memoryless, name) for name, default in defaults.items()
    )
    if first not in (["claims", "view"], ["claims", "view", "rng"]) or not free:
        raise TypeError(
            f"{function.__name__}{signature} is not a personality: it must take (claims, view) or (claims, view, rng), "
            "then keyword-only parameters with defaults and not named like an attribute of Personality, such as "
            f"{function.__name__}(claims, view, rng, *, eps=0.1)"
        )
    return first[-1] == "rng", defaults


class _InTurn(Stage["Pipeline"]):
    """Stages in order, each with its own random stream."""

    def begin(self) -> None:
        stages = self.spec.stages
        self._stages = [stage.start(rng) for stage, rng in zip(stages, self.rng.spawn(len(stages)), strict=True)]

    def speak(self, claims: Claims, view: View) -> Claims:
        for stage in self._stages:
            claims = check_said(stage.speak(claims, view), stage)
        return claims


@dataclass(frozen=True)
class Pipeline(Personality):
    """Applies personalities from left to right."""

    stages: tuple[Personality, ...]
    stage = _InTurn

    @property
    def needs(self) -> frozenset[str]:
        """The needs of all stages."""
        return frozenset().union(*(stage.needs for stage in self.stages))

    @property
    @override
    def transparent(self) -> bool:
        return all(stage.transparent for stage in self.stages)

    @property
    def mute(self) -> bool:
        """Whether the last stage is mute: a stage after a mute one may add claims."""
        return self.stages[-1].mute

    @property
    @override
    def honest(self) -> bool:
        return all(stage.honest for stage in self.stages)

    @property
    @override
    def elsewhere(self) -> bool:
        return any(stage.elsewhere for stage in self.stages)

    @property
    def reveals(self) -> bool:
        """Whether a stage reveals actions that no later one keeps back; some need no claims of earlier stages."""
        revealed = True
        for stage in self.stages:
            own = "plan" in stage.needs or stage.evidence or stage.elsewhere
            revealed = stage.reveals and (revealed or bool(own))
        return revealed

    def __str__(self) -> str:
        return " | ".join(map(str, self.stages))


def stages_of(personality: Personality) -> tuple[Personality, ...]:
    """The stages of a pipeline; any other personality is its own only stage."""
    return personality.stages if isinstance(personality, Pipeline) else (personality,)


def check_served(
    personality: Personality, oracle: Oracle | type[Oracle], beside: Collection[str] = frozenset()
) -> None:
    """Check that an oracle and the abilities `beside` it have all that a personality needs.

    Raises:
        ValueError: some are missing; the message names them.
    """
    able = oracle.abilities().union(beside)
    for stage in stages_of(personality):
        if missing := sorted(stage.needs - able):
            name = oracle.__name__ if isinstance(oracle, type) else type(oracle).__name__
            raise ValueError(
                f"personality '{stage}' needs {', '.join(missing)} of the oracle, which {name} does not give; "
                f"it gives: {', '.join(sorted(able)) or 'nothing'}; docs/personalities.md shows which family serves "
                "which personality"
            )


PERSONALITIES = Registry("personality", Personality, personalities)
"""Every personality by its name."""


def parse_personality(spec: str | Personality) -> Personality:
    """The personality that a spec string describes; `package.module:Class` imports a user's own.

    Raises:
        ValueError: a name or parameter is unknown, or the syntax is wrong; the message says what is allowed.
    """
    return spec if isinstance(spec, Personality) else in_turn(PERSONALITIES.parse(spec))


def in_turn(stages: Sequence[Personality]) -> Personality:
    """The personality that applies some personalities, from left to right."""
    return stages[0] if len(stages) == 1 else Pipeline(tuple(stages))
