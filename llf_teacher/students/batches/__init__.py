"""Students in arrays: many learners of one kind, a row each. A student's are in the module of its name."""

import dataclasses
import importlib
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from llf_teacher.students.learner import Learner, LearnerPolicy
from llf_teacher.students.student import Student
from teachers.atoms import FN, FP, KINDS
from worlds.batches import Bools, Floats, Ints, Rows
from worlds.batches.streams import Streams

_FP, _FN = (1 << KINDS.index(kind) for kind in (FP, FN))
_NONE = -1


class LearnerBatch(ABC):
    """`LearnerPolicy` in arrays: each row draws from a stream of its own what a policy would.

    Args:
        spec: the student.
        rows: how many.
        states: what can be observed, numbered from 0.
        actions: number of actions.
        streams: what the rows draw from.
    """

    def __init__(self, spec: Learner, rows: int, states: int, actions: int, streams: Streams) -> None:
        self.spec, self.streams = spec, streams
        self.states, self.actions = states, actions
        self._drawn: dict[str, npt.NDArray[Any]] = {}
        self._own: dict[str, np.float64] = {}
        self.meant = np.full(rows, _NONE)
        """What is meant to be done in this turn; -1 where that is not known yet."""
        self._acted = np.zeros(rows, bool)

    def enrol(self, rows: Ints, drawn: Mapping[str, npt.NDArray[Any]]) -> None:
        """New students, with these parameters of their own."""
        for name, values in drawn.items():
            self._drawn.setdefault(name, np.zeros(len(self.meant), values.dtype))[rows] = values
        self.clear(rows)
        self.begin(rows)

    def parameter(self, name: str, rows: Rows) -> Any:
        """A parameter of the students of these rows: a number if it is the same for all."""
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
        """What these rows mean to do, given what each observes and the last reward."""
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
        """What these rows do, given the kinds that are said, the advised action and the one that is warned of."""
        actions = self.intend(rows, places, rewards)
        trust = np.broadcast_to(self.parameter("trust", rows), rows.shape)
        heeds = (trust > 0) & (kinds & (_FP | _FN) > 0)
        doubts = np.flatnonzero(heeds & (trust < 1))
        if len(doubts):
            heeds[doubts] = self.streams.random(rows[doubts]) < trust[doubts]
        told = kinds & _FP > 0
        actions = np.where(heeds & told, advised, actions)
        warns = np.flatnonzero(heeds & ~told & (actions == warned))
        if len(warns):
            actions[warns] = self.choose(rows[warns], places[warns], warned[warns])
        self.meant[rows] = _NONE
        self._acted[rows] = True
        self.take(rows, places, actions)
        return actions

    def finish(self, rows: Ints, places: Ints, rewards: Floats, terminated: Bools) -> None:
        """Learn from the last action of an episode."""
        acted = self._acted[rows]
        self.learn(rows[acted], places[acted], rewards[acted], terminated[acted])
        self._acted[rows] = False

    def teach(self, policy: LearnerPolicy[Any], row: int, turn: int, seen: Sequence[Any], here: int) -> None:
        """Let the policy of a student know what a row knows.

        Args:
            policy: one that has begun an episode.
            row: which.
            turn: turns of the episode so far.
            seen: what can be observed, by number.
            here: the number of what is observed now.
        """
        policy.rng = self.streams.stream(row)
        meant = int(self.meant[row])
        policy.go_on(turn, None if meant == _NONE else meant, bool(self._acted[row]))

    @abstractmethod
    def clear(self, rows: Ints) -> None:
        """Know nothing."""

    @abstractmethod
    def learn(self, rows: Ints, places: Ints, rewards: Floats, over: Bools) -> None:
        """`LearnerPolicy.learn`, where `places` are observed now."""

    @abstractmethod
    def choose(self, rows: Ints, places: Ints, wrong: Ints | None = None) -> Ints:
        """`LearnerPolicy.choose`, with at most one action in each row to be warned of."""

    @abstractmethod
    def take(self, rows: Ints, places: Ints, actions: Ints) -> None:
        """`LearnerPolicy.take`."""


def learners(spec: Student, rows: int, states: int, actions: int, streams: Streams) -> LearnerBatch:
    """Students in arrays.

    Raises:
        ValueError: they are none that can be played so.
    """
    if not spec.batch:
        from llf_teacher.students.parsing import STUDENTS

        able = ", ".join(name for name in STUDENTS.names if STUDENTS[name].batch)
        raise ValueError(f"the student {spec} cannot be played in arrays; allowed: {able}; others: TeacherEnv")
    module = importlib.import_module(f"{__name__}.{spec.name}")
    batch: LearnerBatch = getattr(module, spec.batch)(spec, rows, states, actions, streams)
    return batch
