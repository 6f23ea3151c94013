"""The interface of every world: a Gymnasium environment whose state can be seen, saved and restored."""

import copy
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from functools import cached_property
from numbers import Real
from types import MappingProxyType
from typing import Any, Generic, NamedTuple, Self, TypeGuard

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from typing_extensions import TypeVar

from worlds.actions import canonical, format_value, syntax

__all__ = ["ActionT", "ObservationT", "Snapshot", "TruthT", "World", "illegal", "is_number"]

_QUOTES = " \t\r\n.,;!\"'`*"  # what may stand around a word

TruthT = TypeVar("TruthT")
"""What `truth` gives: an immutable value that compares with `==`, such as a NamedTuple."""
ObservationT = TypeVar("ObservationT", default=Any)
"""What `reset`, `step` and `observe` give."""
ActionT = TypeVar("ActionT", default=Any)
"""The canonical form of actions: what `legal` gives and `advance` takes."""


class Snapshot(NamedTuple, Generic[TruthT]):
    """All that determines a world's future."""

    truth: TruthT
    """The world's `truth` at the time of saving."""
    random_state: Mapping[str, Any]
    """State of the world's NumPy bit generator."""


class World(gymnasium.Env[ObservationT, ActionT], Generic[TruthT, ObservationT, ActionT]):
    """A simulator with native spaces that can be looked into, saved and replayed.

    `step` is `advance(legal(action))`. A family implements `advance`, which is the simulation, and `legal` where the
    action space does not say enough; `legal` returns the action in its canonical form, or raises without touching the
    state. An episode's length is not the world's business: who plays it truncates.

    A world says of which types its truths, its observations and its actions in canonical form are, as in
    `class Maze(World[Truth, int, int])`; to one who takes any world of such truths, `World[Truth]` is enough.
    """

    metadata: dict[str, Any] = {"render_modes": ["ansi"]}  # noqa: RUF012 (to Gymnasium it is no ClassVar)
    observation_space: spaces.Space[Any]
    action_space: spaces.Space[Any]
    """What `step` takes: `legal` makes `ActionT` of its elements."""
    reward_range: tuple[float, float]
    """Least and greatest reward of one step."""
    action_words: Mapping[str, Any] = MappingProxyType({})
    """Lower-case words that name an action in text mode, each with its action."""
    action_fillers: tuple[str, ...] = ()
    """Further lower-case words that may stand around an action in a sentence that says nothing else, such as `go`."""
    action_parts: tuple[str, ...] = ()
    """Lower-case names of the numbers of which an action is a list, by which an answer may give them."""
    answer_names: tuple[str, ...] = ()
    """What an answer may be called beside `answer`, `action` and the like, in lower case: labels, and keys of JSON."""
    verbatim: bool = True
    """Whether a text that is an action is taken word for word; else `read` finds it in what is written around it."""
    several_lines: bool = False
    """Whether a text that is an action may have several lines; people who type it then end it with an empty one."""
    actions_key: str = ""
    """Key of the info under which it lists the actions that come to something now; empty if it lists none."""
    options: dict[str, Any]
    """Keyword arguments that construct an equal world."""
    reset_options: tuple[str, ...] | None = ()
    """The options that `reset` knows; None: it takes any."""

    def __init__(self, *, render_mode: str | None = None, **options: Any) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            allowed = ", ".join(self.metadata["render_modes"])
            raise ValueError(f"render_mode {render_mode!r} is unknown; allowed: None, {allowed}")
        self.render_mode = render_mode
        self.options = options

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        """What every world's `reset` calls before it draws anything: check the options, and seed the random stream.

        Raises:
            ValueError: as `check_reset`; nothing has changed.
        """
        self.check_reset(options)
        return super().reset(seed=seed)

    def check_reset(self, options: dict[str, Any] | None) -> None:
        """Check the options of a reset; a world checks their values, too.

        Raises:
            ValueError: an option is unknown, or its value is not allowed.
        """
        if options is not None and not isinstance(options, Mapping):
            raise ValueError(f"options must be a dict or None, got {options!r}")
        known = self.reset_options
        if known is not None and (strange := [name for name in options or () if name not in known]):
            raise ValueError(f"reset knows no option {strange[0]!r}; allowed: {', '.join(known) or 'none here'}")

    @property
    def failure_reward(self) -> float:
        """Reward of a turn, now, in which the text that was given was no action; the world did not step.

        A world has one that no student can live on: in every state some action pays as much.
        """
        return 0.0

    @property
    @abstractmethod
    def truth(self) -> TruthT:
        """An immutable snapshot of the whole state but for the random stream, comparable with `==`."""

    @cached_property
    def action_syntax(self) -> str:
        """What an answer in text mode has to look like, to complete "the answer must be ..."; by default as the space
        has it. A world may have an attribute instead.
        """  # noqa: D205
        return syntax(self.action_space)

    def legal(self, action: Any) -> ActionT:
        """The action in canonical form: a hashable value of Python's own types, by default as the space has it.

        Raises:
            ValueError: the action is outside the action space; the state is unchanged.
        """
        try:
            known: ActionT = canonical(self.action_space, action)
        except (ValueError, TypeError, OverflowError):
            raise illegal(action, self.action_syntax) from None
        return known

    @abstractmethod
    def advance(self, action: ActionT) -> tuple[ObservationT, float, bool, bool, dict[str, Any]]:
        """Apply a legal action; return Gymnasium's five-tuple, with `success` (bool) in the info."""

    @abstractmethod
    def observe(self) -> ObservationT:
        """The current observation, a fresh value: the one that `reset` or the last step gave."""

    def describe(self, observation: ObservationT) -> str:
        """The canonical plain-text rendering of an observation, by default in plain numbers."""
        return format_value(observation)

    def sample_action(self, rng: np.random.Generator) -> Any:
        """A random action, such as one might try who knows nothing of the task: in the action space, and legal.

        By default it is a sample of the action space.
        """
        space = copy.deepcopy(self.action_space)  # whose own stream stays as it is
        space.seed(int(rng.integers(2**31)))
        return space.sample()

    def read(self, text: str) -> Any | None:
        """The action that a text stands for in the world's own words; None if it is none.

        By default these are `action_words`. `legal` has the last word on what it gives.
        """
        return self.action_words.get(text.strip(_QUOTES).lower())

    @abstractmethod
    def _load(self, truth: TruthT) -> None:
        """Take over the state that a `truth` holds."""

    def step(self, action: Any) -> tuple[ObservationT, float, bool, bool, dict[str, Any]]:
        """Check and apply an action; see `legal` and `advance`."""
        return self.advance(self.legal(action))

    def save(self) -> Snapshot[TruthT]:
        """The exact state, random stream included."""
        return Snapshot(self.truth, self.np_random.bit_generator.state)

    def restore(self, state: TruthT | Snapshot[TruthT]) -> None:
        """Return to a saved state; a bare `truth` leaves the world's own random stream as it is."""
        if isinstance(state, Snapshot):
            self.np_random.bit_generator.state = state.random_state
            self._load(state.truth)
        else:
            self._load(state)

    def state_of(self, truth: TruthT) -> Any:
        """What tells the state of a truth from other states; the truth itself by default."""
        return truth

    def scratch(self) -> Self:
        """A new world of the same class and options, for experiments on the side. Restore before use."""
        return type(self)(**self.options)

    def draw_options(self, rng: np.random.Generator) -> dict[str, Any]:
        """Options of a world with the same task, drawn from those that it may have; by default its own.

        What is said has to hold of each such world: audits teach in some.
        """
        return self.options

    def draw_reset(self, rng: np.random.Generator) -> dict[str, Any]:
        """Options that `reset` may be given, for the same purpose; by default none."""
        return {}

    def original(self, actions: Sequence[Any], seed: int) -> gymnasium.Env[Any, Any] | None:
        """For benchmarks: the environment of another package that does this world's work; None if there is none.

        Args:
            actions: what it will be stepped through after `reset(seed=seed)`; a world may prepare for them.
            seed: of the one episode that it is made for.
        """
        return None

    def render(self) -> str | npt.NDArray[np.uint8] | None:
        """The current observation as text, when `render_mode="ansi"`."""
        return self.describe(self.observe()) if self.render_mode == "ansi" else None


def illegal(action: Any, allowed: str) -> ValueError:
    """The error for an action outside the action space."""
    got = repr(action)
    got = got if len(got) <= 80 else got[:77] + "..."
    return ValueError(f"action {got} is not in the action space; allowed: {allowed}; the state is unchanged")


def is_number(value: Any) -> TypeGuard[float]:
    """Whether a value is a real number, of Python or NumPy; a bool is none."""
    return type(value) is float or (isinstance(value, Real) and not isinstance(value, bool))
