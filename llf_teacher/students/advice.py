"""What a student that follows advice has in common, however it comes to know the advice."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from llf_teacher.students.student import Policy, Student, frozen, state_of
from teachers.atoms import FP, HN, HP, FeedbackType

_TRIES = 30


@dataclass(frozen=True)
class Believer(Student):
    """Base of these students."""

    forget: bool = True
    """Whether each episode starts from nothing, as it should where each is another world."""

    @property
    def remembers(self) -> bool:
        """Unless it is to forget."""
        return not self.forget

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.forget, bool):
            raise ValueError(f"forget must be True or False, got {self.forget!r}")


B_co = TypeVar("B_co", bound=Believer, covariant=True)


class AdviceTaker(Policy[B_co]):
    """Remembers per state which actions were called right or wrong, and acts on it.

    It takes the action that was last called right in this state; without one it follows a plan that the
    instruction gave; without that it tries at random what was not called wrong. The latest word counts.
    """

    _knows = False

    def begin(self) -> None:
        """Know nothing, or what was called right or wrong in earlier episodes."""
        if self.spec.forget or not self._knows:
            self._right: dict[Any, dict[Any, Any]] = {}
            self._wrong: dict[Any, dict[Any, Any]] = {}
            self._knows = True
        self._states: list[Any] = []
        self._plan: Sequence[Any] = ()
        self._endless = False

    def arrive(self, observation: dict[str, Any]) -> int:
        """Note the state; the number of turns so far."""
        self._states.append(frozen(state_of(observation)))
        return len(self._states) - 1

    def hear(self, kind: FeedbackType | None, actions: Sequence[Any], turn: int, endless: bool = False) -> None:
        """Take a claim about actions to heart: the first of them if it is feedback, else a plan for all turns."""
        if kind is None:
            self.follow(actions, endless)
        else:
            self.learn(kind, actions[0], turn)

    def learn(self, kind: FeedbackType, action: Any, turn: int) -> None:
        """Take a claim about an action to heart: advice is about the state after `turn`, hindsight about that before.

        Hindsight at the opening speaks of somebody else's turns, in states that this student cannot tell.
        """
        before = turn - 1 if kind in (HP, HN) else turn
        if 0 <= before < len(self._states):
            state, key = self._states[before], frozen(action)
            verdicts, others = (self._right, self._wrong) if kind in (HP, FP) else (self._wrong, self._right)
            others.get(state, {}).pop(key, None)
            mine = verdicts.setdefault(state, {})
            mine.pop(key, None)  # so that it counts as the latest
            mine[key] = action

    def follow(self, actions: Sequence[Any], endless: bool = False) -> None:
        """Plan to take these actions from the start; an endless plan goes on with its last action."""
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
