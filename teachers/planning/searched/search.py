"""Best-first search from a state of an environment, with bounds, and what it proves."""

import copy
import math
import time
from collections import deque
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import islice
from typing import Any, NamedTuple

import gymnasium

from teachers.planning.known import Heuristic, State
from teachers.planning.planner import PlanningError
from worlds.wrapped.gym_world import GymWorld, Position
from worlds.wrapped.snapshots import Stepped, WayBack, draws, shake

_Env = gymnasium.Env[Any, Any]
_TRIED = 50  # states that were reached again, in which a trial takes the actions again
_COUNTED = 2000  # steps, which a trial takes as if later, too
_LUCK = 1, 2, 3, 4  # the seeds of other random numbers
_PLAYS = 4, 100  # of a plan that draws some, at least and at most
_PLAYED = 1000  # by which their seeds differ
_ROUNDING = 1e-9


class SearchResult(NamedTuple):
    """What a search found."""

    actions: tuple[Any, ...] | None
    """Actions that reach the aim; None if none were found."""
    least: float
    """No fewer actions reach it, which is proven; infinite if none do."""
    nodes: int
    """Steps of the environment that it took."""
    lucky: bool = False
    """Whether it met actions whose results are drawn, which it left out, so that nothing else is proven."""
    deadly: bool = False
    """Whether a trial saw an action that ends an episode in vain."""

    @property
    def shortest(self) -> bool:
        """Whether the actions are proven to be as few as possible."""
        return self.actions is not None and self.least == len(self.actions)


@dataclass(frozen=True)
class SearchTask:
    """What is searched for, and how."""

    way: WayBack
    choices: tuple[Any, ...]
    """The actions that are tried in each state, in canonical form."""
    every: bool
    """Whether these are all; if not, it is not proven that nothing does."""
    state: State
    """The key of a state: all that decides what happens but time."""
    heuristic: Heuristic | None
    admissible: bool
    """Whether the heuristic guesses too much nowhere."""
    lasts: int | None
    """For how many actions an episode has to last; None: the task is to be solved."""
    nodes: int
    seconds: float

    @property
    def measures(self) -> bool:
        """Whether a search proves how many actions are needed."""
        return self.lasts is None and self.every and (self.heuristic is None or self.admissible)

    def aim(self, room: int) -> int:
        """For how many actions the episode has to last, of those that are left; 0 where it is to be solved."""
        return 0 if self.lasts is None else min(self.lasts, room)

    def step(self, lab: GymWorld, saved: Any, action: Any, luck: int | None = None) -> Stepped:
        """Take an action in a saved state, as of `WayBack`.

        Raises:
            PlanningError: the environment raised.
        """
        try:
            return self.way.step(lab, saved, action, luck)
        except Exception as error:
            raise PlanningError(
                f"the environment raised {error!r} after action {action} in a state that was tried"
            ) from error

    def key(self, env: _Env, depth: int) -> Hashable:
        """The key by which a state is searched once; where the episode has to last, once after so many actions."""
        return self.state(env) if self.lasts is None else (self.state(env), depth)

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
        if not math.isfinite(guessed):
            raise PlanningError(f"heuristic must give a finite number for an environment in any state, got {guessed}")
        return guessed

    def rank(self, env: _Env, depth: int) -> float:
        """Of the states that wait, the one with the smallest rank is next: the guessed number of actions in all.

        Where an episode has to last it is the danger, less the actions so far.
        """
        guessed = self.guess(env)
        return depth + max(1.0, guessed) if self.lasts is None else guessed - depth

    def reached(self, after: Stepped, depth: int, room: int) -> bool:
        """Whether a step, the last of so many, reaches the aim."""
        return after.solved if self.lasts is None else not after.terminated and depth >= self.aim(room)

    def over(self, after: Stepped, depth: int, room: int) -> bool:
        """Whether a step has ended the episode, other than by the time limit."""
        return after.terminated or (after.truncated and depth < room)


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


def search(task: SearchTask, lab: GymWorld, room: int, *, trial: bool = False) -> SearchResult:
    """Search from the state of a scratch world.

    With a heuristic that guesses too much nowhere, or none, this is A* (Hart, Nilsson and Raphael 1968): the first of
    the open states bounds from below how many actions are needed.

    Args:
        task: what is searched for.
        lab: the scratch world.
        room: the number of actions until the time limit.
        trial: whether to find out if states of the same key differ.

    Raises:
        PlanningError: they do, or the heuristic gives no number.
    """
    watch = _Watch(task, lab) if trial else None
    found = _search(task, lab, room, watch)
    if watch:
        watch.compare()
    return found._replace(deadly=watch is not None and watch.deadly, least=0.0 if found.lucky else found.least)


