"""Transitions by exploration: copies of the environment visit all reachable states."""

from collections import deque
from collections.abc import Callable, Hashable, Iterable
from itertools import count as count_up
from itertools import islice
from math import isfinite
from typing import Any, NamedTuple

import gymnasium
import numpy as np

from teachers.planning.exact.tables import action_count
from teachers.planning.known import State
from teachers.planning.planner import PlanningError, UnfitError, stepped
from teachers.planning.progress import ProgressBar
from teachers.planning.state_key import HINT
from teachers.planning.transitions import Transition, Transitions
from worlds.wrapped.generators import draws, shake
from worlds.wrapped.layers import copied

_Env = gymnasium.Env[Any, Any]
_SAMPLED = 50  # states in which a step is repeated that draws nothing, or from another way there
_FEW, _LUCK = 4, 300  # other random numbers, with which each step that draws some is repeated, at first and later
_PLAYED = 1_500  # steps by which transitions are tried
_SHOWN = 60  # characters of a state
_CLOSE = 1e-9  # rewards that differ by less are equal


class Start(NamedTuple):
    """The start of an exploration."""

    env: _Env
    """The environment in the first state; it is not changed."""
    state: State
    """Reads the key of an environment's state."""
    turn: int
    """Number of actions before the first state."""
    share: Callable[[int], float]
    """The factor of a reward after so many actions."""
    limit: int
    """The time limit in actions; truncation before it counts as the end of the episode."""
    late: bool
    """Whether states at the time limit count, too."""


def _disagreement(start: Start, found: Transitions) -> str:
    """A contradiction between play and the transitions, in words; empty if none is found.

    Random walks of many lengths each go on along a shortest path to a reward or an end, so that they reach states late
    and by many paths.
    """
    env, state, turn, share, limit, _ = start
    rng, count, left = np.random.default_rng(0), action_count(env), _PLAYED
    ways = _Ways(found)
    while left > 0:
        there, now, key = copied(env), turn, state(env)
        shake(there, left)
        wander, goal = int(rng.integers(max(1, limit - turn))), int(rng.integers(max(1, len(ways.goals))))
        while now + 1 < limit and share(now) > 0:  # in the last turn an end by time hides others
            row = found.get(key)
            if row is None or not row[0]:
                return "play comes to a state that was not found"
            going = [action for action in range(count) if row[action][0].state is not None]
            way = ways.step(goal, key) if now - turn >= wander or not going else None
            action = way if way is not None else int(rng.choice(going or range(count)))
            transition, _ = _step(there, action, state, share(now), True)
            left, now = left - 1, now + 1
            if not _same(transition, row[action][0]):
                return f"action {action} led to {_said(transition)} and to {_said(row[action][0])}"
            if transition.state is None:
                break
            key = transition.state
            if not going or left <= 0:
                break
        left -= 1
    return ""


class _Ways:
    """Shortest paths to rewards and ends, which random walks seldom reach."""

    def __init__(self, found: Transitions) -> None:
        self._found = found
        self.goals = [
            (key, action)
            for key, row in found.items()
            for action, each in enumerate(row)
            if each and (each[0].reward or each[0].state is None)
        ]
        self._before: dict[Hashable, list[tuple[Hashable, int]]] = {}
        for key, row in found.items():
            for action, each in enumerate(row):
                if each and each[0].state is not None:
                    self._before.setdefault(each[0].state, []).append((key, action))
        self._known: dict[Hashable, dict[Hashable, int]] = {}

    def step(self, number: int, key: Hashable) -> int | None:
        """The next action on the path to a goal; None if there is no path."""
        if not self.goals:
            return None
        place, last = self.goals[number]
        if place not in self._known:
            steps, queue = {place: last}, deque([place])
            while queue:
                here = queue.popleft()
                for before, action in self._before.get(here, ()):
                    if before not in steps:
                        steps[before] = action
                        queue.append(before)
            self._known[place] = steps
        return self._known[place].get(key)


def explore(start: Start, states: int, steps: int) -> Transitions:
    """The transitions of all actions in all reachable states, breadth first.

    Both bounds count work, not time, so that the result does not depend on the machine.

    Args:
        start: the start of the exploration.
        states: most states.
        steps: most steps of copies, trials included.

    Raises:
        PlanningError: a bound is reached, results are random, or states with the same key differ.
    """
    with ProgressBar("exploring", "states") as bar:
        return _explore(start, states, steps, bar)


