"""Scenes: a trait's knowledge of an episode, also of many episodes in arrays."""

import dataclasses
from collections.abc import Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np

from llf_teacher.serialization import to_json
from pz_envs.text.actions import read_text
from teachers.atoms import Claim, claim
from worlds.batches import Bools, Ints
from worlds.batches.streams import Streams
from worlds.world import World

C = TypeVar("C", bound=Claim[Any])
_TRIES = 30


@claim
class BareSentence(Claim[Any]):
    """A sentence without a claim, such as a person's or a model's; only traits see it."""

    text: str


class Scene:
    """A trait's knowledge of an episode.

    Args:
        rng: its own random stream.
        world: a scratch world, for the rules.
        text: whether the student plays in text mode.
    """

    def __init__(self, rng: np.random.Generator, world: World[Any], text: bool) -> None:
        self.rng, self.world, self._text = rng, world, text
        self.memory: dict[str, Any] = {}
        """The trait's memory; empty when an episode begins."""
        self.turn = 0
        """The number of turns so far."""
        self.last: Any = None
        """The action of the last turn, in the student's form; None in the first."""
        self.listed: Sequence[Any] = ()
        """The actions that have an effect now, if the world lists them."""

    def happens(self, p: float) -> bool:
        """True with probability `p`."""
        return bool(self.rng.random() < p)

    def whole(self, number: float) -> int:
        """The number rounded up or down at random without bias: 1.25 is 2 with probability 0.25, else 1."""
        return int(number) + self.happens(number % 1)

    def another(self, action: Any) -> Any:
        """A random other legal action in canonical form; None if none is found.

        If the world lists the actions with an effect, it is one of these, if there are others.
        """
        for left in reversed(range(_TRIES)):
            listed = self.listed if left > _TRIES // 2 else ()
            drawn = listed[int(self.rng.integers(len(listed)))] if listed else self.world.sample_action(self.rng)
            if (found := self.world.legal(drawn)) != action:
                return found
        return None

    def meant(self, action: Any) -> Any:
        """An action of the student in canonical form; None if it is not an action."""
        try:
            return read_text(action, self.world) if self._text else self.world.legal(action)
        except ValueError:
            return None

    def as_given(self, action: Any) -> Any:
        """An action in canonical form as the student would give it."""
        return to_json(action) if self._text and not isinstance(action, str) else action


class HeardBatch(NamedTuple):
    """The claims that students hear, in arrays with a row per student."""

    kinds: Ints
    """The kinds of the claims, shape (rows,): bit i for kind i."""
    advised: Ints
    """The advised actions, shape (rows,); undefined without advice."""
    warned: Ints
    """The actions of warnings, likewise."""


class SceneBatch:
    """A trait's knowledge in arrays: a `Scene` in each row.

    Args:
        streams: its own random streams, one for each row.
        turns: the numbers of turns so far, shape (rows,).
        last: the actions of the last turn, shape (rows,).
        actions: number of actions.
    """

    def __init__(self, streams: Streams, turns: Ints, last: Ints, actions: int) -> None:
        self.streams, self._turns, self._last, self._actions = streams, turns, last, actions
        self.rows: Ints
        """The rows of this scene, shape (n,)."""

    @property
    def turn(self) -> Ints:
        """The numbers of turns so far, shape (n,)."""
        return self._turns[self.rows]

    @property
    def last(self) -> Ints:
        """The actions of the last turn, shape (n,); undefined in the first."""
        return self._last[self.rows]

    def happens(self, p: float, where: Bools) -> Bools:
        """True with probability `p` in the rows where `where` holds, shape (n,); the others draw nothing."""
        found = where.copy()
        found[where] = self.streams.random(self.rows[where]) < p
        return found

    def another(self, actions: Ints, where: Bools) -> Ints:
        """Random other actions in the rows where `where` holds, shape (n,); -1 if none is found."""
        found, left = np.full(len(actions), -1), np.flatnonzero(where)
        for _ in range(_TRIES):
            drawn = self.streams.integers(self._actions, self.rows[left])
            fits = drawn != actions[left]
            found[left[fits]] = drawn[fits]
            left = left[~fits]
        return found


def changed(claim: C, **fields: Any) -> C:
    """A claim with other values in some fields, and without its ground."""
    return dataclasses.replace(claim, **fields)  # type: ignore[type-var]  # claims are dataclasses
