"""The state of a whole environment as one array of numbers, for centralised critics; it is privileged."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from pz_envs.numbers import Field, Numbers, finite
from pz_envs.student_view import StudentView
from pz_envs.teacher_view import SUBSET_BITS, TeacherView
from teachers.atoms import KINDS

__all__ = ["GlobalState", "Seated", "Shared"]

_MOST = float(np.finfo(np.float32).max)


class Seated(NamedTuple):
    """A student with its teachers."""

    student: str
    """The agent."""
    view: StudentView
    teachers: Mapping[str, TeacherView]
    """The view of each teacher, by agent."""


class Shared(NamedTuple):
    """A number from 0 to 1 about the whole environment."""

    name: str
    meaning: str
    value: float


class GlobalState:
    """Writes the state of an environment: `fields` says what each number is, `space` has the bounds.

    First `acts`, the selected agent; then, for each student, its observation in numbers (`pz_envs.numbers`), its last
    turn, the oracle's values of its world, and what its teachers can say; then the numbers of the seating. Texts are
    left out, unless the settings `embed` them.

    Args:
        agents: all agents.
        seated: the students.
        shared: numbers of the seating, with their present values.
    """

    def __init__(self, agents: Sequence[str], seated: Sequence[Seated], shared: Sequence[Shared]) -> None:
        self._agents, self._seated = tuple(agents), tuple(seated)
        self._fields: list[Field] = []
        self._low: list[float] = []
        self._high: list[float] = []
        self._add("acts", f"a 1 among zeros for the selected agent: {', '.join(agents)}; zeros at the end", len(agents))
        self._numbers = []
        for student, view, teachers in self._seated:
            session = view.session
            numbers = Numbers(session.world, session.max_turns, view.embed, lenient=True)
            self._numbers.append(numbers)
            start = len(self._low)
            for name, place, meaning in numbers.fields:
                self._fields.append(Field(f"{student}.{name}", slice(place.start + start, place.stop + start), meaning))
            self._low += numbers.least.tolist()
            self._high += numbers.greatest.tolist()
            oracle = session.teacher.oracle
            low, high = session.world.reward_range
            self._add(f"{student}.here", "1 until its episode has ended, else 0")
            self._add(f"{student}.success", "1 if its task is done, else 0")
            self._add(f"{student}.reward", "the reward of its last turn", 1, min(low, 0.0), max(high, 0.0))
            self._add(f"{student}.importance", "what is at stake in its next action", 1, 0.0, oracle.max_importance)
            if _has_values(view):
                count = int(session.world.action_space.n)  # type: ignore[attr-defined]  # the space is Discrete
                meaning = "the value of each action now, by the oracle; zeros when the episode is over"
                self._add(f"{student}.values", meaning, count, -_MOST, _MOST)
            for teacher in teachers:
                kinds = ", ".join(KINDS)
                self._add(f"{student}.{teacher}.available", f"1 for each kind that it can say: {kinds}", len(KINDS))
                self._add(f"{student}.{teacher}.budget", "share of its budget that is left; 1 without a budget")
        for each in shared:
            self._add(each.name, each.meaning)
        self.fields = tuple(self._fields)
        """The fields, in their order."""
        self._least, self._greatest = finite(np.array(self._low)), finite(np.array(self._high))
        self.space = spaces.Box(self._least, self._greatest, dtype=np.float32)
        """The space of the states."""

    def of(self, selected: str, present: Sequence[str], shared: Sequence[Shared]) -> npt.NDArray[np.float32]:
        """The state, float32 of the shape of `space`.

        Args:
            selected: the agent that acts next.
            present: the agents that have not ended.
            shared: as in the class.
        """
        numbers: list[float] = [float(agent == selected and agent in present) for agent in self._agents]
        for (student, view, teachers), writer in zip(self._seated, self._numbers, strict=True):
            session = view.session
            moment, oracle = session.moment, session.teacher.oracle
            words = session.instruction, session.feedback
            numbers += writer.of(session.state, moment.turn, *words, session.atoms).tolist()
            importance = 0.0 if moment.over else oracle.importance(moment.after)
            numbers += (student in present, moment.success, moment.reward, importance)
            if _has_values(view):
                values = None if moment.over else oracle.values(moment.after)
                numbers += values or [0.0] * int(session.world.action_space.n)  # type: ignore[attr-defined]
            for teacher in teachers.values():
                numbers += SUBSET_BITS[teacher.teacher_turn.available()].tolist()
                numbers.append(teacher.teacher_turn.budget.share)
        numbers += [each.value for each in shared]
        array = np.array(numbers, float)
        state: npt.NDArray[np.float32] = np.clip(array, self._least, self._greatest).astype(np.float32)
        return state

    def _add(self, name: str, meaning: str, size: int = 1, low: float = 0.0, high: float = 1.0) -> None:
        start = len(self._low)
        self._fields.append(Field(name, slice(start, start + size), meaning))
        self._low += [low] * size
        self._high += [high if high > low else low + 1.0] * size


def _has_values(view: StudentView) -> bool:
    """Whether the oracle values each of finitely many actions."""
    session = view.session
    return "values" in session.teacher.oracle.abilities() and isinstance(session.world.action_space, spaces.Discrete)
