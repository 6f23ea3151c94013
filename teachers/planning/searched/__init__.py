"""The searched tier: ways to the goal that a search has found; about all else the teacher is silent."""

import copy
import itertools
import math
from collections import Counter
from collections.abc import Callable, Sequence, Set
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces

from teachers.atoms import FN, FP, HN, HP, Claim, FeedbackType, Moment, R
from teachers.common import Syntax
from teachers.oracle import Oracle
from teachers.planning.contents import Contents, contents_of
from teachers.planning.known import Heuristic, Known, State, known, words_of
from teachers.planning.planner import Planned, Planner, PlanningError, check_own_draws, check_steps
from teachers.planning.searched.claims import (
    Astray,
    Considered,
    Detour,
    Doomed,
    Fatal,
    Hold,
    KeepGoing,
    Nearer,
    Next,
    OutOfReach,
    Ruin,
    Safe,
    Solve,
    answer_of,
    ended,
    listed,
    planned,
    steady,
    way,
)
from teachers.planning.searched.scout import KeptPlan, Scout
from teachers.planning.searched.search import SearchResult, SearchTask, arrives, check_counts, search
from teachers.planning.visible import privileged
from worlds.wrapped.gym_world import GymWorld, Position, faithful
from worlds.wrapped.snapshots import Copies, copied, way_back

_Env = gymnasium.Env[Any, Any]
_SEEDS = 2  # of episodes in which something must be found
_STEPS = 20  # of random play, in which is seen what is paid
_GRID = 3  # values of each number of a continuous action
_DIMENSIONS = 2  # of continuous actions that have a grid by default


@dataclass(frozen=True)
class Searched(Planner):
    """Plans by searching from the present state, where an environment can be set back and nothing is left to chance.

    States are those of copies of the environment, or of its methods `get_state` and `set_state`, or `clone_state` and
    `restore_state`; without these the episode is replayed from its seed.

    Args:
        nodes: the most steps of the environment in one search. There is one where the student leaves the plan; where
            the episode has to be kept going, also one a turn for each other action, to warn of it.
        seconds: the longest time of one search. What is said is the same each time if `nodes` ends searches before.
        heuristic: guesses, given an environment, how many actions are left to the goal; with `lasts`, how great the
            danger is. None: `teachers.planning.known` has it, or nothing is guessed.
        admissible: whether the given heuristic guesses too much nowhere, so that blame can rest on it.
        state: the key of an environment's current state, hashable: all that decides what happens but time. None:
            `teachers.planning.known` has it, or it is all that the environment holds.
        choices: the actions that are considered. None: all that are numbered; of a `Box` of at most two numbers the
            least, the middle and the greatest of each.
        lasts: for how many actions ahead the episode has to be kept going, where that is the task. None: a step has to
            solve it (see `success` of `GymWorld`), or `teachers.planning.known` says otherwise.
    """

    nodes: int = 3_000
    seconds: float = 20.0
    heuristic: Heuristic | None = None
    admissible: bool = False
    state: State | None = None
    choices: Sequence[Any] | None = None
    lasts: int | None = None

    def __post_init__(self) -> None:
        for name in ("nodes", "lasts"):
            value = getattr(self, name)
            if value is not None and (type(value) is not int or value < 1):
                raise ValueError(f"{name} must be an integer of at least 1, got {value!r}")
        if not self.seconds > 0:
            raise ValueError(f"seconds must be greater than 0, got {self.seconds!r}")

    def plan(self, env: _Env, turns: int, success: Callable[..., Any] | None = None) -> Planned:
        """Find a way back to states, and in an episode something to do."""
        entry = known(env)
        own = entry or Known()
        if own.expert and not (own.goal or success or self.lasts):
            raise PlanningError(
                "no goal is known that a search can find, but an expert is; give success=..., a function that says "
                "which step solves the task, or lasts=... of Searched"
            )
        check_steps(env)
        check_own_draws(env)
        back = way_back(env)
        if back is None:
            raise PlanningError(
                "the environment can be neither copied, nor set back, nor replayed from a seed; give it methods "
                "get_state() and set_state(state), or let reset(seed=...) seed all that it draws"
            )
        state = self.state or own.state or contents_of(env)
        copies = isinstance(back, Copies) or faithful(env, copied)
        if isinstance(state, Contents) and not copies:
            state = replace(state, timed=True)  # what the count of steps decides cannot be tried
        _check_hashable(state, env)
        if success is not None or (self.lasts is not None and own.lasts is None):
            own = replace(own, heuristic=None, lasts=None, success=None, goal="")  # this is another task
        lasts = self.lasts or own.lasts
        success = success or own.success or (None if lasts is None else lasted)
        world = GymWorld(env, look=state, success=success)
        task = SearchTask(
            way=back,
            choices=self._choices(world),
            every=isinstance(world.action_space, spaces.Discrete) and self.choices is None,
            state=state,
            heuristic=self.heuristic or own.heuristic,
            admissible=self.admissible if self.heuristic else own.admissible,
            lasts=lasts,
            nodes=self.nodes,
            seconds=self.seconds,
        )
        if success is None:
            _check_goal(env)
        scout = Scout(task, turns, own.goal or ("keep the episode going" if lasts else "reach the goal"), own.options)
        if isinstance(state, Contents) and state.counts and copies:
            world.reset(seed=0)
            check_counts(replace(task, way=Copies()), world, state.counts, turns)
        found = _tried(scout, world, self.heuristic is not None)
        silent = not (task.measures or lasts or found.deadly)
        return Planned(
            tier="searched",
            why=self._why(task, world),
            size=f"at most {self.nodes:,} steps",
            objective=f"{scout.goal} within {turns:,} actions",
            oracle=LastingOracle if lasts else QuietOracle if silent else SearchingOracle,
            phrases=Path(__file__).with_name("phrases.toml"),
            look=state,
            model=scout,
            horizon=turns,
            action_words=words_of(env, own),
            describe=own.describe,
            success=success,
            privileged=privileged(env, entry),
        )

    def _choices(self, world: GymWorld) -> tuple[Any, ...]:
        """The actions to consider, in canonical form."""
        space, given = world.action_space, self.choices
        if given is None:
            given = _all_of(space)
        if given is None:
            raise PlanningError(f"actions cannot be listed: {space}; pass oracle=Searched(choices=[...])")
        try:
            found = tuple(dict.fromkeys(world.legal(each) for each in given))
        except ValueError as error:
            raise PlanningError(f"choices must be actions: {error}") from None
        if not found:
            raise PlanningError("choices must have at least one action, got none")
        return found

    def _why(self, task: SearchTask, world: GymWorld) -> str:
        guided = "" if task.heuristic is None else ", guided by a heuristic"
        grid = "" if task.every else f", of the actions {listed(task.choices, world)} only"
        return f"a search of at most {self.nodes:,} steps a turn through {task.way.words}{guided}{grid}"


