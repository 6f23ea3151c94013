"""What students have in common that learn from evaluation: from praise and blame of what they did, and from silence."""

from abc import abstractmethod
from collections.abc import Hashable, Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from gymnasium import spaces

from llf_teacher.students.student import Policy, Student, frozen, state_of
from pz_envs.subject import Subject
from teachers.atoms import HN, HP, ActionClaim
from teachers.common import Reward
from teachers.spec import check_range
from worlds.world import World

Features = tuple[Hashable, ...]
"""What is there in a state, each with weight 1: the state itself, or the tiles that it lies in."""
_TILES = 8  # along each dimension
_DIMENSIONS = 4  # beyond which few tiles are met twice


@dataclass(frozen=True)
class Evaluated(Student):
    """Base of these students. They need discrete actions, and judge a state by itself or, with tiles, by what is near.

    A verdict counts for the turn that it is about, and for the action that was taken in it; a claim about another
    action, advice and warnings are not evaluation and are not heard.
    """

    forget: bool = True
    """Whether each episode starts from nothing, as it should where each is another world."""
    tiles: int = 0
    """Tilings of a bounded state, each shifted by a part of a tile (Sutton & Barto 2018, 9.5.4), 0 to 64; 0: none."""

    def __post_init__(self) -> None:
        if not isinstance(self.forget, bool):
            raise ValueError(f"forget must be True or False, got {self.forget!r}")
        if type(self.tiles) is not int or not 0 <= self.tiles <= 64:
            raise ValueError(f"tiles must be an integer from 0 to 64, got {self.tiles!r}")


E_co = TypeVar("E_co", bound=Evaluated, covariant=True)


class EvaluatedPolicy(Policy[E_co]):
    """Acts, hears what is said of it, and learns when it is next asked or when the episode ends."""

    _knows = False

    def __init__(self, spec: E_co, family: Subject, world: World[Any]) -> None:
        super().__init__(spec, family, world)
        self.actions = self.action_count
        self._tiling = Tiling(world.observation_space, spec.tiles) if spec.tiles else None

    def begin(self) -> None:
        """Have done nothing in this episode; forget the others if so specified."""
        if self.spec.forget or not self._knows:
            self.clear()
            self._knows = True
        self.lived: list[tuple[Features, int]] = []
        """What was done in which state, by turns."""

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> int:
        """Learn from what is said of the last action; then the next one."""
        here = self._features(observation)
        self._take_in(here, info, over=False)
        action = self.choose(here)
        self.lived.append((here, action))
        return action

    def finish(self, observation: dict[str, Any], info: dict[str, Any], terminated: bool) -> None:
        """Learn from what is said of the last action of all."""
        if self.lived:
            self._take_in(self._features(observation), info, over=terminated)
            self.end()
            self.lived = []

    def _features(self, observation: dict[str, Any]) -> Features:
        state = state_of(observation)
        return (frozen(state),) if self._tiling is None else self._tiling(state)

    def _take_in(self, here: Features, info: dict[str, Any], over: bool) -> None:
        """Learn from late words on earlier turns, then from the last turn, about which there may have been silence."""
        turn = len(self.lived)
        if not turn:
            return
        words = dict(self._verdicts(info["atoms"]))
        last = words.pop(turn, 0.0)
        for number, label in sorted(words.items()):
            self.hear(*self.lived[number - 1], label)
        self.hear(*self.lived[-1], last)
        self.live(info, here, over)

    def _verdicts(self, atoms: Any) -> Iterator[tuple[int, float]]:
        """Per turn of this episode that something is said about, the label: more praise or more blame."""
        labels: dict[int, float] = {}
        for atom in atoms:
            if 1 <= atom.about_turn <= len(self.lived):
                label = self.label(atom.claim, self.lived[atom.about_turn - 1][1])
                if label is not None:
                    labels[atom.about_turn] = labels.get(atom.about_turn, 0.0) + label
        yield from labels.items()

    def label(self, claim: Any, action: int) -> float | None:
        """What a claim says of an action that was taken: 1 praise, -1 blame; None: nothing."""
        if claim.kind in (HP, HN) and isinstance(claim, ActionClaim) and frozen(claim.action) == action:
            return 1.0 if claim.kind is HP else -1.0
        return None

    @abstractmethod
    def clear(self) -> None:
        """Know nothing."""

    @abstractmethod
    def choose(self, here: Features) -> int:
        """The next action."""

    @abstractmethod
    def hear(self, state: Features, action: int, label: float) -> None:
        """Learn from what was said of an action in a state: above 0 praise, below 0 blame, 0 silence."""

    def live(self, info: dict[str, Any], here: Features, over: bool) -> None:
        """Learn from what became of the last action; those that learn from evaluation alone need not.

        Args:
            info: with the reward, for those that read rewards.
            here: the state that it led to.
            over: whether that is terminal.
        """

    def end(self) -> None:
        """Learn from an episode as a whole."""

    def best(self, scores: "np.ndarray") -> int:
        """A greatest score; ties are broken at random."""
        ties = np.flatnonzero(scores >= scores.max() - 1e-12)
        return int(ties[self.rng.integers(len(ties))] if len(ties) > 1 else ties[0])


class Table:
    """Numbers per feature and action; those of a state are the sums over its features.

    Args:
        actions: number of actions.
        start: the sum in a state that nothing is known of.
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
        """Change the numbers of a state by so much, each of its features having an equal share.

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
        space: of the states.
        count: number of grids.

    Raises:
        ValueError: the space is no bounded box of at most four dimensions.
    """

    def __init__(self, space: spaces.Space[Any], count: int) -> None:
        if not isinstance(space, spaces.Box) or not space.is_bounded() or space.low.size > _DIMENSIONS:
            raise ValueError(
                f"tiles are for states in a bounded box of at most {_DIMENSIONS} dimensions, got {space}; give tiles=0"
            )
        self._low = space.low.astype(float).ravel()
        self._scale = _TILES / (space.high.astype(float).ravel() - self._low)
        odd = 2 * np.arange(len(self._low)) + 1  # shifts that differ by dimension, as the book advises
        self._shift = np.arange(count)[:, None] * odd / count % 1

    def __call__(self, state: Any) -> Features:
        """The tiles in which a state lies, one a grid."""
        at = (np.asarray(state, float).ravel() - self._low) * self._scale
        tiles = np.floor(at + self._shift).astype(int)
        return tuple((number, *tile) for number, tile in enumerate(tiles.tolist()))


def stated_reward(claim: Any) -> float | None:
    """The reward that a claim tells; None if it tells none."""
    return float(claim.reward) if type(claim) is Reward else None


def softmax(scores: np.ndarray) -> np.ndarray:
    """Probabilities that grow as the exponential of the scores."""
    weights = np.exp(scores - scores.max())
    return np.asarray(weights / weights.sum())


def check_shares(student: Any, *names: str) -> None:
    """Make sure that these parameters lie from 0 to 1."""
    for name in names:
        check_range(name, getattr(student, name), 0, 1)
