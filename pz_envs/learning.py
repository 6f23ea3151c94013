"""What rewards alone teach in an environment: facts about it, by which a learner can be chosen that suits it."""

from dataclasses import dataclass
from typing import Any

from teachers.spec import check_range


@dataclass(frozen=True)
class Learning:
    """Base of these facts; `KINDS` are all that there are."""


@dataclass(frozen=True)
class NoRewards(Learning):
    """No reward comes before the end, so that there is nothing to learn from."""


@dataclass(frozen=True)
class ActionValues(Learning):
    """Each of finitely many actions is worth the same, on average, in every turn."""


@dataclass(frozen=True)
class StateValues(Learning):
    """Each of finitely many actions has a value in each state, and states come again."""


@dataclass(frozen=True)
class BestAnswer(Learning):
    """There is no state: an action that paid pays again."""


@dataclass(frozen=True)
class Smooth(Learning):
    """Actions are points of a box, and the reward is smooth in them."""

    size: float = 0.2
    """Length of a first step, as a share of the box's width, 0 to 1."""

    def __post_init__(self) -> None:
        check_range("size", self.size, 0, 1)


@dataclass(frozen=True)
class Trend(Learning):
    """Actions are points of a box, and one that makes the reward rise makes it rise for a while."""


@dataclass(frozen=True)
class Lines(Learning):
    """Actions are texts, and each of their lines adds to the reward by its syllables."""

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
    """Make sure that a declaration says what there is to learn.

    Raises:
        ValueError: it is no instance of `KINDS`.
    """
    if type(value) not in KINDS:
        allowed = ", ".join(f"{kind.__name__}(...)" for kind in KINDS)
        raise ValueError(f"learning must be one of pz_envs.learning: {allowed}; got {value!r}")


def check_counts(name: str, values: Any) -> None:
    """Make sure that something is a tuple of positive integers, at least one.

    Raises:
        ValueError: it is not.
    """
    whole = isinstance(values, tuple) and all(type(value) is int and value > 0 for value in values)
    if not whole or not values:
        raise ValueError(f"{name} must be a tuple of positive integers, got {values!r}")