def lasted(observation: Any, reward: float, terminated: bool, truncated: bool, info: dict[str, Any]) -> bool:
    """Whether the episode went on until the time limit."""
    return truncated and not terminated


def _check_goal(env: _Env) -> None:
    """See whether a positive reward can be the sign of a solved task, where nobody says what is.

    Raises:
        PlanningError: steps that end no episode are paid, too: an end may be a failure, such as a fall or a crash.
    """
    space = copy.deepcopy(env.action_space)
    space.seed(0)
    env.reset(seed=0)
    for _ in range(_STEPS):
        _, reward, terminated, truncated, info = env.step(space.sample())
        if "success" in info or "is_success" in info:
            return
        if float(reward) > 0 and not (terminated or truncated):
            raise PlanningError(
                "steps that do not end an episode have positive rewards, so that an end with one may be a failure; "
                "give success=..., a function that says which step solves the task, or lasts=... of Searched, if an "
                "episode has to be kept going"
            )
        if terminated or truncated:
            env.reset(seed=0)


def _check_hashable(state: State, env: _Env) -> None:
    key = state(env)
    try:
        hash(key)
    except TypeError:
        raise TypeError(f"state must give something hashable, such as a tuple or bytes, got {key!r}") from None


def _all_of(space: spaces.Space[Any]) -> list[Any] | None:
    """All actions, or a grid of them; None if there is none."""
    if isinstance(space, spaces.Discrete):
        return list(range(int(space.start), int(space.start + space.n)))
    if not isinstance(space, spaces.Box) or space.shape not in ((), *((n,) for n in range(1, _DIMENSIONS + 1))):
        return None
    if not (np.isfinite(space.low).all() and np.isfinite(space.high).all()):
        return None
    axes = [np.linspace(low, high, _GRID) for low, high in zip(space.low.flat, space.high.flat, strict=True)]
    return [np.array(each, space.dtype).reshape(space.shape) for each in itertools.product(*axes)]


