"""tamer: predicts the praise of each action, and takes the action with the most."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from llf_teacher.students.student import Policy, Student, frozen, state_of
from llf_teacher.students.tables import Features, Table, Tiling
from pz_envs.subject import Subject
from teachers.atoms import HN, HP, ActionClaim
from teachers.spec import Range, Share
from worlds.world import World


class _Policy(Policy["Tamer"]):
    """A table of expected labels."""

    _started = False

    def __init__(self, spec: "Tamer", family: Subject, world: World[Any]) -> None:
        super().__init__(spec, family, world)
        self._actions = self.action_count
        self._tiling = Tiling(world.observation_space, spec.tiles) if spec.tiles else None

    def begin(self) -> None:
        """Begin an episode, without memory if the student forgets."""
        if self.spec.forget or not self._started:
            self._human = Table(self._actions)
            self._started = True
        self.steps: list[tuple[Features, int]] = []
        """The states and actions of the episode, by turn."""

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> int:
        """Learn from the verdicts since the last action, then take an action of the greatest prediction.

        Labels are not summed like rewards, so the horizon is one action. Ties are broken at random.
        """
        self._learn(info["atoms"])
        state = state_of(observation)
        here = (frozen(state),) if self._tiling is None else self._tiling(state)
        predictions = self._human(here)
        ties = np.flatnonzero(predictions >= predictions.max() - 1e-12)
        action = int(ties[self.rng.integers(len(ties))] if len(ties) > 1 else ties[0])
        self.steps.append((here, action))
        return action

    def did(self, action: Any) -> None:
        """Note the action, which replaces the last one."""
        self.steps[-1] = self.steps[-1][0], int(action)

    def finish(self, observation: dict[str, Any], info: dict[str, Any], terminated: bool) -> None:
        """Learn from the verdicts since the last action."""
        self._learn(info["atoms"])
        self.steps = []

    def resume_at(self, steps: Sequence[tuple[Features, int]]) -> None:
        """Continue in the middle of an episode, given its states and actions by turn."""
        self.steps = [*steps]

    def recall(self, table: Mapping[Hashable, NDArray[np.float64]]) -> None:
        """Take over a memory: predictions per state, shape (actions,)."""
        for state, row in table.items():
            self._human.add((state,), row)

    def hear(self, turn: int, label: float) -> None:
        """A step towards the label of a turn's action; turns count from 1. A label of 0, silence, changes nothing."""
        state, action = self.steps[turn - 1]
        if label:
            self._human.add(state, self.spec.alpha * (label - self._human(state)[action]), action)

    def _learn(self, atoms: Any) -> None:
        """Hear the verdicts of atoms on actions of this episode, in the order of turns; several for a turn add up."""
        labels: dict[int, float] = {}
        for atom in atoms:
            turn, claim = atom.about_turn, atom.claim
            about_here = 1 <= turn <= len(self.steps)
            judges = claim.kind in (HP, HN) and isinstance(claim, ActionClaim)
            if about_here and judges and frozen(claim.action) == self.steps[turn - 1][1]:
                labels[turn] = labels.get(turn, 0.0) + (1.0 if claim.kind is HP else -1.0)
        for turn, label in sorted(labels.items()):
            self.hear(turn, label)


@dataclass(frozen=True)
class Tamer(Student):
    """TAMER (Knox & Stone 2009): supervised learning of the trainer's praise (1) and blame (-1), and greedy actions.

    The paper has linear functions of features, and spreads a label over the last actions by a density of the trainer's
    delay. Here there is a table, or tiles, and a label counts for the turn that it is about, even if it comes later.
    Claims about another action, advice and warnings are not evaluation and are ignored.
    """

    forget: bool = True
    """Whether each episode starts without memory; use it if each has another world."""
    tiles: Annotated[int, Range(0, 64)] = 0
    """Number of tilings of a bounded state, each shifted by a part of a tile (Sutton & Barto 2018, 9.5.4), 0 to 64."""
    alpha: Share = 0.3
    """Step size, 0 to 1."""
    reads = "atoms"
    policy = _Policy
    batch = "Tamers"
