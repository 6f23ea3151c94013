"""What can be learned from an environment's rewards alone: facts that decide which learner suits it."""

from dataclasses import dataclass
from typing import Any

from teachers.spec import check_range


@dataclass(frozen=True)
class Learning:
    """The base of these facts; `KINDS` has all of them."""


@dataclass(frozen=True)
class NoRewards(Learning):
    """The only reward comes at the end of an episode, so nothing can be learned within it."""


@dataclass(frozen=True)
class ActionValues(Learning):
    """Each of finitely many actions has the same expected reward in every turn."""


@dataclass(frozen=True)
class StateValues(Learning):
    """Each of finitely many actions has a value in each state, and states recur."""


@dataclass(frozen=True)
class BestAnswer(Learning):
    """There is no state: the same action always gets the same reward."""


@dataclass(frozen=True)
class Smooth(Learning):
    """Actions are points of a box, and the reward is smooth in them."""

    size: float = 0.2
    """Length of a first step, as a share of the box's width, 0 to 1."""

    def __post_init__(self) -> None:
        check_range("size", self.size, 0, 1)


@dataclass(frozen=True)
class Trend(Learning):
    """Actions are points of a box, and an action that increases the reward does so for several turns."""


@dataclass(frozen=True)
class Lines(Learning):
    """Actions are texts; each line adds to the reward, depending on its syllables."""

    lengths: tuple[int, ...]
    """Numbers of lines that a text may want, the most likely first."""
    syllables: tuple[int, ...]
    """Numbers of syllables that a line may want, in the order in which to try them."""

    def __post_init__(self) -> None:
        for name in ("lengths", "syllables"):
            check_counts(name, getattr(self, name))


KINDS = (ActionValues, BestAnswer, Lines, NoRewards, Smooth, StateValues, Trend)
"""Every kind of fact."""


def check_learning(value: Any) -> None:
    """Check the `learning` of a declaration.

    Raises:
        ValueError: it is not an instance of `KINDS`.
    """
    if type(value) not in KINDS:
        allowed = ", ".join(f"{kind.__name__}(...)" for kind in KINDS)
        raise ValueError(f"learning must be one of pz_envs.learning: {allowed}; got {value!r}")


def check_counts(name: str, values: Any) -> None:
    """Check that a value is a non-empty tuple of positive integers.

    Raises:
        ValueError: the value is something else.
    """
    whole = isinstance(values, tuple) and all(type(value) is int and value > 0 for value in values)
    if not whole or not values:
        raise ValueError(f"{name} must be a tuple of positive integers, got {values!r}")