def _tried(scout: Scout, world: GymWorld, given: bool) -> SearchResult:
    """What a search finds in the first of a few episodes in which it finds something.

    Raises:
        PlanningError: it finds nothing.
    """
    task = scout.task
    for seed in range(_SEEDS):
        world.reset(seed=seed)
        found = search(task, world, scout.horizon, trial=seed == 0)
        if found.actions is not None:
            if arrives(task, world, Position(None, 0, world.truth.episode), found.actions, scout.horizon):
                _check_admissible(task, world, found.actions, given)
                return found
            found = found._replace(lucky=True)
    if found.lucky:
        raise PlanningError("chance decides what actions do, and a search would use its luck")
    if task.lasts:
        raise PlanningError(
            f"no way was found to keep an episode going for {task.lasts} actions; give fewer: lasts=..."
        )
    if math.isinf(found.least):
        raise PlanningError(
            f"no step solves the task in any state that can be reached ({found.nodes:,} steps were tried); give "
            "success=..., a function that says which step does, or lasts=... of Searched"
        )
    raise PlanningError(
        f"a search of {found.nodes:,} steps found no way to solve the task in {scout.horizon:,} turns; the bounds are "
        f"nodes={task.nodes:,} and seconds={task.seconds:g} of Searched; give more, or heuristic=..., a function of "
        "the environment that guesses how many actions are left; or success=..., if the task is not to end with a "
        "positive reward; or lasts=..., if an episode has to be kept going"
    )


def _check_admissible(task: SearchTask, world: GymWorld, actions: Sequence[Any], given: bool) -> None:
    """Compare what an admissible heuristic, given or known, guesses on a way with the actions that are left of it."""
    world.restore(Position(None, 0, world.truth.episode))
    for left in range(len(actions), 0, -1) if task.measures else ():
        if (guessed := task.guess(world.env)) > left:
            raise PlanningError(
                f"the heuristic guesses {guessed:g} actions where {left} solve the task, which one that is admissible "
                "does not; " + ("leave out admissible=True" if given else "pass a heuristic=... of Searched")
            )
        world.advance(actions[-left])


class _PlanOracle(Oracle[Position, GymWorld]):
    """What oracles with a plan have in common."""

    tier = "searched"

    @cached_property
    def model(self) -> Scout:
        """What is known."""
        model: Scout = self.lab.model
        return model

    @property
    def silences(self) -> Counter[str]:
        """The number of searches without a plan, by the reason."""
        return self.model.silences

    def _considered(self) -> tuple[Claim, ...]:
        """What is said of the actions where not all are considered."""
        if self.model.task.every:
            return ()
        return (Considered(listing=listed(self.model.task.choices, self.lab)),)


