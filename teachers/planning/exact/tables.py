"""Transitions from an environment's own table, or from the rules in `teachers.planning.known`."""

import contextlib
import copy
import warnings
from collections import deque
from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from teachers.planning.known import Known, State, known
from teachers.planning.planner import PlanningError, stepped
from teachers.planning.state_key import HINT, counts_of, other_parts, unshared
from teachers.planning.transitions import Transition, Transitions
from worlds.wrapped.layers import time_limits

_Env = gymnasium.Env[Any, Any]
_EPISODES, _STEPS = 20, 100  # of random play, by which a table is tried
_TIMES = 6  # that an action is tried in each state, where chance decides what it does
_LATE = 2_000  # steps of walks, after which it is tried, too
_COUNTED = 20_000  # steps, after numbers of steps that an attribute counts
_SURE = 1e-9  # by which chances may miss 1
_OF_TABLE = {"P", "s", "lastaction"}  # attributes that are no further part of the state


class UnlistedError(PlanningError):
    """An environment has random results that its table lacks, so exploration does not serve either."""


def state_number(env: _Env) -> int:
    """The state of Gymnasium's toy texts, and of other environments with such a table."""
    try:
        return int(env.unwrapped.s)  # type: ignore[attr-defined]  # of toy texts
    except AttributeError:
        raise PlanningError("the environment has a table `P`, but no attribute `s` with its current state") from None


class OfTable:
    """Reads the state of an environment with a table; None in episodes whose rules differ from the plan's.

    Args:
        env: the environment, with the rules of the plan.
        own: the knowledge about it.
        state: reads the state.
    """

    def __init__(self, env: _Env, own: Known, state: State) -> None:
        self._own, self._state = own, state
        self._rules = unshared(getattr(env.unwrapped, "P", None)), *self._options(env)
        self._same = True
        self._env: _Env | None = None
        self._bare: Any = None
        self._table: Any = None

    def _options(self, env: _Env) -> tuple[Any, ...]:
        lacks, options = self._own.lacks, self._own.options
        return lacks and lacks(env), options and options(env), time_limits(env)

    def begin(self, env: _Env) -> None:
        """Compare table, options and time limits at the start of an episode."""
        self._env, self._bare = env, env.unwrapped
        self._table = getattr(self._bare, "P", None)
        same = False
        with contextlib.suppress(ValueError):  # of arrays
            same = bool(self._rules == (self._table, *self._options(env)))
        if self._same and not same:
            warnings.warn(
                "the teacher knows no values in this episode: the environment has another table, other options or "
                "another time limit than when it was planned for",
                stacklevel=2,
            )
        self._same = same

    def __call__(self, env: _Env) -> Any:
        """Read the state."""
        if env is not self._env or getattr(self._bare, "P", None) is not self._table:
            self.begin(env)
        if not self._same:
            return None
        if self._state is not state_number:
            return self._state(env)
        state = self._bare.s
        return state if type(state) is int else int(state)

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_env": None, "_bare": None, "_table": None}


def table_of(env: _Env, turns: int, whole: bool = False) -> tuple[Transitions, State, str]:
    """The transitions in an environment's table, a function that reads its state, and the source in words.

    Args:
        env: the environment, which is reset and stepped.
        turns: most actions of an episode.
        whole: whether the caller knows that the table's state alone determines the future.

    Raises:
        PlanningError: there is no table, or it is incomplete or wrong.
    """
    own = known(env) or Known()
    if own.lacks is not None and (lack := own.lacks(env)):
        raise UnlistedError(f"the table of transitions lacks {lack}; leave that option out")
    if own.table is not None:
        transitions, state, source = own.table(env)
    else:
        transitions, state, source = _read(env), state_number, "the environment's table of transitions"
        _check_whole(transitions)
        states = _reachable(env, transitions)
        _try_all(env, transitions, states, turns, whole)
        _try_late(env, transitions, states, turns)
    _try_out(env, transitions, state, turns)
    return transitions, OfTable(env, own, state), source


def _read(env: _Env) -> Transitions:
    table: Any = getattr(env.unwrapped, "P", None)
    if not hasattr(table, "items"):
        raise PlanningError("the environment has no table of transitions `P`")
    count = action_count(env)
    try:
        return {
            int(state): [
                [
                    Transition(float(chance), None if over else int(after), float(reward))
                    for chance, after, reward, over in row[action]
                    if chance > 0
                ]
                for action in range(count)
            ]
            for state, row in table.items()
        }
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise PlanningError(f"the table `P` of the environment cannot be read: {error!r}") from None


def action_count(env: _Env) -> int:
    """The number of actions.

    Raises:
        PlanningError: they are not numbered from 0.
    """
    actions = env.action_space
    if not isinstance(actions, spaces.Discrete) or actions.start != 0:
        raise PlanningError(f"actions must be numbered from 0, got {actions}")
    return int(actions.n)


def _check_whole(transitions: Transitions) -> None:
    for state, row in transitions.items():
        for action, each in enumerate(row):
            where = f"`P[{state}][{action}]`"
            if gone := [after for _, after, _ in each if after is not None and after not in transitions]:
                raise PlanningError(f"{where} leads to the state {gone[0]}, which `P` lacks")
            if abs(sum(chance for chance, _, _ in each) - 1) > _SURE:
                raise PlanningError(f"the chances of {where} do not add up to 1")


