"""What students have in common that learn from rewards, within an episode or over many, and can be advised."""

from abc import abstractmethod
from collections.abc import Collection
from dataclasses import dataclass
from typing import Any, TypeVar

from llf_teacher.students.student import Policy, Student, frozen
from teachers.atoms import FN, FP, action_of
from teachers.spec import check_range


@dataclass(frozen=True)
class Learner(Student):
    """Base of these students.

    An advised learner takes the advised action of the turn in place of its own choice, and never one it is warned of if
    it has another; it learns from what comes of the action, as from any other (Torrey & Taylor 2013).
    """

    trust: float = 0.0
    """Probability of following the advice for a turn, 0 to 1; 0: it reads rewards only."""
    forget: bool = True
    """Whether each episode starts from nothing, as it should where each is another world."""

    @property
    def reads(self) -> str:
        """`reward`, or `advice` as well."""
        return "atoms and reward" if self.trust else "reward"

    @property
    def remembers(self) -> bool:
        """Unless it is to forget."""
        return not self.forget

    def __post_init__(self) -> None:
        check_range("trust", self.trust, 0, 1)
        if not isinstance(self.forget, bool):
            raise ValueError(f"forget must be True or False, got {self.forget!r}")


L_co = TypeVar("L_co", bound=Learner, covariant=True)


class LearnerPolicy(Policy[L_co]):
    """Chooses, acts, learns from the reward when it is next asked or when the episode ends."""

    _knows = False

    def begin(self) -> None:
        """Have done nothing in this episode; forget the others if so specified."""
        if self.spec.forget or not self._knows:
            self.clear()
            self._knows = True
        self._turn = 0
        self._meant: Any = None
        self._acted = False

    def go_on(self, turn: int, meant: Any, acted: bool) -> None:
        """Be in the middle of an episode: after so many turns, with this in mind or None."""
        self._turn, self._meant, self._acted = turn, meant, acted

    def intend(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """What it means to do now unless it is advised; asked again in the same turn it says the same."""
        if self._meant is None:
            self.see(observation)
            if self._acted:
                self.learn(info["reward"], over=False)
            self._meant = self.choose()
        return self._meant

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """What it means to do, or what it is advised to."""
        action = self.intend(observation, info)
        if self.spec.trust:
            action = self._advised(action, info["atoms"])
        self._turn += 1
        self._meant, self._acted = None, True
        self.take(action)
        return action

    def finish(self, observation: dict[str, Any], info: dict[str, Any], terminated: bool) -> None:
        """Learn from the last action; after a terminal state nothing more can be had."""
        if self._acted:
            self.see(observation)
            self.learn(info["reward"], over=terminated)
            self._acted = False

    def _advised(self, action: Any, atoms: Collection[Any]) -> Any:
        """The action after hearing the advice for this turn."""
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
        """Know nothing."""

    def see(self, observation: dict[str, Any]) -> None:
        """Look at the state; those that learn about actions alone need not."""

    @abstractmethod
    def learn(self, reward: float, over: bool) -> None:
        """Learn from the reward of the action that was taken last, given the state that was seen last.

        Args:
            reward: the world's.
            over: whether that state is terminal.
        """

    @abstractmethod
    def choose(self, wrong: Collection[Any] = ()) -> Any:
        """The action of its own choice, other than those that it is warned of if that can be."""

    @abstractmethod
    def take(self, action: Any) -> None:
        """Take note of the action that is being taken, its own or an advised one."""
