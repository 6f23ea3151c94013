"""Best-first search from a state of an environment, with bounds, and what it proves."""

import math
import time
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from typing import Any, NamedTuple

import gymnasium

from teachers.planning.known import State
from teachers.planning.planner import PlanningError
from worlds.wrapped.gym_world import GymWorld
from worlds.wrapped.snapshots import Snapshot, Way

_Env = gymnasium.Env[Any, Any]
Heuristic = Callable[[_Env], float]
"""Guesses in an environment's current state how many actions are left to the goal; if it has to last, the danger."""

_TRIED = 50  # states in which a trial repeats steps, with other random numbers and from another way there
_LUCK = 1  # the seed of these numbers
_ROUNDING = 1e-9


class Found(NamedTuple):
    """What a search found."""

    actions: tuple[Any, ...] | None
    """Actions that reach the aim; None if none were found."""
    least: float
    """No fewer actions reach it, which is proven; infinite if none do."""
    nodes: int
    """Steps of the environment that it took."""

    @property
    def shortest(self) -> bool:
        """Whether the actions are proven to be as few as possible."""
        return self.actions is not None and self.least == len(self.actions)


@dataclass(frozen=True)
class Task:
    """What is searched for, and how."""

    way: Way
    choices: tuple[Any, ...]
    """The actions that are tried in each state, in canonical form."""
    state: State
    """The key of a state: all that decides what happens but time."""
    alike: State | None
    """A coarser key: of states that share it only the first is searched, so that nothing is proven. None: `state`."""
    heuristic: Heuristic | None
    admissible: bool
    """Whether the heuristic guesses too much nowhere."""
    lasts: int | None
    """For how many actions an episode has to last; None: the task is to be solved."""
    nodes: int
    seconds: float

    @property
    def measures(self) -> bool:
        """Whether the search can prove how many actions are needed."""
        return self.alike is None and self.lasts is None and (self.heuristic is None or self.admissible)

    @property
    def exact(self) -> bool:
        """Whether states of one key are the same, so that a search that comes to an end has seen all of them."""
        return self.alike is None

    def key(self, env: _Env, depth: int) -> Hashable:
        """The key by which states are searched once; where time is the aim, each depth counts."""
        key = (self.alike or self.state)(env)
        return key if self.lasts is None else (key, depth)

    def guess(self, env: _Env) -> float:
        """What the heuristic says.

        Raises:
            PlanningError: it raised, or gave no number.
        """
        if self.heuristic is None:
            return 0.0
        try:
            guessed = float(self.heuristic(env))
        except Exception as error:
            raise PlanningError(
                f"heuristic must give a number for an environment in any state, and raised {error!r}"
            ) from error
        if math.isnan(guessed):
            raise PlanningError("heuristic must give a number for an environment in any state, got nan")
        return guessed

    def rank(self, env: _Env, depth: int) -> float:
        """Of the states that wait, the one with the smallest rank is next: the guessed number of actions in all.

        Where an episode has to last it is the danger, less the actions so far.
        """
        guessed = self.guess(env)
        return depth + max(1.0, guessed) if self.lasts is None else guessed - depth

    def reached(self, after: Snapshot, depth: int, aim: int) -> bool:
        """Whether a step, the last of so many, reaches the aim."""
        return after.solved if self.lasts is None else not after.terminated and depth >= aim


class _Node(NamedTuple):
    """A state on the way."""

    key: Hashable
    saved: Any
    depth: int
    before: "_Node | None"
    action: Any

    def actions(self) -> tuple[Any, ...]:
        """The actions that lead here."""
        taken: list[Any] = []
        node: _Node | None = self
        while node is not None and node.before is not None:
            taken.append(node.action)
            node = node.before
        return tuple(reversed(taken))