def _explore(start: Start, states: int, steps: int, bar: ProgressBar) -> Transitions:
    env, state, turn, share, limit, late = start
    count = action_count(env)
    found: dict[Hashable, list[list[Transition]]] = {}
    ended: set[Hashable] = set()
    queue = deque([(copied(env), state(env), turn)])
    seen = {queue[0][1]}
    lucks, taken = count_up(), 0
    drawing: list[tuple[_Env, int, int, Transition]] = []
    again: list[tuple[_Env, Hashable, int]] = []  # states that were reached by another way
    while queue:
        here, key, now = queue.popleft()
        rows = found[key] = []
        for action in range(count):
            there = copied(here)
            before = draws(there)
            transition, after = _step(there, action, state, share(now), now + 1 < limit)
            drew = draws(there) != before
            tries = _FEW if drew else int(len(found) <= _SAMPLED)
            _check_certain(here, action, state, share(now), now + 1 < limit, transition, islice(lucks, tries))
            taken += 1 + tries
            if drew:
                drawing.append((here, action, now, transition))
                if taken + len(drawing) * _LUCK > steps:
                    raise PlanningError(
                        f"{len(drawing):,} steps or more draw random numbers; to try each {_LUCK} times, so that "
                        f"chance is found, takes more than steps={steps:,}; draw only where chance decides, or pass "
                        f"another bound, as in oracle='exact(steps={2 * steps})'"
                    )
            rows.append([transition])
            if taken > steps:
                break
            if transition.state is None or (not late and now + 1 >= limit):
                ended.add(after)
            elif after not in seen:
                seen.add(after)
                queue.append((there, after, now + 1))
            elif len(again) < _SAMPLED:
                again.append((there, after, now + 1))
        if state(here) != key:
            raise UnfitError(
                "copies of the environment share a part of its state, so that a step of one changes the others; hold "
                "the state in attributes that are copied"
            )
        bar.show(len(found), len(seen))
        if len(seen) > states or taken > steps:
            counts = getattr(getattr(state, "state", state), "counts", ())
            raise PlanningError(
                f"more than {len(seen) - 1:,} states can be reached, {len(found):,} of which were explored in "
                f"{taken:,} steps; the bounds are states={states:,} and steps={steps:,}; "
                + (
                    f"the environment counts steps in {', '.join(counts)}, so that no state comes twice; if the count "
                    f"decides nothing, {HINT}, and without the count"
                    if counts
                    else f"pass other ones, as in oracle='exact(states={2 * states}, steps={2 * steps})'"
                )
            )
    for here, action, now, transition in drawing:
        _check_certain(here, action, state, share(now), now + 1 < limit, transition, islice(lucks, _LUCK))
    for there, key, now in again:
        for action in range(count):
            transition, _ = _step(copied(there), action, state, share(now), now + 1 < limit)
            if not _same(transition, found[key][action][0]):
                raise _alike(f"action {action} led to {_said(transition)} and to {_said(found[key][action][0])}")
    whole = found | {key: [[] for _ in range(count)] for key in ended - found.keys()}
    if differs := _disagreement(start, whole):
        raise _alike(differs)
    return whole


def _said(transition: Transition) -> str:
    """The target of a transition, without the content of a large state."""
    where = "the end" if transition.state is None else f"state {transition.state}"
    return f"{where if len(where) < _SHOWN else 'a state'} for {transition.reward:g}"


class AlikeError(PlanningError):
    """Two states have the same key and differ."""


def _alike(differs: str) -> AlikeError:
    return AlikeError(
        f"two states have the same key and differ: {differs}; give state=..., a function of the environment that tells "
        "them apart"
    )


def _step(env: _Env, action: int, state: State, share: float, early: bool) -> tuple[Transition, Hashable]:
    """Take an action; return its transition, with the reward before fading, and the key of the next state.

    If `early`, a truncation comes from the state and not from the time limit, and ends the episode.
    """
    _, reward, terminated, truncated, _ = stepped(env, action)
    after = state(env)
    if not isfinite(reward):
        raise PlanningError(f"rewards must be finite, got {float(reward)} for action {action}")
    over = terminated or (truncated and early)
    return Transition(1.0, None if over else after, float(reward) / share), after


def _check_certain(
    env: _Env, action: int, state: State, share: float, early: bool, transition: Transition, lucks: Iterable[int]
) -> None:
    """Check that an action has the same result with other random numbers.

    Raises:
        PlanningError: results are random.
    """
    for luck in lucks:
        other = copied(env)
        shake(other, luck)
        if not _same(_step(other, action, state, share, early)[0], transition):
            raise PlanningError("chance decides what actions do, and there is no table that says how")


def _same(one: Transition, other: Transition) -> bool:
    return one.state == other.state and abs(one.reward - other.reward) <= _CLOSE
