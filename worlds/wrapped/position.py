"""The truth of a wrapped environment: the seed of an episode and the actions so far."""

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np

__all__ = ["Episode", "Position", "plain_parts", "same", "still"]


_PLAIN = bool, int, float, str, np.number, np.bool_, np.ndarray
_LARGE = 10_000  # numbers


class Episode:
    """All that a replay of an episode needs. Positions share it; a world only appends to its own episode."""

    __slots__ = ("actions", "anchor", "info", "live", "observation", "options", "parts", "rewards", "seed")

    def __init__(
        self,
        seed: int,
        options: dict[str, Any] | None,
        observation: Any,
        anchor: gymnasium.Env[Any, Any] | None,
        info: dict[str, Any] | None = None,
        parts: dict[str, Any] | None = None,
    ) -> None:
        self.seed, self.options = seed, options
        self.observation = observation
        """The observation of reset."""
        self.anchor: gymnasium.Env[Any, Any] | None = anchor
        """A copy of the environment after reset, which is never stepped; None if episodes are replayed."""
        self.info = info or {}
        """The info of reset, copied together with the anchor; empty without an anchor."""
        self.parts = parts or {}
        """If episodes are replayed, the environment's `plain_parts` after reset; a replay must have the same."""
        self.live: gymnasium.Env[Any, Any] | None = None
        """The environment that plays this episode, to be read only; None in forks, after its end, and in a pickle."""
        self.actions: list[Any] = []
        self.rewards: list[float] = []

    def fork(self, turn: int) -> "Episode":
        """A new episode with the same first actions."""
        other = Episode(self.seed, self.options, self.observation, self.anchor, self.info, self.parts)
        other.actions, other.rewards = self.actions[:turn], self.rewards[:turn]
        return other

    def __getstate__(self) -> tuple[None, dict[str, Any]]:
        return None, {name: getattr(self, name) for name in self.__slots__} | {"live": None}

    def __deepcopy__(self, memo: dict[int, Any]) -> "Episode":
        return self  # copies of a world fork it before they append


@dataclass(slots=True, eq=False)  # not frozen, since that doubles the time of construction
class Position:
    """The truth of a wrapped environment; immutable by convention."""

    seen: Any
    """The value of `look`; the observation if there is no `look`."""
    turn: int
    """Number of actions so far."""
    episode: Episode

    @property
    def seed(self) -> int:
        """The seed of the episode's reset."""
        return self.episode.seed

    @property
    def actions(self) -> tuple[Any, ...]:
        """The actions so far, in canonical form."""
        return tuple(self.episode.actions[: self.turn])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Position):
            return NotImplemented
        return self is other or (
            (self.turn, self.seed) == (other.turn, other.seed)
            and same(self.episode.options, other.episode.options)
            and self.actions == other.actions
            and same(self.seen, other.seen)
        )

    def __hash__(self) -> int:
        return hash((self.seed, self.turn))

    def __deepcopy__(self, memo: dict[int, Any]) -> "Position":
        return self


def same(one: Any, other: Any) -> bool:
    """Whether two nested values are equal, arrays and NaN included."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return type(one) is type(other) and one.dtype == other.dtype and np.array_equal(one, other)
    if isinstance(one, Mapping):
        return isinstance(other, Mapping) and one.keys() == other.keys() and all(same(one[k], other[k]) for k in one)
    if isinstance(one, list | tuple):
        return type(one) is type(other) and len(one) == len(other) and all(map(same, one, other))
    return bool(one == other) or bool(one != one and other != other)


def plain_parts(env: gymnasium.Env[Any, Any]) -> dict[str, Any]:
    """Copies of the numbers, texts and arrays among the attributes of an environment, without those of its wrappers.

    Attributes for rendering and large arrays are left out.
    """
    return {
        name: still(part)
        for name, part in vars(env.unwrapped).items()
        if isinstance(part, _PLAIN) and "render" not in name and np.size(part) <= _LARGE and not _is_of_objects(part)
    }


def _is_of_objects(part: Any) -> bool:
    return isinstance(part, np.ndarray) and part.dtype == object


def still(value: Any) -> Any:
    """A copy that is independent of the environment."""
    if type(value) in (int, float, str, bool) or value is None:
        return value
    return value.copy() if type(value) is np.ndarray else copy.deepcopy(value)
