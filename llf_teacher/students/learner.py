"""Base of students that learn from rewards, within an episode or over several, and can take advice."""

from abc import abstractmethod
from collections.abc import Collection
from dataclasses import dataclass
from typing import Any, TypeVar

from llf_teacher.students.student import Policy, Student, frozen
from teachers.atoms import FN, FP, action_of
from teachers.spec import Share


@dataclass(frozen=True)
class Learner(Student):
    """Base of students that learn from rewards.

    A learner with trust takes the turn's advised action instead of its own choice, and avoids the actions of warnings
    if it can; it learns from the outcome as from that of its own actions (Torrey & Taylor 2013).
    """

    trust: Share = 0.0
    """Probability of following the advice for a turn, 0 to 1; 0: it reads rewards only."""
    forget: bool = True
    """Whether each episode starts without memory; use it if each has another world."""

    @property
    def reads(self) -> str:
        """`reward`, or `atoms and reward` with trust."""
        return "atoms and reward" if self.trust else "reward"


L_co = TypeVar("L_co", bound=Learner, covariant=True)


class LearnerPolicy(Policy[L_co]):
    """Chooses, acts, and learns from the reward in the next turn or at the end of the episode."""

    _started = False

    def begin(self) -> None:
        """Begin an episode, without memory if the student forgets."""
        if self.spec.forget or not self._started:
            self.clear()
            self._started = True
        self._turn = 0
        self._meant: Any = None
        self._acted = False

    def resume_at(self, turn: int, meant: Any, acted: bool) -> None:
        """Continue in the middle of an episode.

        Args:
            turn: number of turns so far.
            meant: the action that it intends; None if it has not chosen.
            acted: whether it has acted since it last learned.
        """
        self._turn, self._meant, self._acted = turn, meant, acted

    def intend(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """Its action without advice; repeated calls in a turn give the same action."""
        if self._meant is None:
            self.see(observation)
            if self._acted:
                self.learn(info["reward"], over=False)
            self._meant = self.choose()
        return self._meant

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """The intended action, or the advised one."""
        action = self.intend(observation, info)
        if self.spec.trust:
            action = self._advised(action, info["atoms"])
        self._turn += 1
        self._meant, self._acted = None, True
        self.take(action)
        return action

    def did(self, action: Any) -> None:
        """Note the action, which replaces the last one."""
        self.take(action)

    def finish(self, observation: dict[str, Any], info: dict[str, Any], terminated: bool) -> None:
        """Learn from the last action; the value of a terminal state is 0."""
        if self._acted:
            self.see(observation)
            self.learn(info["reward"], over=terminated)
            self._acted = False

    def _advised(self, action: Any, atoms: Collection[Any]) -> Any:
        """The action after the advice for this turn."""
        said = [atom for atom in atoms if atom.kind in (FP, FN) and atom.about_turn == self._turn]
        advice = [(atom.kind, about) for atom in said if (about := action_of(atom.claim)) is not None]
        if not advice or (self.spec.trust < 1 and self.rng.random() >= self.spec.trust):
            return action
        for kind, better in advice:
            if kind == FP:
                return better
        wrong = {frozen(worse) for _, worse in advice}
        return self.choose(wrong) if frozen(action) in wrong else action

    @abstractmethod
    def clear(self) -> None:
        """Forget everything."""

    def see(self, observation: dict[str, Any]) -> None:
        """Take in the state; learners that ignore states need not."""

    @abstractmethod
    def learn(self, reward: float, over: bool) -> None:
        """Learn from the reward of the last action, given the latest state.

        Args:
            reward: the world's reward.
            over: whether the latest state is terminal.
        """

    @abstractmethod
    def choose(self, wrong: Collection[Any] = ()) -> Any:
        """Its own choice of an action, if possible not a wrong one."""

    @abstractmethod
    def take(self, action: Any) -> None:
        """Note its action, chosen or advised; a second call in a turn replaces the first."""