class SearchingOracle(_PlanOracle):
    """Knows a way to the goal, and of some actions that they are on none, or on none that is as short."""

    instruction_types: ClassVar[tuple[str, ...]] = ("b", "c")

    def _basics(self, truth: Position) -> tuple[Claim, ...]:
        solve = Solve(goal=self.model.goal, turns=self.model.horizon)
        return (solve, *self._considered(), Syntax(expected=self.lab.action_syntax))

    def _solution(self, truth: Position) -> tuple[Claim, ...]:
        actions = self.model.plan(truth, self.lab).actions
        return (way(actions, self.lab),) if 0 < len(actions) <= self.model.room(truth) else ()

    def _hindsight(self, claims: list[Claim], moment: Moment[Position], kinds: Set[FeedbackType]) -> None:
        kinds = kinds & set(self.feedback_types)
        before = planned(moment.past, moment, self.lab) if kinds & {HP, HN} else None
        if before is None or not steady(moment.past, moment.action, self.lab):
            return
        named = {"action": moment.action, "answer": answer_of(moment.action, self.lab)}
        then = len(before.actions)
        if moment.success:
            now: KeptPlan | None = None
            left: float = 0.0
        else:
            now = self.model.plan(moment.after, self.lab)
            left = len(now.actions) if now.actions else math.inf
        if left < then:
            if HP in kinds:
                claims.append(Nearer(**named, before=then, left=int(left)))
        elif HN in kinds and now is not None:
            if ended(moment.past, moment.action, self.lab) if moment.over else math.isinf(now.least):
                claims.append(OutOfReach(**named, before=then))
            elif not moment.over and then <= now.least < math.inf:
                claims.append(Astray(**named, before=then, left=int(now.least)))

    def _advice(self, claims: list[Claim], moment: Moment[Position], kinds: Set[FeedbackType]) -> None:
        kinds = kinds & set(self.feedback_types)
        plan = planned(moment.after, moment, self.lab) if kinds & {FP, FN} else None
        if plan is None:
            return
        first, left = plan.actions[0], len(plan.actions)
        if FP in kinds:
            claims.append(Next(action=first, answer=answer_of(first, self.lab), left=left))
        if FN in kinds:
            claims.extend(self._warnings(moment.after, plan)[:1])

    def _warnings(self, truth: Position, plan: KeptPlan) -> list[Claim]:
        """Of actions that end the episode in vain, or else of those that surely take longer than the plan."""
        task, lab, first, left = self.model.task, self.lab, plan.actions[0], len(plan.actions)
        lab.restore(truth)
        here, saved = task.state(lab.env), task.way.begin(lab)
        ruins: list[Claim] = []
        detours: list[Claim] = []
        for action in (each for each in task.choices if each != first):
            after = task.step(lab, saved, action)
            answer = answer_of(action, lab)
            if after.solved or after.drew:
                continue
            if after.terminated:
                ruins.append(Ruin(action=action, answer=answer))
            elif task.measures and not after.truncated:
                stays = plan.least == left and task.state(after.env) == here
                least = left if stays else math.ceil(task.guess(after.env))
                if left <= least:
                    detours.append(Detour(action=action, answer=answer, plan=left, left=int(least)))
        found = ruins or detours
        turn = truth.turn % len(found) if found else 0  # not the same one each turn
        return found[turn:] + found[:turn]


class QuietOracle(SearchingOracle):
    """The same where nothing bad can be proven of an action."""

    feedback_types: ClassVar[tuple[FeedbackType, ...]] = (R, HP, FP)


class LastingOracle(_PlanOracle):
    """Knows a way to keep the episode going for a while, and of some actions that there is none after them."""

    instruction_types: ClassVar[tuple[str, ...]] = ("b",)

    def _basics(self, truth: Position) -> tuple[Claim, ...]:
        keep = KeepGoing(goal=self.model.goal, turns=self.model.horizon)
        return (keep, *self._considered(), Syntax(expected=self.lab.action_syntax))

    def _hindsight(self, claims: list[Claim], moment: Moment[Position], kinds: Set[FeedbackType]) -> None:
        if not kinds & {HP, HN} or not steady(moment.past, moment.action, self.lab):
            return
        named = {"action": moment.action, "answer": answer_of(moment.action, self.lab)}
        if not moment.over and (now := planned(moment.after, moment, self.lab)) is not None:
            if HP in kinds:
                claims.append(Safe(**named, left=len(now.actions)))
        elif HN in kinds and (before := planned(moment.past, moment, self.lab)) is not None:
            left = len(before.actions) - 1
            if left and self._fails(moment.past, moment.action, left):
                claims.append(Doomed(**named, left=left))

    def _advice(self, claims: list[Claim], moment: Moment[Position], kinds: Set[FeedbackType]) -> None:
        plan = planned(moment.after, moment, self.lab) if kinds & {FP, FN} else None
        if plan is None:
            return
        first, left = plan.actions[0], len(plan.actions)
        if FP in kinds:
            claims.append(Hold(action=first, answer=answer_of(first, self.lab), left=left))
        if FN in kinds and left > 1:
            others = (each for each in self.model.task.choices if each != first)
            fatal = next((each for each in others if self._fails(moment.after, each, left - 1)), None)
            if fatal is not None:
                claims.append(Fatal(action=fatal, answer=answer_of(fatal, self.lab), left=left - 1))

    def _fails(self, truth: Position, action: Any, left: int) -> bool:
        """Whether nothing keeps the episode going for so many actions after this one."""
        if ended(truth, action, self.lab):
            return True
        if not steady(truth, action, self.lab):
            return False
        return math.isinf(self.model.search(self.lab.truth, self.lab, left).least)
