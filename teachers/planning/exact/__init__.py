"""The exact tier: it knows all transitions, and from them the best actions and what others lose."""

from collections.abc import Callable, Hashable, Set
from dataclasses import dataclass
from functools import cached_property, partial
from math import isfinite
from pathlib import Path
from typing import Any, ClassVar

import gymnasium
import numpy as np

from teachers.atoms import FN, FP, Claim, FeedbackType, Moment, fast_constructor
from teachers.common import Syntax
from teachers.oracle import ALL_KINDS, Oracle
from teachers.planning.exact.atlas import Atlas
from teachers.planning.exact.claims import (
    Avoid,
    Choose,
    Dawdle,
    Discounted,
    Fading,
    PoorlyChosen,
    Slower,
    Total,
    TriedPoorly,
    TriedWell,
    WellChosen,
    answer_of,
    rounded,
    route,
    used,
)
from teachers.planning.exact.exploring import AlikeError, Start, explore
from teachers.planning.exact.tables import UnlistedError, table_of
from teachers.planning.exact.worths import NOTHING, Lost, Worth, Worths
from teachers.planning.known import Known, State, known, words_of
from teachers.planning.planner import Planned, Planner, PlanningError, UnfitError, check_steps, unlike
from teachers.planning.state_key import check_recurs, check_wrappers, state_key
from teachers.planning.transitions import Transitions
from teachers.planning.visible import privileged
from teachers.spec import is_count
from worlds.wrapped.generators import sealed
from worlds.wrapped.gym_world import GymWorld, Position, faithful
from worlds.wrapped.layers import copied, time_limits

_Env = gymnasium.Env[Any, Any]
_TRIES = 3  # of actions before the episode
_MOST = 5_000_000  # values: states times actions that are left
_WIDEST = 1e8  # times that a reward is another one, beside whose rounding it would be lost


@dataclass(frozen=True)
class Exact(Planner):
    """Plans from all transitions of an environment.

    They come from a table: the attribute `P` of Gymnasium's toy texts, `P[state][action] = [(probability, next state,
    reward, whether the episode ends), ...]` with the current state in `s`; or a table that `teachers.planning.known`
    computes from the rules, averaged over what the student cannot see, such as a hidden card. Without a table, copies
    of the environment explore all reachable states at the start of each episode with new states; then the
    environment must be deterministic.

    Args:
        gamma: discount, from 0 to below 1. None: the objective is the sum of rewards within the turns of an episode.
        state: reads the hashable key of an environment's current state, for exploration: all that determines the future
            except time. None: the key from `teachers.planning.known`, or the environment's `get_state()`, or else all
            its attributes except its random generator.
        states: most states to explore.
        steps: most steps of exploration. A step that draws random numbers is tried some 300 times.
    """

    gamma: float | None = None
    state: State | None = None
    states: int = 5_000
    steps: int = 300_000

    def __post_init__(self) -> None:
        if self.gamma is not None and not 0 <= self.gamma < 1:
            raise ValueError(f"gamma must be None or a number from 0 to below 1, got {self.gamma!r}")
        for name in ("states", "steps"):
            if not is_count(value := getattr(self, name)):
                raise ValueError(f"{name} must be an integer of at least 1, got {value!r}")

    def _plan(self, env: _Env, turns: int, success: Callable[..., Any] | None) -> Planned:
        """Find all transitions, and compute the value of every action."""
        check_steps(env)
        listed = known(env)
        own = listed or Known()
        try:
            transitions, look, source = table_of(env, turns, self.state is not None)
        except UnlistedError:
            raise
        except PlanningError as error:
            model, look, source = self._explored(env, turns, own, str(error))
        else:
            model = Atlas(self._values(turns, None, transitions))
        return Planned(
            tier="exact",
            why=source,
            objective=(
                f"the sum of rewards within {model.horizon:,} actions, and of equal sums the one with fewer actions"
                if model.gamma is None
                else f"the sum of rewards, each worth {model.gamma:g} times as much as one action earlier"
            ),
            size=f"{model.size:,} states",
            copies=model.explores,
            oracle=CertainOracle if model.certain else ExactOracle,
            phrases=Path(__file__).with_name("phrases.toml"),
            look=look,
            model=model,
            horizon=model.horizon,
            action_words=words_of(env, own),
            describe=own.describe,
            success=own.success,
            privileged=False if own.table is not None else privileged(env, listed),
        )

    def _explored(self, env: _Env, turns: int, own: Known, why: str) -> tuple[Atlas, State, str]:
        """The values by exploration, the function that reads a state, and the source in words.

        Raises:
            PlanningError: there are too many states, or the environment is not deterministic.
        """
        if self.state is not None:
            state = self.state
        else:
            try:
                check_wrappers(env)
                state = own.state or state_key(env)
                check_recurs(env, state)
            except PlanningError as error:
                raise PlanningError(f"{why}; {error}") from None
        if hidden := sealed(env):
            raise PlanningError(f"{hidden}, into which Python cannot look, may draw random numbers; hold it in Python")
        if not faithful(env, copied):
            raise unlike(env, why)
        if own.fading is not None and self.gamma is not None:
            raise PlanningError("the environment pays less with time, which goes with no gamma; leave out gamma=...")
        env.reset(seed=0)
        key = state(env)
        try:
            hash(key)
        except TypeError:
            raise TypeError(f"state must give something hashable, such as a tuple or bytes, got {key!r}") from None
        look = _Limited(state)
        search = partial(self._episode, look, own.fading, turns)
        try:
            values = search(env, 0)
        except AlikeError as error:  # of all that the environment holds: something else decides, too
            raise error if self.state or own.state else UnfitError(f"{error}") from error
        count = len(values.transitions)
        source = f"all {count:,} states that can be reached by copies of the environment (in one episode)"
        return Atlas(values, search), look, source

    def _episode(
        self, state: State, fading: Callable[[_Env], Callable[[int], float]] | None, turns: int, env: _Env, turn: int
    ) -> Worths:
        """The values from a state on, with the time limits and the fading of this episode."""
        limit, share = min([turns, *time_limits(env)]), None if fading is None else fading(env)
        start = Start(env, state, turn, share or _whole, limit, self.gamma is not None)
        found = explore(start, self.states, self.steps)
        return self._values(limit, share, found)

    def _values(self, turns: int, fading: Callable[[int], float] | None, transitions: Transitions) -> Worths:
        if self.gamma is None and turns * len(transitions) > _MOST:
            raise PlanningError(
                f"{turns:,} turns of {len(transitions):,} states are over {_MOST:,} values; give max_turns or gamma"
            )
        rewards = {abs(each.reward) for row in transitions.values() for action in row for each in action} - {0.0}
        if not all(map(isfinite, rewards)) or (rewards and max(rewards) > _WIDEST * min(rewards)):
            raise PlanningError(
                f"rewards must be finite, and the greatest at most {_WIDEST:,.0f} times the least but 0, so that sums "
                f"can be compared; got {min(rewards)} and {max(rewards)}"
            )
        return Worths(transitions, turns if self.gamma is None else None, self.gamma, fading)


