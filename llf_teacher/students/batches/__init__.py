"""Students in arrays: many of one kind, a row each; each kind in the module of its name."""

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Generic, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from llf_teacher.students.learner import Learner, LearnerPolicy
from llf_teacher.students.scene import HeardBatch
from llf_teacher.students.student import Policy, Student
from teachers.atoms import FN, FP
from teachers.feedback import BIT
from worlds.batches import Bools, Floats, Ints, Rows
from worlds.batches.streams import Streams

_NONE = -1
S = TypeVar("S", bound=Student)


class Seats(NamedTuple):
    """Seats of students in arrays."""

    rows: int
    """Number of rows."""
    states: int
    """Number of states; an observation is a state's number, from 0."""
    space: spaces.Space[Any]
    """The space of the actions: a Discrete from 0, or for some students a Box of shape (n,)."""
    streams: Streams
    """The random streams of the rows; students draw from them like policies."""
    late: int = 0
    """The delay of all feedback, in turns."""

    @property
    def actions(self) -> int:
        """Number of actions of a Discrete."""
        return int(self.space.n)  # type: ignore[attr-defined]


class StudentBatch(ABC, Generic[S]):
    """The policies of students in arrays.

    Args:
        spec: the student.
        seats: where they play.
    """

    discrete: ClassVar[bool] = True
    """Whether actions are numbers; otherwise they are points of a box."""

    def __init__(self, spec: S, seats: Seats) -> None:
        self.spec = spec
        self.rows, self.states, _, self.streams, self.late = seats
        if self.discrete:
            self.actions = seats.actions
        self._drawn: dict[str, npt.NDArray[Any]] = {}

    def enrol(self, rows: Ints, drawn: Mapping[str, npt.NDArray[Any]]) -> None:
        """Put new students into rows.

        Args:
            rows: their rows.
            drawn: values of the parameters that differ between students, each of shape (len(rows),).
        """
        for name, values in drawn.items():
            self._drawn.setdefault(name, np.zeros(self.rows, values.dtype))[rows] = values
        self.renew(rows)

    def parameter(self, name: str, rows: Rows) -> Any:
        """A parameter of the students of these rows: an array, or a number if it is the same for all."""
        return self._drawn[name][rows] if name in self._drawn else getattr(self.spec, name)

    def student(self, row: int) -> S:
        """The student of a row."""
        return dataclasses.replace(self.spec, **{name: values[row].item() for name, values in self._drawn.items()})

    def begin(self, rows: Ints) -> None:
        """Begin an episode."""
        if self.spec.forget:  # type: ignore[attr-defined]  # every student in arrays has `forget`
            self.clear(rows)
        self.start(rows)

    def renew(self, rows: Ints) -> None:
        """Begin like a new student of its kind."""
        self.clear(rows)
        self.start(rows)

    def drawn_from(self, may: Bools, rows: Ints) -> Ints:
        """A random one of the allowed actions, shape (n, actions); column by column, as in `most`."""
        order = np.empty(may.shape, np.int64)
        count = np.zeros(len(rows), np.int64)
        for action in range(self.actions):
            count += may[:, action]
            order[:, action] = count
        place = self.streams.integers(count, rows)
        chosen = np.zeros(len(rows), np.int64)
        for action in range(self.actions - 1):
            chosen += order[:, action] <= place
        return chosen

    @abstractmethod
    def clear(self, rows: Ints) -> None:
        """Forget everything."""

    @abstractmethod
    def start(self, rows: Ints) -> None:
        """Begin an episode with what is remembered."""

    def intend(self, rows: Ints, places: Ints, rewards: Floats) -> Ints:
        """The announced actions of rows; arguments as in `act`. Only learners announce actions."""
        raise TypeError(f"{self.spec} announces nothing")

    @abstractmethod
    def act(self, rows: Ints, places: Ints, rewards: Floats, heard: HeardBatch) -> Ints:
        """The actions of rows.

        Args:
            rows: the rows, shape (n,); so are the others and the result.
            places: the number of each row's observed state.
            rewards: the last rewards.
            heard: what each row has heard since its last action.
        """

    @abstractmethod
    def take(self, rows: Ints, places: Ints, actions: Ints) -> None:
        """Note the actions of a turn; a second call in a turn replaces the first."""

    @abstractmethod
    def finish(self, rows: Ints, places: Ints, rewards: Floats, terminated: Bools, heard: HeardBatch) -> None:
        """Learn from the end of an episode; arguments as in `act`, and whether the states are terminal."""

    def lost(self, rows: Ints) -> Bools:
        """The states that cannot recur after `finish`, bool (len(rows), states); needed if new states can appear."""
        raise TypeError(f"{self.spec} loses no states")

    def forget(self, rows: Ints, lost: Bools, states: int) -> None:
        """Forget lost states; `states` is the number of states from now on."""
        raise TypeError(f"{self.spec} loses no states")

    @abstractmethod
    def teach(self, policy: Policy[Any], row: int, turn: int, seen: Sequence[Any], here: int) -> None:
        """Copy the memory of a row into the policy of a student.

        Args:
            policy: a policy that has begun an episode.
            row: number of the row.
            turn: number of turns of the episode so far.
            seen: the observations, by the states' numbers.
            here: number of the current state.
        """


