"""The interface of every world: a Gymnasium environment whose state can be read, saved and restored."""

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

__all__ = ["ActionT", "ObservationT", "Snapshot", "TruthT", "World", "WorldTurn", "illegal", "is_number", "plain"]

_QUOTES = " \t\r\n.,;\"'`*"  # allowed around a word

TruthT = TypeVar("TruthT")
"""Type of `truth`: an immutable value that compares with `==`, such as a NamedTuple."""
ObservationT = TypeVar("ObservationT", default=Any)
"""Type of the observations that `reset`, `step` and `observe` return."""
ActionT = TypeVar("ActionT", default=Any)
"""Type of actions in canonical form, which `legal` returns and `advance` takes."""


class Snapshot(NamedTuple, Generic[TruthT]):
    """The complete state of a world."""

    truth: TruthT
    """The world's `truth` at the time of saving."""
    random_state: Mapping[str, Any]
    """State of the world's NumPy bit generator."""


class WorldTurn(NamedTuple, Generic[TruthT]):
    """A turn of the student."""

    action: Any
    """In canonical form; None at the opening and in turns without an action."""
    reward: float
    truth: TruthT
    """The truth after the turn."""
    success: bool = False
    reward_known: bool = False
    """Whether the student knows the reward: whether the teacher said it."""