def _search(task: SearchTask, lab: GymWorld, room: int, watch: "_Watch | None") -> SearchResult:
    begun, taken, order, least, cut, lucky = time.monotonic(), 0, 0, 0.0, False, False
    key, rank = task.key(lab.env, 0), task.rank(lab.env, 0)
    heap = [(rank, 0, 0, _Node(key, task.way.begin(lab), 0, None, None))]
    depths: dict[Hashable, int] = {key: 0}
    best: _Node | None = None
    drew = False  # then nothing is proven, for a few tries miss small chances

    def found(least: float) -> SearchResult:
        return SearchResult(best and best.actions(), 0.0 if drew else least, taken, lucky)

    while heap:
        rank, _, _, node = heappop(heap)
        if depths[node.key] < node.depth:
            continue  # there is a shorter way to this state
        if node.depth >= room:
            cut = True
            continue
        if task.measures:
            least = min(max(least, math.ceil(rank - _ROUNDING)), room + 1)
            if best is not None and best.depth <= least:
                return found(best.depth)
        for action in task.choices:
            if taken >= task.nodes or time.monotonic() - begun > task.seconds:
                return found(least)
            after, depth = task.step(lab, node.saved, action), node.depth + 1
            taken, drew = taken + 1, drew or after.drew
            child = _Node(task.key(after.env, depth), after.saved, depth, node, action)
            reached = task.reached(after, depth, room)
            goes_on = not reached and not task.over(after, depth, room)
            is_new = goes_on and depth < depths.get(child.key, math.inf)
            rank = task.rank(after.env, depth) if is_new else 0.0
            if depends(task, lab, node.saved, action, after, child.key, depth):
                lucky = True
                continue
            if reached:
                if best is None or depth < best.depth:
                    best = child
                if not task.measures:
                    return found(least)
            if watch:
                watch.see(node, child, after, goes_on and child.key in depths)
            if is_new:
                depths[child.key], order = depth, order + 1
                heappush(heap, (rank, -depth, order, child))
    if best is not None:
        return found(best.depth)
    return found(math.inf if task.every and not cut else least)


def depends(
    task: SearchTask, lab: GymWorld, saved: Any, action: Any, after: Stepped, key: Hashable, depth: int
) -> bool:
    """Whether what a step led to, with this key, was drawn; it is taken again with other random numbers."""
    if not after.drew:
        return False
    others = (task.step(lab, saved, action, luck) for luck in _LUCK)
    return any(
        (other.terminated, other.solved, task.key(other.env, depth)) != (after.terminated, after.solved, key)
        for other in others
    )


class _Watch:
    """Compares what follows in states that a search reached more than once."""

    def __init__(self, task: SearchTask, lab: GymWorld) -> None:
        self._task, self._lab = task, lab
        self._results: dict[Hashable, dict[Any, tuple[Any, ...]]] = {}
        self._again: list[_Node] = []
        self.deadly = False

    def see(self, node: _Node, child: _Node, after: Stepped, again: bool) -> None:
        """Note what a step led to, and whether that was a state that was known."""
        self._results.setdefault(node.key, {})[child.action] = child.key, after.terminated, after.solved
        self.deadly |= after.terminated and not after.solved
        if again and len(self._again) < _TRIED:
            self._again.append(child)

    def compare(self) -> None:
        """Take the actions in states that were reached again."""
        begun = time.monotonic()
        for node in self._again:
            for action, result in self._results.get(node.key, {}).items():
                if time.monotonic() - begun > self._task.seconds:
                    return
                after = self._task.step(self._lab, node.saved, action)
                key = self._task.key(after.env, node.depth + 1)
                if (key, after.terminated, after.solved) != result:
                    raise PlanningError(
                        f"two states have the same key and differ in what follows action {action}; give state=..., a "
                        "function of the environment that tells them apart"
                    )


