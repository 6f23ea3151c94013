"""What may happen in an environment, as data."""

from collections.abc import Hashable, Mapping, Sequence
from typing import NamedTuple


class Transition(NamedTuple):
    """One thing that may happen after an action."""

    probability: float
    state: Hashable
    """The key of the next state; None if the episode ends."""
    reward: float


Transitions = Mapping[Hashable, Sequence[Sequence[Transition]]]
"""Per key of a state and number of an action, all that may happen; nothing in states in which an episode has ended."""
