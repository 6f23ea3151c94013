"""What the searched tier knows: plans, found when they are needed, and kept while they are followed."""

import math
import warnings
from collections import Counter
from collections.abc import Hashable
from typing import Any, NamedTuple, TypeVar

import gymnasium

from teachers.planning.known import State
from teachers.planning.planner import PlanningError
from teachers.planning.searched.search import SearchResult, SearchTask, arrives, search
from worlds.wrapped.gym_world import GymWorld, Position
from worlds.wrapped.position import plain_parts, same
from worlds.wrapped.snapshots import time_limits

_KEPT = 4096  # plans, and results of searches
_AGAIN = 2  # a plan to last is made anew when less than this part of it is left

_Value = TypeVar("_Value")


class KeptPlan(NamedTuple):
    """A plan from a state on."""

    found: SearchResult
    """What the search found that made it."""
    used: int
    """The actions of it that were taken since."""

    @property
    def actions(self) -> tuple[Any, ...]:
        """The actions that are left; empty if there is no plan."""
        return (self.found.actions or ())[self.used :]

    @property
    def least(self) -> float:
        """No fewer actions reach the aim from here, which is proven; infinite if none do."""
        if self.used == 0:
            return self.found.least
        return len(self.actions) if self.found.shortest else 1.0


class Scout:
    """Searches from the states of episodes.

    A plan follows from the state in which the episode begins and the actions since, and from nothing else.

    Args:
        task: what is searched for.
        horizon: the most actions of an episode.
        goal: what to do, in words.
        rules: reads what else decides what happens, and is the same in all states of an episode; None: nothing.
    """

    def __init__(self, task: SearchTask, horizon: int, goal: str, rules: State | None = None) -> None:
        self.task, self.horizon, self.goal, self._rules = task, horizon, goal, rules
        self.silences: Counter[str] = Counter()
        """The number of searches after which there is no plan, although the task may be solved, by the reason."""
        self._plans: dict[Hashable, KeptPlan] = {}
        self._found: dict[Hashable, SearchResult] = {}

    def room(self, truth: Position) -> int:
        """The actions until the time limit."""
        return max(0, self.horizon - truth.turn)

    def plan(self, truth: Position, lab: GymWorld) -> KeptPlan:
        """The plan at a truth; the lab goes elsewhere."""
        start, actions, turn = Position(None, 0, truth.episode), truth.actions, truth.turn
        episode = self._begun(start, lab)
        if episode is None:
            return KeptPlan(self._silent("the episode cannot be replayed: it began in another state"), 0)
        while turn and (episode, actions[:turn]) not in self._plans:
            turn -= 1
        plan = self._plans.get((episode, actions[:turn]))
        if plan is None:
            plan = self._kept(self._plans, (episode, ()), KeptPlan(self.search(start, lab), 0))
        for now in range(turn + 1, truth.turn + 1):
            plan = self._next(plan, Position(None, now, truth.episode), actions[now - 1], lab)
            self._kept(self._plans, (episode, actions[:now]), plan)
        return plan

    def _begun(self, start: Position, lab: GymWorld) -> Hashable | None:
        """The state in which an episode begins; None if the lab cannot go there."""
        env = start.episode.anchor
        if env is None:
            lab.restore(start)
            env, wanted = lab.env, start.episode.parts
            if not same({name: part for name, part in plain_parts(env).items() if name in wanted}, wanted):
                return None
        return self._key(env)

    def _key(self, env: gymnasium.Env[Any, Any]) -> Hashable:
        """All that decides what happens: an environment may have a time limit of its own, too."""
        return self.task.state(env), time_limits(env), self._rules and self._rules(env)

    def _next(self, plan: KeptPlan, truth: Position, action: Any, lab: GymWorld) -> KeptPlan:
        """The plan after an action: what is left of the one before, or another."""
        left = len(plan.actions) - 1
        goes_on = left > 0 and plan.actions[0] == action
        if goes_on and (self.task.lasts is None or left >= self.task.aim(self.room(truth)) / _AGAIN):
            return plan._replace(used=plan.used + 1)
        return KeptPlan(self.search(truth, lab), 0)

    def search(self, truth: Position, lab: GymWorld, room: int | None = None) -> SearchResult:
        """What a search from a truth finds, as if `room` actions were left; a plan that needs luck is none."""
        room = self.room(truth) if room is None else room
        if truth.turn == 0:
            lab.restore(truth)
        else:  # by its last action, to see whether that has ended the episode
            lab.restore(Position(None, truth.turn - 1, truth.episode))
            _, _, terminated, truncated, _ = lab.advance(truth.episode.actions[truth.turn - 1])
            if terminated or truncated:
                return SearchResult(None, math.inf if terminated else 0.0, 0)
        key = self._key(lab.env), room
        if key in self._found:
            return self._found[key]
        try:
            found = search(self.task, lab, room)
            if found.actions is not None and not arrives(self.task, lab, truth, found.actions, room):
                raise PlanningError("chance decides where the actions of the plan lead")
        except PlanningError as error:
            found = self._silent(f"{error}")
        return self._kept(self._found, key, found)

    def _silent(self, reason: str) -> SearchResult:
        """No plan, with a warning the first time."""
        self.silences[reason] += 1
        if self.silences[reason] == 1:
            warnings.warn(f"the teacher has no plan in this state: {reason}", stacklevel=3)
        return SearchResult(None, 0.0, 0)

    @staticmethod
    def _kept(store: dict[Hashable, _Value], key: Hashable, value: _Value) -> _Value:
        """Keep a value in place of the oldest."""
        store[key] = value
        if len(store) > _KEPT:
            del store[next(iter(store))]
        return value