def check_counts(task: SearchTask, lab: GymWorld, counts: Sequence[str], room: int) -> None:
    """See whether what counts steps, and is no part of the key, decides what happens; layer by layer, within a bound.

    Args:
        task: what is searched for; states are copies.
        lab: the scratch world, where an episode begins.
        counts: the attributes that count.
        room: the number of actions until the time limit.

    Raises:
        PlanningError: it does.
    """
    queue, seen, taken = deque([(task.way.begin(lab), 0)]), {task.key(lab.env, 0)}, 0
    steps: list[tuple[Any, int, Any, tuple[Any, ...]]] = []
    while queue and taken < _COUNTED:
        saved, depth = queue.popleft()
        for action in task.choices:
            now = task.step(lab, saved, action)
            taken += 1
            key = task.key(now.env, depth + 1)
            steps.append((saved, depth, action, (key, now.terminated, now.solved)))
            if key not in seen and depth + 1 < room and not task.over(now, depth + 1, room):
                seen.add(key)
                queue.append((now.saved, depth + 1))
    for count, saved, depth, action, result in islice(_later(steps, room), 2 * _COUNTED):
        late = copy.deepcopy(saved)
        for name in counts:
            setattr(late.unwrapped, name, getattr(late.unwrapped, name) + count - depth)
        try:
            later = task.step(lab, late, action)
            alike = later.truncated or (task.key(later.env, depth + 1), later.terminated, later.solved) == result
        except Exception:  # it cannot be so late there
            alike = False
        if not alike:
            raise PlanningError(
                f"the number of steps ({', '.join(counts)}) decides what action {action} does after {depth}; give "
                "state=..., a function of the environment that returns all that decides what happens"
            )


def _later(
    steps: Sequence[tuple[Any, int, Any, tuple[Any, ...]]], room: int
) -> Iterator[tuple[int, Any, int, Any, tuple[Any, ...]]]:
    """The steps, each with later counts of steps before it: first with the greatest one, then with the next ones."""
    for more in (None, *range(1, room)):
        for step in steps:
            count = room - 1 if more is None else step[1] + more
            if count < room:
                yield count, *step


def reaches(
    task: SearchTask, lab: GymWorld, truth: Position, actions: Sequence[Any], room: int, luck: int | None = None
) -> bool:
    """Whether actions from a truth reach the aim, played in the lab.

    Args:
        task: has the aim.
        lab: a scratch world.
        truth: where to begin.
        actions: the actions; an episode that ends before the last one does not reach the aim.
        room: the number of actions until the time limit.
        luck: the seed of other random numbers than those that would come; None: those that would come.
    """
    lab.restore(truth)
    for depth, action in enumerate(actions, 1):
        if luck is not None:
            shake(lab.env, luck + depth)
        _, _, terminated, truncated, info = lab.advance(action)
        after = Stepped(lab.env, None, terminated, truncated, info["success"], False)
        if depth == len(actions):
            return task.reached(after, depth, room)
        if task.over(after, depth, room):
            return False
    return False


def arrives(task: SearchTask, lab: GymWorld, truth: Position, actions: Sequence[Any], room: int) -> bool:
    """Whether actions reach the aim whatever is drawn, as far as plays with other random numbers show.

    One is enough where nothing is drawn; else there are as many as the bounds of a search allow, 4 to 100.
    """
    begun = time.monotonic()
    lab.restore(truth)
    before = draws(lab.env)
    if not reaches(task, lab, truth, actions, room):
        return False
    fewest, most = _PLAYS
    plays = 1 if draws(lab.env) == before else min(max(task.nodes // len(actions), fewest), most)
    for number in range(plays):
        if not reaches(task, lab, truth, actions, room, _PLAYED * (number + 1)):
            return False
        if number >= fewest and time.monotonic() - begun > task.seconds:
            break
    return True


def refuted(task: SearchTask, lab: GymWorld, most: float, room: int) -> bool:
    """Whether no actions reach the aim from the state of a scratch world, or no more than `most` of them.

    By a search of another kind: layer by layer, until nothing is left. Where that takes more than twice the steps that
    a search may take, or not all actions are considered, nothing is proven, and the answer is no.
    """
    if not task.every:
        return False
    key = task.key(lab.env, 0)
    layer, seen, taken, depth = [task.way.begin(lab)], {key}, 0, 0
    while layer and depth < min(most, room):
        here, layer, depth = layer, [], depth + 1
        for saved in here:
            for action in task.choices:
                after = task.step(lab, saved, action)
                taken += 1
                key = task.key(after.env, depth)
                far = task.measures and task.rank(after.env, depth) > most
                if task.reached(after, depth, room) or taken > 2 * task.nodes:
                    return False
                if depends(task, lab, saved, action, after, key, depth):
                    return False
                if task.over(after, depth, room) or key in seen:
                    continue
                seen.add(key)
                if not far:
                    layer.append(after.saved)
    return True
