"""Students with traits in arrays."""

import importlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from llf_teacher.students import batches
from llf_teacher.students.batches import Seats, StudentBatch
from llf_teacher.students.parsing import STUDENTS, TRAITS
from llf_teacher.students.scene import HeardBatch, SceneBatch
from llf_teacher.students.student import Policy, Student
from llf_teacher.students.trait import Trait, traits_of
from teachers.spec import fits
from worlds.batches import Bools, Floats, Ints
from worlds.batches.streams import Streams


class TraitedBatch(StudentBatch[Student]):
    """Claims pass the traits from left to right, then the students act, and their actions pass the traits, too.

    Args:
        spec: the student with its traits.
        traits: the traits, each with a form in arrays.
        inner: the students without traits.
        seats: the seats of the students.
    """

    def __init__(self, spec: Student, traits: Sequence[Trait], inner: StudentBatch[Any], seats: Seats) -> None:
        super().__init__(spec, seats)
        self.inner = inner
        self._turns, self._since, self._last, self._asked = (np.zeros(seats.rows, np.int64) for _ in range(4))
        scenes = [
            SceneBatch(Streams(np.zeros(seats.rows, np.uint64)), self._turns, self._last, seats.actions) for _ in traits
        ]
        self._parts = [*zip(traits, scenes, strict=True)]

    def enrol(self, rows: Ints, drawn: Mapping[str, npt.NDArray[Any]]) -> None:
        """Put new students into rows."""
        self.inner.enrol(rows, drawn)
        self.start(rows)

    def student(self, row: int) -> Student:
        """The student of a row."""
        return self.spec  # students with traits do not vary

    def begin(self, rows: Ints) -> None:
        """Begin an episode."""
        self.inner.begin(rows)
        self.start(rows)

    def clear(self, rows: Ints) -> None:
        """Forget everything."""
        self.inner.clear(rows)

    def start(self, rows: Ints) -> None:
        """Begin an episode; each trait gets one of the streams from `streams_beside`."""
        self._turns[rows] = self._since[rows] = self._asked[rows] = 0
        for number, (_, scene) in enumerate(self._parts):
            scene.streams.states[rows] = self.streams.beside(1 + number, rows)  # the first stream is for words

    def act(self, rows: Ints, places: Ints, rewards: Floats, heard: HeardBatch) -> Ints:
        """The actions after all traits."""
        self._forget(rows)
        actions = self.inner.act(rows, places, rewards, self._through(rows, heard))
        for trait, scene in self._parts:
            actions = trait.act_rows(actions, scene)
        self.take(rows, places, actions)
        self._turns[rows] += 1
        return actions

    def intend(self, rows: Ints, places: Ints, rewards: Floats) -> Ints:
        """The actions that the students intend, before their traits change what they hear and do."""
        self._forget(rows)
        return self.inner.intend(rows, places, rewards)

    def _forget(self, rows: Ints) -> None:
        """Begin with a new student in rows where a trait forgets in this turn; the first turn asks none."""
        rows = rows[self._asked[rows] < self._turns[rows]]
        self._asked[rows] = self._turns[rows]
        forgets = np.zeros(len(rows), bool)
        for trait, scene in self._parts:
            scene.rows = rows
            forgets |= trait.forgets_rows(scene)
        anew = rows[forgets]
        if len(anew):
            self.inner.renew(anew)
            self._since[anew] = self._turns[anew]

    def _through(self, rows: Ints, heard: HeardBatch) -> HeardBatch:
        """The claims after the traits."""
        for trait, scene in self._parts:
            scene.rows = rows
            heard = trait.hear_rows(heard, scene)
        return heard

    def take(self, rows: Ints, places: Ints, actions: Ints) -> None:
        """Note the actions of a turn."""
        self._last[rows] = actions
        self.inner.take(rows, places, actions)

    def finish(self, rows: Ints, places: Ints, rewards: Floats, terminated: Bools, heard: HeardBatch) -> None:
        """Pass the last words through the traits to the students."""
        self.inner.finish(rows, places, rewards, terminated, self._through(rows, heard))

    def teach(self, policy: Policy[Any], row: int, turn: int, seen: Sequence[Any], here: int) -> None:
        """Copy the memory of a row."""
        since = int(self._since[row])
        self.inner.teach(policy.inner, row, turn - since, seen, here)  # type: ignore[attr-defined]  # of traits
        streams = [scene.streams.stream(row) for _, scene in self._parts]
        policy.resume_at(turn, since, int(self._asked[row]), int(self._last[row]), streams)  # type: ignore[attr-defined]  # likewise


def students(spec: Student, seats: Seats) -> StudentBatch[Any]:
    """Students in arrays.

    Raises:
        ValueError: the student or one of its traits has no form in arrays, or none for such actions.
    """
    bare, traits = traits_of(spec)
    if not _in_arrays(type(bare)):
        able = ", ".join(name for name in STUDENTS.names if _in_arrays(STUDENTS[name]))
        raise ValueError(f"the student {bare} cannot play in arrays; allowed: {able}; TeacherEnv takes any student")
    for trait in traits:
        if not trait.in_arrays():
            able = ", ".join(name for name in TRAITS.names if TRAITS[name].in_arrays())
            raise ValueError(f"the trait {trait} cannot play in arrays; allowed: {able}; TeacherEnv takes any trait")
    module = importlib.import_module(f"{batches.__name__}.{bare.name}")
    batch: type[StudentBatch[Any]] = getattr(module, bare.batch)
    if batch.discrete != isinstance(seats.space, spaces.Discrete):
        needed = "discrete actions" if batch.discrete else "actions in a box"
        raise ValueError(
            f"in arrays the student {bare} needs {needed}, got {seats.space}; TeacherEnv takes any student"
        )
    if traits and not batch.discrete:
        raise ValueError(f"in arrays traits need discrete actions, got {spec}; TeacherEnv takes any student")
    return TraitedBatch(spec, traits, batch(bare, seats), seats) if traits else batch(bare, seats)


def _in_arrays(cls: type[Student]) -> bool:
    return cls.batch != "" and fits(cls, "batch", "policy")