class World(gymnasium.Env[ObservationT, ActionT], Generic[TruthT, ObservationT, ActionT]):
    """A simulator with Gymnasium spaces whose state can be read, saved and restored.

    `step` is `advance(legal(action))`. A family implements `advance`, the simulation, and overrides `legal` where the
    action space is not precise enough; `legal` returns the action in canonical form, or raises without changing the
    state. Worlds do not limit the length of an episode: the session truncates it.

    The type parameters are those of truths, observations and actions in canonical form, as in
    `class Maze(World[Truth, int, int])`; a function that accepts any world with such truths takes `World[Truth]`.
    """

    metadata: dict[str, Any] = {"render_modes": ["ansi"]}  # noqa: RUF012 (to Gymnasium it is no ClassVar)
    observation_space: spaces.Space[Any]
    action_space: spaces.Space[Any]
    """Elements of this space are what `step` takes; `legal` converts them to `ActionT`."""
    reward_range: tuple[float, float]
    """Least and greatest reward of a step."""
    action_words: Mapping[str, Any] = MappingProxyType({})
    """Lower-case words for actions in text mode, each with its action."""
    action_fillers: tuple[str, ...] = ()
    """Further lower-case words that a sentence with nothing but an action may contain, such as `go`."""
    action_parts: tuple[str, ...] = ()
    """Lower-case names of the numbers in an action that is a list, as keys in an answer."""
    answer_names: tuple[str, ...] = ()
    """Lower-case labels and JSON keys of an answer, in addition to `answer`, `action` and the like."""
    verbatim: bool = True
    """Whether a text is taken as the action word for word; otherwise `read` looks for the action within it."""
    several_lines: bool = False
    """Whether an action in text form may have several lines; typed at a prompt, it then ends with an empty line."""
    text_items: tuple[int, int] | None = None
    """Least and greatest number of texts in an answer that is asked for as a list of texts, such as lines of verse;
    None: the answer is not asked for as a list."""
    answer_words: tuple[str, ...] = ()
    """Words that `read` takes as actions, and that stand for none of their own, such as `stay`."""
    actions_key: str = ""
    """Key of the info that lists the actions that have an effect now; empty if there is no such list."""
    options: dict[str, Any]
    """Keyword arguments that construct an equal world."""
    reset_options: tuple[str, ...] | None = ()
    """Options that `reset` takes; None: any."""

    def __init__(self, *, render_mode: str | None = None, **options: Any) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            allowed = ", ".join(self.metadata["render_modes"])
            raise ValueError(f"render_mode {render_mode!r} is unknown; allowed: None, {allowed}")
        self.render_mode = render_mode
        self.options = options

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        """Check the options and seed the random stream; each world's `reset` calls this before its first draw.

        Raises:
            ValueError: see `check_reset`; the state is unchanged.
        """
        self.check_reset(options)
        return super().reset(seed=seed)

    def check_reset(self, options: dict[str, Any] | None) -> None:
        """Check the options of a reset; worlds that take options extend this to check their values.

        Raises:
            ValueError: an option is unknown, or its value is not allowed.
        """
        if options is not None and not isinstance(options, Mapping):
            raise ValueError(f"options must be a dict or None, got {options!r}")
        known = self.reset_options
        if known is not None and (unknown := [name for name in options or () if name not in known]):
            raise ValueError(f"reset option {unknown[0]!r} is unknown; allowed: {', '.join(known) or 'none'}")

    @property
    def failure_reward(self) -> float:
        """Reward of a turn in the current state if its text is not an action, so that the world does not step.

        It must be too low to exploit: in every state some action pays at least as much.
        """
        return 0.0

    @property
    @abstractmethod
    def truth(self) -> TruthT:
        """An immutable snapshot of the whole state without the random stream, comparable with `==`."""

    @cached_property
    def action_syntax(self) -> str:
        """The form of an answer in text mode, to complete "the answer must be ..."; by default from the action space.

        A world may define an attribute instead.
        """
        return syntax(self.action_space)

    def legal(self, action: Any) -> ActionT:
        """The action in canonical form: a hashable value of Python's own types. By default see `worlds.actions`.

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
        """Apply a legal action and return Gymnasium's five-tuple, with `success` (bool) in the info."""

    @abstractmethod
    def observe(self) -> ObservationT:
        """The current observation, as returned by `reset` or the last step, in a new object."""

    def describe(self, observation: ObservationT) -> str:
        """An observation as plain text; by default see `worlds.actions.format_value`."""
        return format_value(observation)

    def sample_action(self, rng: np.random.Generator) -> Any:
        """A random legal action, for exploration without knowledge of the task.

        By default it is a sample of the action space.
        """
        space = copy.deepcopy(self.action_space)  # so that its own random stream does not change
        space.seed(int(rng.integers(2**31)))
        return space.sample()

    def read(self, text: str) -> Any | None:
        """The action that a text names in the world's own words, by default `action_words`; None if it names no action.

        The result still has to pass `legal`.
        """
        return self.action_words.get(text.lstrip(_QUOTES).rstrip(f"{_QUOTES}!").lower())

    @abstractmethod
    def _load(self, truth: TruthT) -> None:
        """Set the state to that of a `truth`."""

    def step(self, action: Any) -> tuple[ObservationT, float, bool, bool, dict[str, Any]]:
        """Check and apply an action; see `legal` and `advance`."""
        return self.advance(self.legal(action))

    def save(self) -> Snapshot[TruthT]:
        """The exact state, including the random stream."""
        return Snapshot(self.truth, self.np_random.bit_generator.state)

    def restore(self, state: TruthT | Snapshot[TruthT]) -> None:
        """Return to a saved state; a bare `truth` leaves the random stream unchanged."""
        if isinstance(state, Snapshot):
            self.np_random.bit_generator.state = state.random_state
            self._load(state.truth)
        else:
            self._load(state)

    def state_of(self, truth: TruthT) -> Any:
        """A value that identifies the state of a truth; by default the truth itself."""
        return truth

    def scratch(self) -> Self:
        """A new world of the same class and options, for simulation apart from the episode. Restore it before use."""
        return type(self)(**self.options)

    def draw_options(self, rng: np.random.Generator) -> dict[str, Any]:
        """Random options of a world with the same task; by default its own.

        Audits check that claims hold in each of these worlds.
        """
        return self.options

    def draw_reset(self, rng: np.random.Generator) -> dict[str, Any]:
        """Random options for `reset`, also for audits; by default none."""
        return {}

    def elsewhere(self, seed: int) -> TruthT:
        """Begin another episode of the same kind, for claims that are true there and not here; returns its truth.

        By default `reset(seed=seed)`. A world where each episode has the same task changes the task: the result must
        still be a truth that `restore` accepts.
        """
        self.reset(seed=seed)
        return self.truth

    def original(self, actions: Sequence[Any], seed: int) -> gymnasium.Env[Any, Any] | None:
        """The environment of another package that this world reimplements, for benchmarks; None if there is none.

        Args:
            actions: the actions of the episode after `reset(seed=seed)`, for worlds that prepare the environment for
            them.
            seed: seed of the episode.
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


def plain(value: Any) -> Any:
    """A value as nested tuples that compare with `==`, arrays included."""
    if isinstance(value, dict):
        return tuple((key, plain(item)) for key, item in value.items())
    if isinstance(value, np.ndarray):
        return value.shape, value.dtype.str, value.tobytes()
    return tuple(map(plain, value)) if isinstance(value, list | tuple) else value


def is_number(value: Any) -> TypeGuard[float]:
    """Whether a value is a real number, of Python or NumPy; a bool is not."""
    return type(value) is float or (isinstance(value, Real) and not isinstance(value, bool))