class LearnerBatch(StudentBatch[Learner]):
    """`LearnerPolicy` in arrays; arguments as in the base class."""

    def __init__(self, spec: Learner, seats: Seats) -> None:
        super().__init__(spec, seats)
        self.meant = np.full(seats.rows, _NONE)
        """The intended action of each row, shape (rows,), int; -1 before it is chosen."""
        self._acted = np.zeros(seats.rows, bool)

    def start(self, rows: Ints) -> None:
        """Begin an episode with what is remembered."""
        self.meant[rows] = _NONE
        self._acted[rows] = False

    def intend(self, rows: Ints, places: Ints, rewards: Floats) -> Ints:
        """The intended actions of rows; arguments as in `act`."""
        unsure = np.flatnonzero(self.meant[rows] == _NONE)
        if len(unsure):
            those, here = rows[unsure], places[unsure]
            acted = np.flatnonzero(self._acted[those])
            if len(acted):
                self.learn(those[acted], here[acted], rewards[unsure[acted]], np.zeros(len(acted), bool))
            self.meant[those] = self.choose(those, here)
        meant: Ints = self.meant[rows]
        return meant

    def act(self, rows: Ints, places: Ints, rewards: Floats, heard: HeardBatch) -> Ints:
        """The intended actions, or the advised ones, unless the advice is late."""
        actions = self.intend(rows, places, rewards)
        kinds, advised, warned = heard
        trust = np.broadcast_to(self.parameter("trust", rows), rows.shape)
        heeds = (trust > 0) & (kinds & (BIT[FP] | BIT[FN]) > 0) & (not self.late)
        doubts = np.flatnonzero(heeds & (trust < 1))
        if len(doubts):
            heeds[doubts] = self.streams.random(rows[doubts]) < trust[doubts]
        advice = kinds & BIT[FP] > 0
        actions = np.where(heeds & advice, advised, actions)
        warns = np.flatnonzero(heeds & ~advice & (actions == warned))
        if len(warns):
            actions[warns] = self.choose(rows[warns], places[warns], warned[warns])
        self.meant[rows] = _NONE
        self._acted[rows] = True
        self.take(rows, places, actions)
        return actions

    def finish(self, rows: Ints, places: Ints, rewards: Floats, terminated: Bools, heard: HeardBatch) -> None:
        """Learn from the last action of an episode."""
        acted = self._acted[rows]
        self.learn(rows[acted], places[acted], rewards[acted], terminated[acted])
        self._acted[rows] = False

    def teach(self, policy: Policy[Any], row: int, turn: int, seen: Sequence[Any], here: int) -> None:
        """Copy the memory of a row; a subclass copies what it has learned."""
        assert isinstance(policy, LearnerPolicy)  # noqa: S101  # the policy of its student
        policy.rng = self.streams.stream(row)
        meant = int(self.meant[row])
        policy.resume_at(turn, None if meant == _NONE else meant, bool(self._acted[row]))

    @abstractmethod
    def learn(self, rows: Ints, places: Ints, rewards: Floats, over: Bools) -> None:
        """`LearnerPolicy.learn`; `places` are the current states."""

    @abstractmethod
    def choose(self, rows: Ints, places: Ints, wrong: Ints | None = None) -> Ints:
        """`LearnerPolicy.choose`, with at most one wrong action in each row."""
