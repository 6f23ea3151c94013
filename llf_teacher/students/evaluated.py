"""Base of students that learn from evaluation: from praise and blame of their actions, and from silence."""

from abc import abstractmethod
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar

import numpy as np
from gymnasium import spaces

from llf_teacher.students.student import Policy, Student, frozen, state_of
from pz_envs.subject import Subject
from teachers.atoms import HN, HP, ActionClaim
from teachers.common import Reward
from teachers.spec import Range
from worlds.world import World

Features = tuple[Hashable, ...]
"""The features of a state, each with weight 1: the state itself, or the tiles around it."""
_TILES = 8  # along each dimension
_DIMENSIONS = 4  # at most; with more, few tiles occur twice


@dataclass(frozen=True)
class Evaluated(Student):
    """Base of students that learn from evaluation. They need discrete actions; with tiles, nearby states share values.

    A verdict counts for the turn that it is about, and for the action of that turn, also if it comes turns later. Until
    then the turn counts as one of silence. Claims about another action, advice and warnings are not evaluation and are
    ignored.
    """

    forget: bool = True
    """Whether each episode starts without memory, as it should if each has another world."""
    tiles: Annotated[int, Range(0, 64)] = 0
    """Number of tilings of a bounded state, each shifted by a part of a tile (Sutton & Barto 2018, 9.5.4), 0 to 64."""


E_co = TypeVar("E_co", bound=Evaluated, covariant=True)


class EvaluatedPolicy(Policy[E_co]):
    """Acts, and learns from the evaluation in the next turn or at the end of the episode."""

    _started = False

    def __init__(self, spec: E_co, family: Subject, world: World[Any]) -> None:
        super().__init__(spec, family, world)
        self.actions = self.action_count
        self._tiling = Tiling(world.observation_space, spec.tiles) if spec.tiles else None

    def begin(self) -> None:
        """Begin an episode, without memory if the student forgets."""
        if self.spec.forget or not self._started:
            self.clear()
            self._started = True
        self.steps: list[tuple[Features, int]] = []
        """The states and actions of the episode, by turn."""

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> int:
        """Learn from the evaluation of the last action, then choose the next."""
        here = self._features(observation)
        self._evaluate(here, info, over=False)
        action = self.choose(here)
        self.steps.append((here, action))
        return action

    def resume_at(self, steps: Sequence[tuple[Features, int]]) -> None:
        """Continue in the middle of an episode, given its states and actions by turn."""
        self.steps = [*steps]

    def did(self, action: Any) -> None:
        """Note the action in place of the last one."""
        self.steps[-1] = self.steps[-1][0], int(action)

    def finish(self, observation: dict[str, Any], info: dict[str, Any], terminated: bool) -> None:
        """Learn from the evaluation of the last action."""
        if self.steps:
            self._evaluate(self._features(observation), info, over=terminated)
            self.end()
            self.steps = []

    def _features(self, observation: dict[str, Any]) -> Features:
        state = state_of(observation)
        return (frozen(state),) if self._tiling is None else self._tiling(state)

    def _evaluate(self, here: Features, info: dict[str, Any], over: bool) -> None:
        """Learn from late verdicts on earlier turns, then from the verdict on the last turn, or its absence."""
        turn = len(self.steps)
        if not turn:
            return
        words = dict(self._verdicts(info["atoms"]))
        last = words.pop(turn, 0.0)
        for number, label in sorted(words.items()):
            self.hear(number, label)
        self.hear(turn, last)
        self.learn(info, here, over)

    def _verdicts(self, atoms: Any) -> Iterator[tuple[int, float]]:
        """The turns of this episode that verdicts are about, each with its label: above 0 praise, below 0 blame."""
        labels: dict[int, float] = {}
        for atom in atoms:
            if 1 <= atom.about_turn <= len(self.steps):
                label = self.label(atom.claim, self.steps[atom.about_turn - 1][1])
                if label is not None:
                    labels[atom.about_turn] = labels.get(atom.about_turn, 0.0) + label
        yield from labels.items()

    def label(self, claim: Any, action: int) -> float | None:
        """The verdict of a claim on an action that was taken: 1 praise, -1 blame; None: no verdict."""
        if claim.kind in (HP, HN) and isinstance(claim, ActionClaim) and frozen(claim.action) == action:
            return 1.0 if claim.kind is HP else -1.0
        return None

    @abstractmethod
    def clear(self) -> None:
        """Forget everything."""

    @abstractmethod
    def choose(self, here: Features) -> int:
        """The next action."""

    @abstractmethod
    def hear(self, turn: int, label: float) -> None:
        """Learn from the label of a turn's action.

        Each turn is heard of when it is over, in order, and again if its label comes late.

        Args:
            turn: its number, from 1; its state and action are `steps[turn - 1]`.
            label: above 0 praise, below 0 blame, 0 silence; not 0 if it comes late.
        """

    def learn(self, info: dict[str, Any], here: Features, over: bool) -> None:
        """Learn from the outcome of the last action; by default nothing.

        Args:
            info: with the reward, for students that read rewards.
            here: the state after the action.
            over: whether that state is terminal.
        """

    def end(self) -> None:
        """Learn from an episode as a whole."""

    def best(self, scores: "np.ndarray") -> int:
        """An action of the greatest score, shape (actions,); ties are broken at random."""
        ties = np.flatnonzero(scores >= scores.max() - 1e-12)
        return int(ties[self.rng.integers(len(ties))] if len(ties) > 1 else ties[0])