@dataclass(frozen=True)
class _Limited:
    """The key of a state, with the time limits of its episode."""

    state: State

    def __call__(self, env: _Env) -> tuple[Hashable, tuple[int, ...]]:
        return self.state(env), time_limits(env)


def _whole(turn: int) -> float:
    return 1.0


@dataclass(slots=True)
class _Told:
    """The claims about a state where actions differ."""

    verdicts: list[WellChosen | PoorlyChosen | Slower | None]
    """One for each action; None for actions whose loss is too small to mention."""
    advice: Choose | None
    """None if the first-ranked action may not be a best one."""
    warning: Avoid


class ExactOracle(Oracle[Position, GymWorld]):
    """Judges actions by their expected sum of rewards; it neither praises nor blames luck."""

    tier = "exact"
    instruction_types: ClassVar[tuple[str, ...]] = ("b", "p")

    def __init__(self, scratch: Callable[[], GymWorld]) -> None:
        super().__init__(scratch)
        self._of: Worths | None = None
        self._there: dict[tuple[int | None, Any], _Told | None] = {}
        """Cached claims by stage and state, from the values `_of`; without a stage nothing is known."""
        self._last: tuple[Position | None, int, _Told | None] = None, 0, None
        """The last result: truth, number of turns without an action, claims."""

    @cached_property
    def model(self) -> Atlas:
        """The knowledge about the environment."""
        model: Atlas = self.lab.model
        return model

    @property
    def max_importance(self) -> float:  # type: ignore[override]  # of this environment
        """The greatest difference between two actions."""
        return self.model.spread

    def start(self, truth: Position) -> None:
        """Explore the episode if its states are unknown."""
        self.model.at(truth, self.lab)

    def judge(self, moment: Moment[Position], kinds: Set[FeedbackType] = ALL_KINDS) -> tuple[Claim, ...]:
        """The true claims about a moment, whose action must have done what the plan says."""
        if moment.before is not None:
            self.model.check(moment)
        return super().judge(moment, kinds)

    def values(self, truth: Position) -> tuple[float, ...]:
        """The expected sum of rewards after each action, minus a small price of time that breaks ties."""
        values = self.model.at(truth, self.lab)
        return values.ranked(values.worths(truth.seen, truth.turn))

    def stated_values(self, truth: Position) -> tuple[float, ...]:
        """The expected sum of rewards after each action."""
        worths = self.model.at(truth, self.lab).worths(truth.seen, truth.turn)
        return tuple(worth.earned for worth in worths)

    def _basics(self, truth: Position) -> tuple[Claim, ...]:
        model, values = self.model, self.model.at(truth, self.lab)
        turns = values.horizon
        aim = Discounted(gamma=model.gamma) if turns is None else Total(turns=turns)  # type: ignore[arg-type]  # one is None
        fading = 0.0 if turns is None else values.share(0) - values.share(1)
        return (aim, *([Fading(part=fading)] if fading else []), Syntax(expected=self.lab.action_syntax))

    def _practice(self, truth: Position, rng: np.random.Generator) -> tuple[Claim, ...]:
        told = self._told_at(truth, Moment.opening(truth, truth.turn))
        if told is None:
            return ()
        pairs = {WellChosen: TriedWell, PoorlyChosen: TriedPoorly}
        verdicts = [told.verdicts[action] for action in rng.permutation(self.model.actions).tolist()]
        known = [(pairs[type(each)], each) for each in verdicts if each is not None and type(each) in pairs]
        return tuple(cls(action=each.action, answer=each.answer, lost=each.lost) for cls, each in known[:_TRIES])

    def _hindsight(self, claims: list[Claim], moment: Moment[Position], kinds: Set[FeedbackType]) -> None:
        told = self._told_at(moment.past, moment)
        if told is not None:
            verdict = told.verdicts[moment.action]
            if verdict is not None and verdict.kind in kinds:
                claims.append(verdict)

    def _advice(self, claims: list[Claim], moment: Moment[Position], kinds: Set[FeedbackType]) -> None:
        told = self._told_at(moment.after, moment)
        if told is not None:
            if FP in kinds and told.advice is not None:
                claims.append(told.advice)
            if FN in kinds:
                claims.append(told.warning)

    def _told_at(self, truth: Position, moment: Moment[Position]) -> _Told | None:
        """The claims about a state of a moment; None if no action loses anything."""
        last, then, told = self._last
        unread = moment.turn - moment.after.turn
        if truth is last and unread == then and not self.model.ended:
            return told
        values = self.model.at(truth, self.lab)
        if values is not self._of:
            self._of, self._there = values, {}
        turn = truth.turn if unread <= 0 else used(truth, moment, values)
        key = None if turn is None else values.stage(turn), truth.seen
        try:
            told = self._there[key]
        except KeyError:
            told = self._there[key] = None if turn is None else self._tell(*values.compared(truth.seen, turn))
        self._last = truth, unread, told
        return told

    def _tell(self, lost: Lost, ranks: list[float]) -> _Told | None:
        """The claims for these losses and ranks; see `Worths.compared`."""
        poor = [action for action, each in enumerate(lost) if each is not None and each != NOTHING]
        if not poor:
            return None
        best, worst = ranks.index(max(ranks)), min(poor, key=ranks.__getitem__)
        verdicts = [None if each is None else self._verdict(action, *each) for action, each in enumerate(lost)]
        advice = self._choices[best] if lost[best] == NOTHING else None
        blame: Any = verdicts[worst]
        warning = (_avoid if type(blame) is PoorlyChosen else _dawdle)(worst, blame.answer, blame.lost)
        return _Told(verdicts, advice, warning)

    def _verdict(self, action: int, earned: float, later: float) -> WellChosen | PoorlyChosen | Slower:
        if earned or later:
            return (_poorly if earned else _slower)(action, self._names[action], rounded(earned or later))
        return self._praises[action]

    @cached_property
    def _choices(self) -> list[Choose]:
        return [_choose(action, name) for action, name in enumerate(self._names)]

    @cached_property
    def _praises(self) -> list[WellChosen]:
        return [_well(action, name, 0.0) for action, name in enumerate(self._names)]

    @cached_property
    def _names(self) -> list[str]:
        return [answer_of(action, self.lab) for action in range(self.model.actions)]


