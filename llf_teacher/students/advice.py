"""Base of students that follow advice, from atoms or from words."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from llf_teacher.students.student import Policy, Student, frozen, state_of
from teachers.atoms import FP, HN, HP, FeedbackType

_TRIES = 30


@dataclass(frozen=True)
class Believer(Student):
    """Base of students that believe what the teacher says."""

    forget: bool = True
    """Whether each episode starts without memory; use it if each has another world."""


B_co = TypeVar("B_co", bound=Believer, covariant=True)


class AdviceTaker(Policy[B_co]):
    """Remembers for each state which actions were called right or wrong.

    It takes the action that was last called right in the state. Without one it follows the plan; without a plan it
    tries a random action that was not called wrong. The latest claim about an action counts.
    """

    _started = False

    def begin(self) -> None:
        """Begin an episode, with the memory of earlier ones unless the student forgets."""
        if self.spec.forget or not self._started:
            self._right: dict[Any, dict[Any, Any]] = {}
            self._wrong: dict[Any, dict[Any, Any]] = {}
            self._started = True
        self._states: list[Any] = []
        self._plan: Sequence[Any] = ()
        self._endless = False

    def recall(self, right: dict[Any, dict[Any, Any]], turn: int, last: Any) -> None:
        """Take over memory and history from elsewhere at the beginning of an episode.

        Args:
            right: for each state the actions believed to be right, the latest last.
            turn: number of turns of the episode so far.
            last: the state before the last turn.
        """
        self._right, self._wrong = right, {}
        self._states = [last] * turn

    def arrive(self, observation: dict[str, Any]) -> int:
        """Add the state to the history; returns the number of turns so far."""
        self._states.append(frozen(state_of(observation)))
        return len(self._states) - 1

    def hear(self, kind: FeedbackType | None, actions: Sequence[Any], turn: int, endless: bool = False) -> None:
        """Learn from a claim about actions: feedback is about the first one, an instruction is a plan for all turns."""
        if kind is None:
            self.follow(actions, endless)
        else:
            self.learn(kind, actions[0], turn)

    def learn(self, kind: FeedbackType, action: Any, turn: int) -> None:
        """Learn from a claim about an action: advice is about the state after `turn`, hindsight about the one before.

        Hindsight at the opening is about another student's turns, in unknown states.
        """
        before = turn - 1 if kind in (HP, HN) else turn
        if 0 <= before < len(self._states):
            state, key = self._states[before], frozen(action)
            verdicts, others = (self._right, self._wrong) if kind in (HP, FP) else (self._wrong, self._right)
            others.get(state, {}).pop(key, None)
            mine = verdicts.setdefault(state, {})
            mine.pop(key, None)  # reinserted as the latest
            mine[key] = action

    def follow(self, actions: Sequence[Any], endless: bool = False) -> None:
        """Take these actions as the plan from the first turn on; an endless plan repeats its last action."""
        self._plan, self._endless = actions, endless

    def decide(self) -> Any:
        """The next action."""
        state = self._states[-1]
        if right := self._right.get(state):
            return next(reversed(right.values()))
        turn = len(self._states) - 1
        if turn < len(self._plan) or (self._endless and self._plan):
            return self._plan[min(turn, len(self._plan) - 1)]
        wrong = self._wrong.get(state, {})
        for _ in range(_TRIES):
            action = self.world.sample_action(self.rng)
            if not wrong or frozen(self.world.legal(action)) not in wrong:  # claims have the canonical form
                break
        return action