class Table:
    """Numbers per feature and action; those of a state are the sums over its features.

    Args:
        actions: number of actions.
        start: the sum in a new state.
    """

    def __init__(self, actions: int, start: float = 0.0) -> None:
        self._actions, self._start = actions, start
        self._rows: dict[Hashable, np.ndarray] = {}

    def __call__(self, state: Features) -> np.ndarray:
        """The numbers of a state, shape (actions,)."""
        total = np.full(self._actions, self._start)
        for feature in state:
            if (row := self._rows.get(feature)) is not None:
                total += row
        return total

    def add(self, state: Features, change: Any, action: int | slice = slice(None)) -> None:
        """Add to the numbers of a state, in equal parts to its features.

        Args:
            state: its features.
            change: a number, or one per action, shape (actions,).
            action: the action whose number changes; all by default.
        """
        for feature in state:
            row = self._rows.setdefault(feature, np.zeros(self._actions))
            row[action] += change / len(state)


class Tiling:
    """Tile coding of a box: several grids, each shifted by another part of a tile.

    Args:
        space: the states.
        count: number of grids.

    Raises:
        ValueError: the space is not a bounded box of at most four dimensions.
    """

    def __init__(self, space: spaces.Space[Any], count: int) -> None:
        if not isinstance(space, spaces.Box) or not space.is_bounded() or space.low.size > _DIMENSIONS:
            raise ValueError(
                f"tiles are for states in a bounded box of at most {_DIMENSIONS} dimensions, got {space}; give tiles=0"
            )
        self._low = space.low.astype(float).ravel()
        self._scale = _TILES / (space.high.astype(float).ravel() - self._low)
        odd = 2 * np.arange(len(self._low)) + 1  # the shifts differ by dimension, as Sutton & Barto advise
        self._shift = np.arange(count)[:, None] * odd / count % 1

    def __call__(self, state: Any) -> Features:
        """The tiles of a state, one per grid."""
        at = (np.asarray(state, float).ravel() - self._low) * self._scale
        tiles = np.floor(at + self._shift).astype(int)
        return tuple((number, *tile) for number, tile in enumerate(tiles.tolist()))


def stated_reward(claim: Any) -> float | None:
    """The reward that a claim states; None if it states none."""
    return float(claim.reward) if type(claim) is Reward else None


def softmax(scores: np.ndarray) -> np.ndarray:
    """Probabilities in proportion to the exponentials of the scores, shape (actions,)."""
    weights = np.exp(scores - scores.max())
    return np.asarray(weights / weights.sum())
