"""Transitions by exploration: all states that can be reached, by copies of the environment."""

from collections import deque
from collections.abc import Callable, Hashable, Iterator
from itertools import count as count_up
from itertools import islice
from typing import Any

import gymnasium
import numpy as np

from teachers.planning import cache
from teachers.planning.contents import HINT, Contents
from teachers.planning.exact.tables import action_count
from teachers.planning.known import State
from teachers.planning.planner import PlanningError
from teachers.planning.progress import ProgressBar
from teachers.planning.transitions import Transition, Transitions
from worlds.wrapped.snapshots import copied, draws, shake

_Env = gymnasium.Env[Any, Any]
_SAMPLED = 50  # states in which a step is repeated, with other random numbers and from another way there
_LUCK, _LATER = 30, 2  # other random numbers, with which a step that draws some is repeated there, and elsewhere
_WALK = 200  # steps by which a stored table is tried
_WAYS = 20  # to rewards, by which it is tried, too
_CLOSE = 1e-9  # rewards that differ by less are equal


def explored(
    env: _Env, state: State, turn: int, share: Callable[[int], float], *, limit: int, states: int, seconds: float
) -> Transitions:
    """The same as `explore`, once for all processes: what is found is stored, and tried before it is used again.

    To be used with functions of ours as `state`, which the key of a stored table covers.
    """
    start = state(env)
    key = cache.key_of(env, start, limit)
    found = cache.load(key)
    if found is None or len(found) > states or not _agrees(env, state, turn, share, limit, found):
        found = explore(env, state, turn, share, limit=limit, states=states, seconds=seconds)
        cache.save(key, found)
    return found


def _agrees(env: _Env, state: State, turn: int, share: Callable[[int], float], limit: int, found: Transitions) -> bool:
    """Whether a random walk, and ways to rewards, give what a stored table says."""
    rng, count = np.random.default_rng(0), action_count(env)
    there, now = copied(env), turn
    for _ in range(_WALK):
        row = found.get(key := state(there), ())
        action = int(rng.integers(count))
        if len(row) != count or len(row[action]) != 1:
            return False
        transition, _ = _step(there, action, state, share(now), now + 1 < limit)
        if not _same(transition, row[action][0]):
            return False
        now += 1
        if transition.state is None or share(now) <= 0:
            there, now = copied(env), turn
    return key in found and all(
        _goes(env, state, turn, share, limit, found, way) for way in islice(_ways_to_rewards(found, state(env)), _WAYS)
    )


def _goes(
    env: _Env,
    state: State,
    turn: int,
    share: Callable[[int], float],
    limit: int,
    found: Transitions,
    way: tuple[int, ...],
) -> bool:
    """Whether actions give what a stored table says."""
    there = copied(env)
    for now, action in enumerate(way, turn):
        if share(now) <= 0:
            break
        before = state(there)
        if not _same(_step(there, action, state, share(now), now + 1 < limit)[0], found[before][action][0]):
            return False
    return True


def _ways_to_rewards(found: Transitions, start: Hashable) -> Iterator[tuple[int, ...]]:
    """The shortest ways to rewards of a stored table, breadth first: a walk at random seldom sees any."""
    queue: deque[tuple[Hashable, tuple[int, ...]]] = deque([(start, ())])
    seen = {start}
    while queue:
        here, way = queue.popleft()
        for action, (transition,) in enumerate(found[here]):
            if transition.reward:
                yield (*way, action)
            if transition.state is not None and transition.state not in seen:
                seen.add(transition.state)
                queue.append((transition.state, (*way, action)))


def explore(
    env: _Env,
    state: State,
    turn: int,
    share: Callable[[int], float],
    *,
    limit: int,
    states: int,
    seconds: float,
) -> Transitions:
    """The transitions of all actions in all states that can be reached, breadth first.

    Args:
        env: an environment in a state of its own; it is not changed.
        state: reads the key of an environment's state.
        turn: number of actions before that state.
        share: what is paid of a reward after so many actions.
        limit: number of actions after which time is over; an environment that truncates an episode before ends it.
        states, seconds: the most states, and the most time.

    Raises:
        PlanningError: a bound is reached, chance decides what happens, or states of the same key differ.
    """
    with ProgressBar("exploring", "states") as bar:
        return _explore(env, state, turn, share, limit, states, seconds, bar)


def _explore(
    env: _Env,
    state: State,
    turn: int,
    share: Callable[[int], float],
    limit: int,
    states: int,
    seconds: float,
    bar: ProgressBar,
) -> Transitions:
    count = action_count(env)
    found: dict[Hashable, list[list[Transition]]] = {}
    ended: set[Hashable] = set()
    queue = deque([(copied(env), state(env), turn)])
    seen = {queue[0][1]}
    lucks = count_up()
    again: list[tuple[_Env, Hashable, int]] = []  # states that were reached by another way
    while queue:
        here, key, now = queue.popleft()
        rows = found[key] = []
        for action in range(count):
            there = copied(here)
            before = draws(there)
            transition, after = _step(there, action, state, share(now), now + 1 < limit)
            tries = _LUCK if len(found) <= _SAMPLED else _LATER if draws(there) != before else 0
            _check_certain(here, action, state, share(now), now + 1 < limit, transition, islice(lucks, tries))
            rows.append([transition])
            if transition.state is None:
                ended.add(after)
            elif after not in seen:
                seen.add(after)
                queue.append((there, after, now + 1))
            elif len(again) < _SAMPLED:
                again.append((there, after, now + 1))
        bar.show(len(found), len(seen))
        if len(seen) > states or bar.seconds > seconds:
            counts = state.counts if isinstance(state, Contents) else ()
            raise PlanningError(
                f"more than {len(seen) - 1:,} states can be reached, {len(found):,} of which were explored in "
                f"{bar.seconds:.0f} s; the bounds are states={states:,} and seconds={seconds:g}; "
                + (
                    f"the environment counts steps in {', '.join(counts)}, so that no state comes twice; if the count "
                    f"decides nothing, {HINT}, and without the count"
                    if counts
                    else f"pass other ones, as in oracle='exact(states={2 * states}, seconds={2 * seconds:g})'"
                )
            )
    for there, key, now in again:
        for action in range(count):
            transition, _ = _step(copied(there), action, state, share(now), now + 1 < limit)
            if not _same(transition, found[key][action][0]):
                raise PlanningError(
                    f"two states have the same key and differ: action {action} led to {transition} and to "
                    f"{found[key][action][0]}; give state=..., a function of the environment that tells them apart"
                )
    return found | {key: [[] for _ in range(count)] for key in ended - found.keys()}


def _step(env: _Env, action: int, state: State, share: float, early: bool) -> tuple[Transition, Hashable]:
    """Take an action: its transition with the reward before it fades, and the key of the state after it.

    Where it is early, not time has truncated an episode but the state.
    """
    _, reward, terminated, truncated, _ = env.step(action)
    after = state(env)
    over = terminated or (truncated and early)
    return Transition(1.0, None if over else after, float(reward) / share), after


def _check_certain(
    env: _Env, action: int, state: State, share: float, early: bool, transition: Transition, lucks: Iterator[int]
) -> None:
    """Take an action once more, with other random numbers; where it draws any, with all, for chances may be small."""
    for luck in lucks:
        other = copied(env)
        shake(other, luck)
        before = draws(other)
        if not _same(_step(other, action, state, share, early)[0], transition):
            raise PlanningError("chance decides what actions do, and there is no table that says how")
        if draws(other) == before:
            return


def _same(one: Transition, other: Transition) -> bool:
    return one.state == other.state and abs(one.reward - other.reward) <= _CLOSE
