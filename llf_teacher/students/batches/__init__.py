"""Students in arrays: many learners of one kind, a row each; each kind in the module of its name."""

import dataclasses
import importlib
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from llf_teacher.students.learner import Learner, LearnerPolicy
from llf_teacher.students.student import Student
from teachers.atoms import FN, FP, KINDS
from worlds.batches import Bools, Floats, Ints, Rows
from worlds.batches.streams import Streams

_FP, _FN = (1 << KINDS.index(kind) for kind in (FP, FN))
_NONE = -1


class LearnerBatch(ABC):
    """`LearnerPolicy` in arrays: each row draws from its own stream, as a policy would.

    Args:
        spec: the student.
        rows: number of rows.
        states: number of states; an observation is a state's number, from 0.
        actions: number of actions.
        streams: the random streams of the rows.
    """

    discrete = True
    """Whether actions are numbers; otherwise they are points of a box."""

    def __init__(self, spec: Learner, rows: int, states: int, actions: int, streams: Streams) -> None:
        self.spec, self.streams = spec, streams
        self.states, self.actions = states, actions
        self._drawn: dict[str, npt.NDArray[Any]] = {}
        self._own: dict[str, np.float64] = {}
        self.meant = np.full(rows, _NONE)
        """The intended action of each row, shape (rows,), int; -1 where it is not yet chosen."""
        self._acted = np.zeros(rows, bool)

    def enrol(self, rows: Ints, drawn: Mapping[str, npt.NDArray[Any]]) -> None:
        """Put new students into rows.

        Args:
            rows: their rows.
            drawn: values of the parameters that differ by student, each of shape (len(rows),).
        """
        for name, values in drawn.items():
            self._drawn.setdefault(name, np.zeros(len(self.meant), values.dtype))[rows] = values
        self.clear(rows)
        self.begin(rows)

    def parameter(self, name: str, rows: Rows) -> Any:
        """A parameter of the students of these rows: an array, or one number if it is the same for all."""
        return self._drawn[name][rows] if name in self._drawn else getattr(self.spec, name)

    def student(self, row: int) -> Learner:
        """The student of a row."""
        return dataclasses.replace(self.spec, **{name: values[row].item() for name, values in self._drawn.items()})

    def begin(self, rows: Ints) -> None:
        """Begin an episode."""
        if self.spec.forget:
            self.clear(rows)
        self.meant[rows] = _NONE
        self._acted[rows] = False

    def intend(self, rows: Ints, places: Ints, rewards: Floats) -> Ints:
        """The intended actions of rows.

        Args:
            rows: the rows, shape (n,); so are the others and the result.
            places: number of the state that each observes.
            rewards: the last rewards.
        """
        unsure = np.flatnonzero(self.meant[rows] == _NONE)
        if len(unsure):
            those, here = rows[unsure], places[unsure]
            acted = np.flatnonzero(self._acted[those])
            if len(acted):
                self.learn(those[acted], here[acted], rewards[unsure[acted]], np.zeros(len(acted), bool))
            self.meant[those] = self.choose(those, here)
        meant: Ints = self.meant[rows]
        return meant

    def act(self, rows: Ints, places: Ints, rewards: Floats, kinds: Ints, advised: Ints, warned: Ints) -> Ints:
        """The actions of rows; arguments of shape (n,), as of `intend`.

        Args:
            rows, places, rewards: see `intend`.
            kinds: bits of the kinds of feedback that are given; of hp and hn if they name the last action.
            advised: the advised actions, where there is advice.
            warned: the actions of warnings, where there is one.
        """
        actions = self.intend(rows, places, rewards)
        trust = np.broadcast_to(self.parameter("trust", rows), rows.shape)
        heeds = (trust > 0) & (kinds & (_FP | _FN) > 0)
        doubts = np.flatnonzero(heeds & (trust < 1))
        if len(doubts):
            heeds[doubts] = self.streams.random(rows[doubts]) < trust[doubts]
        advice = kinds & _FP > 0
        actions = np.where(heeds & advice, advised, actions)
        warns = np.flatnonzero(heeds & ~advice & (actions == warned))
        if len(warns):
            actions[warns] = self.choose(rows[warns], places[warns], warned[warns])
        self.meant[rows] = _NONE
        self._acted[rows] = True
        self.take(rows, places, actions)
        return actions

    def finish(self, rows: Ints, places: Ints, rewards: Floats, terminated: Bools, kinds: Ints) -> None:
        """Learn from the last action of an episode; `kinds` as of `act`."""
        acted = self._acted[rows]
        self.learn(rows[acted], places[acted], rewards[acted], terminated[acted])
        self._acted[rows] = False

    def teach(self, policy: LearnerPolicy[Any], row: int, turn: int, seen: Sequence[Any], here: int) -> None:
        """Copy the memory of a row into the policy of a student.

        Args:
            policy: a policy that has begun an episode.
            row: number of the row.
            turn: number of turns of the episode so far.
            seen: the observations, by the states' numbers.
            here: number of the current state.
        """
        policy.rng = self.streams.stream(row)
        meant = int(self.meant[row])
        policy.resume_at(turn, None if meant == _NONE else meant, bool(self._acted[row]))

    @abstractmethod
    def clear(self, rows: Ints) -> None:
        """Forget everything."""

    @abstractmethod
    def learn(self, rows: Ints, places: Ints, rewards: Floats, over: Bools) -> None:
        """`LearnerPolicy.learn`; `places` are the current states."""

    @abstractmethod
    def choose(self, rows: Ints, places: Ints, wrong: Ints | None = None) -> Ints:
        """`LearnerPolicy.choose`, with at most one wrong action in each row."""

    @abstractmethod
    def take(self, rows: Ints, places: Ints, actions: Ints) -> None:
        """`LearnerPolicy.take`."""


def learners(spec: Student, rows: int, states: int, space: spaces.Space[Any], streams: Streams) -> Any:
    """Students in arrays: a `LearnerBatch`, or another class with its methods.

    Raises:
        ValueError: the student has no version in arrays, or none for such actions.
    """
    if not spec.batch:
        from llf_teacher.students.parsing import STUDENTS

        able = ", ".join(name for name in STUDENTS.names if STUDENTS[name].batch)
        raise ValueError(f"the student {spec} cannot play in arrays; allowed: {able}; TeacherEnv takes any student")
    module = importlib.import_module(f"{__name__}.{spec.name}")
    batch = getattr(module, spec.batch)
    if batch.discrete != isinstance(space, spaces.Discrete):
        needed = "discrete actions" if batch.discrete else "actions in a box"
        raise ValueError(f"in arrays the student {spec} needs {needed}, got {space}; TeacherEnv takes any student")
    return batch(spec, rows, states, int(space.n) if isinstance(space, spaces.Discrete) else space, streams)