def search(task: Task, lab: GymWorld, aim: int, *, trial: bool = False) -> Found:
    """Search from the state of a scratch world.

    With a heuristic that guesses too much nowhere, or none, this is A* (Hart, Nilsson and Raphael 1968): the first of
    the open states bounds from below how many actions are needed.

    Args:
        task: what is searched for.
        lab: the scratch world.
        aim: for how many actions an episode has to last, where that is the task.
        trial: whether to find out if chance decides, and if states of the same key differ.

    Raises:
        PlanningError: the trial found that, or the heuristic gives no number.
    """
    watch = _Watch(task, lab) if trial else None
    found = _search(task, lab, aim, watch)
    if watch:
        watch.compare()
    return found


def _search(task: Task, lab: GymWorld, aim: int, watch: "_Watch | None") -> Found:
    begun, taken, order, least = time.monotonic(), 0, 0, 0.0
    key, rank = task.key(lab.env, 0), task.rank(lab.env, 0)
    heap = [(rank, 0, 0, _Node(key, task.way.begin(lab), 0, None, None))]
    depths: dict[Hashable, int] = {key: 0}
    best: _Node | None = None
    while heap:
        rank, _, _, node = heappop(heap)
        if depths[node.key] < node.depth:
            continue  # there is a shorter way to this state
        if task.measures:
            least = max(least, math.ceil(rank - _ROUNDING))
            if best is not None and best.depth <= least:
                return Found(best.actions(), best.depth, taken)
        for action in task.choices:
            if taken >= task.nodes or time.monotonic() - begun > task.seconds:
                return Found(best and best.actions(), least, taken)
            after, depth = task.way.step(lab, node.saved, action), node.depth + 1
            taken += 1
            child = _Node(task.key(after.env, depth), after.saved, depth, node, action)
            if task.reached(after, depth, aim):
                if best is None or depth < best.depth:
                    best = child
                if not task.measures:
                    return Found(best.actions(), least, taken)
            elif not after.over and depth < depths.get(child.key, math.inf):
                order += 1
                heappush(heap, (task.rank(after.env, depth), -depth, order, child))
                if watch and child.key in depths:
                    watch.again(child)
                depths[child.key] = depth
            elif watch and not after.over:
                watch.again(child)
            if watch:
                watch.see(node, child, after)
    if best is not None:
        return Found(best.actions(), best.depth, taken)
    return Found(None, math.inf if task.exact else least, taken)


class _Watch:
    """Repeats steps of a search, with other random numbers, and in states that were reached again."""

    def __init__(self, task: Task, lab: GymWorld) -> None:
        self._task, self._lab = task, lab
        self._results: dict[Hashable, dict[Any, tuple[Any, ...]]] = {}
        self._again: list[_Node] = []

    def see(self, node: _Node, child: _Node, after: Snapshot) -> None:
        """Note what a step led to, and take it once more."""
        row = self._results.setdefault(node.key, {})
        row[child.action] = child.key, *after[2:]
        if len(self._results) > _TRIED:
            return
        other = self._task.way.step(self._lab, node.saved, child.action, _LUCK)
        if (self._task.key(other.env, child.depth), *other[2:]) != row[child.action]:
            raise PlanningError("chance decides what actions do, and a search would use its luck")

    def again(self, node: _Node) -> None:
        """Note a state that was reached again."""
        if len(self._again) < _TRIED:
            self._again.append(node)

    def compare(self) -> None:
        """Compare what follows in states that were reached again."""
        if not self._task.exact:
            return
        for node in self._again:
            for action, result in self._results.get(node.key, {}).items():
                after = self._task.way.step(self._lab, node.saved, action)
                if (self._task.key(after.env, node.depth + 1), *after[2:]) != result:
                    raise PlanningError(
                        f"two states have the same key and differ in what follows action {action}; give state=..., a "
                        "function of the environment that tells them apart"
                    )


def reaches(task: Task, lab: GymWorld, actions: Sequence[Any], aim: int, luck: int) -> bool:
    """Whether actions reach the aim from the state of a scratch world, and do not depend on what is drawn."""
    saved = task.way.begin(lab)
    for depth, action in enumerate(actions, 1):
        after = task.way.step(lab, saved, action, luck + depth)
        if after.over or depth == len(actions):
            return depth == len(actions) and task.reached(after, depth, aim)
        saved = after.saved
    return False