def _try_all(env: _Env, transitions: Transitions, states: Sequence[int], turns: int, whole: bool) -> None:
    """Set the environment to each state and take each action: random play seldom sees a goal or a wrapper's bonus.

    Raises:
        PlanningError: the table is wrong; or other attributes change, too, and may matter.
    """
    counts = counts_of(env)
    left_out = {*_OF_TABLE, *counts}
    parts = other_parts(env, left_out)
    for count in (None, *((0, turns - 1) if counts else ())):
        for state in states:
            for action, each in enumerate(transitions[state]):
                for _ in range(1 if len(each) == 1 else _TIMES):
                    now = {} if count is None else dict.fromkeys(counts, count)
                    if _try_step(env, transitions, state, action, now):
                        if not whole:
                            _check_parts(parts, other_parts(env, left_out))
                        env.reset(seed=0)
            if not whole:
                _check_parts(parts, other_parts(env, left_out))
    if counts:
        _try_counts(env, transitions, states, turns, counts)


def _try_counts(env: _Env, transitions: Transitions, states: Sequence[int], turns: int, counts: Sequence[str]) -> None:
    """Take each action in each state after each number of steps, within a bound; rewards and ends come first.

    Raises:
        PlanningError: the table is wrong.
    """
    everything = [(state, action) for state in states for action in range(len(transitions[state]))]
    left, rng = _COUNTED, np.random.default_rng(0)
    for pairs in (_goals(transitions, states), everything):
        for count in rng.permutation(turns).tolist():
            for state, action in pairs:
                for _ in range(1 if len(transitions[state][action]) == 1 else _TIMES):
                    if _try_step(env, transitions, state, action, dict.fromkeys(counts, count)):
                        env.reset(seed=0)
                    left -= 1
            if left < 0:
                return


def _goals(transitions: Transitions, states: Sequence[int]) -> list[tuple[int, int]]:
    """The states and actions that may give a reward or an end."""
    return [(s, a) for s in states for a, each in enumerate(transitions[s]) if any(r or t is None for _, t, r in each)]


def _try_late(env: _Env, transitions: Transitions, states: Sequence[int], turns: int) -> None:
    """Walk at random for various numbers of steps, then set the environment next to a reward or an end.

    Raises:
        PlanningError: the table is wrong.
    """
    goals = _goals(transitions, states)
    rng, left = np.random.default_rng(0), _LATE if goals else 0
    while left > 0:
        env.reset(seed=left % _EPISODES)
        left -= 1
        for _ in range(int(rng.integers(turns))):
            row = transitions[state_number(env)]
            going = [action for action, each in enumerate(row) if None not in [after for _, after, _ in each]]
            left -= 1
            if not going or any(_check_step(env, transitions, state_number, int(rng.choice(going)))):
                break
        else:
            _try_step(env, transitions, *goals[rng.integers(len(goals))], {})


def _reachable(env: _Env, transitions: Transitions) -> Sequence[Any]:
    """The non-terminal states that are reachable from the starts of some episodes."""
    starts: list[Any] = []
    for seed in range(_EPISODES):
        env.reset(seed=seed)
        starts.append(state_number(env))
    chances = getattr(env.unwrapped, "initial_state_distrib", ())
    queue = deque(dict.fromkeys([*starts, *(state for state, chance in enumerate(chances) if chance > 0)]))
    seen = set(queue)
    while queue:
        after = {each for action in transitions.get(queue.popleft(), ()) for _, each, _ in action} - seen - {None}
        seen |= after
        queue.extend(after)
    return sorted(seen & transitions.keys())


def _try_step(env: _Env, transitions: Transitions, state: int, action: int, counts: dict[str, int]) -> bool:
    """Take an action in a state, with these step counts; return whether the episode is over."""
    bare: Any = env.unwrapped
    bare.s = state
    for name, value in counts.items():
        setattr(bare, name, value)
    return any(_check_step(env, transitions, state_number, action))


def _check_parts(before: dict[str, Any], after: dict[str, Any]) -> None:
    """Check that no attribute has changed.

    Raises:
        PlanningError: one has.
    """
    changed = [name for name in before.keys() | after.keys() if before.get(name) != after.get(name)]
    if changed:
        raise PlanningError(
            f"the table of transitions has no part for {', '.join(sorted(changed))}, which changes and may decide what "
            f"happens; if it does not, {HINT}"
        )


def _try_out(env: _Env, transitions: Transitions, state: State, turns: int) -> None:
    """Check by random play that the table has all that happens.

    Raises:
        PlanningError: it lacks something, or the environment truncates episodes early.
    """
    space = copy.deepcopy(env.action_space)
    space.seed(0)
    for seed in range(_EPISODES):
        env.reset(seed=seed)
        for turn in range(1, _STEPS + 1):
            over, cut = _check_step(env, transitions, state, int(space.sample()))
            if cut and turn < turns:
                raise PlanningError(
                    f"the environment has cut an episode off after {turn} actions, of which its table says nothing; if "
                    f"that is its time limit, give max_turns={turn}"
                )
            if over or cut:
                break


def _check_step(env: _Env, transitions: Transitions, state: State, action: int) -> tuple[bool, bool]:
    """Take an action; return whether the episode has terminated, and whether it was truncated.

    Raises:
        PlanningError: the table lacks the result.
    """
    before = state(env)
    _, reward, terminated, truncated, _ = stepped(env, action)
    after = None if terminated else state(env)
    rows = transitions.get(before)
    if rows is None or not any((there, paid) == (after, reward) for _, there, paid in rows[action]):
        raise PlanningError(
            f"the table of transitions does not say what happens: action {action} in state {before} led to "
            f"{after} for {reward}; the state has parts that the table lacks, or a wrapper changes the reward"
        )
    return bool(terminated), bool(truncated)
