"""The transitions of an environment, as data."""

from collections.abc import Hashable, Mapping, Sequence
from typing import NamedTuple


class Transition(NamedTuple):
    """One possible outcome of an action."""

    probability: float
    state: Hashable
    """The key of the next state; None if the episode ends."""
    reward: float


Transitions = Mapping[Hashable, Sequence[Sequence[Transition]]]
"""All outcomes, by key of a state and index of an action; none in states where an episode has ended."""