_well, _poorly, _slower = fast_constructor(WellChosen), fast_constructor(PoorlyChosen), fast_constructor(Slower)
_choose, _avoid, _dawdle = fast_constructor(Choose), fast_constructor(Avoid), fast_constructor(Dawdle)


class CertainOracle(ExactOracle):
    """The oracle for deterministic environments; it can also state a whole plan."""

    instruction_types = ("b", "p", "c")

    def plan(self, truth: Position, n: int) -> tuple[int, ...]:
        """Best actions, until the episode is over or all actions are equally good."""
        values = self.model.at(truth, self.lab)
        return self._way(truth, n, values.ranked)

    def _way(self, truth: Position, n: int, rank: Callable[[tuple[Worth, ...]], tuple[Any, ...]]) -> tuple[int, ...]:
        """The first-ranked actions, until the episode is over or all actions have the same rank."""
        values, state = self.model.at(truth, self.lab), truth.seen
        actions: list[int] = []
        while len(actions) < n and state is not None:
            ranks = rank(values.worths(state, truth.turn + len(actions)))
            if max(ranks) == min(ranks):
                break
            actions.append(ranks.index(max(ranks)))
            ((_, state, _),) = values.transitions[state][actions[-1]]
        return tuple(actions)

    def _solution(self, truth: Position) -> tuple[Claim, ...]:
        values = self.model.at(truth, self.lab)
        actions = self._way(truth, values.horizon or len(values.transitions), values.exactly)
        return (route(actions, self.lab),) if actions else ()
