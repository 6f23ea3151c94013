"""The expert tier: a policy knows what to do, and roll-outs measure what other actions lose against it."""

import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Set
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces

from teachers.atoms import FN, FP, HN, HP, Claim, FeedbackType, Moment
from teachers.common import Maximize, Syntax
from teachers.oracle import Oracle
from teachers.planning.expert.asking import ExpertError, ReplayError, Same, policy_of
from teachers.planning.expert.claims import (
    Ahead,
    Around,
    Behind,
    Costs,
    Followed,
    Guided,
    Neared,
    Would,
    answer_of,
    is_real,
    shown,
)
from teachers.planning.expert.guide import Guide, Lead
from teachers.planning.expert.trial import try_out
from teachers.planning.known import Known, known, words_of
from teachers.planning.planner import Planned, Planner, PlanningError, check_steps
from teachers.planning.visible import privileged
from worlds.wrapped.generators import sealed
from worlds.wrapped.gym_world import GymWorld, Position

_Env = gymnasium.Env[Any, Any]
_TOLERANCE = 0.05  # for numbers from -1 to 1, or without bounds
_FEWEST = 8  # pairs of roll-outs, where something is left to chance


@dataclass(frozen=True)
class Expert(Planner):
    """Asks an expert, and follows it in roll-outs.

    The teacher does not call the expert's actions best or good. It measures what an action gains or loses against them
    by roll-outs from the same state, in copies of the environment (or replays) with draws of their own, since the
    teacher must not know future draws. A comparison of two actions uses the same draws for both.

    Args:
        policy: a function `(observation, info) -> action`, or a model of Stable-Baselines3; it must be deterministic,
            and have no memory. None: the expert of `teachers.planning.known`.
        rollouts: pairs of roll-outs for each comparison, at least 8; one pair suffices if the environment seems
            deterministic and neither roll-out draws random numbers.
        horizon: most actions of a roll-out. None: 100, or the number in `teachers.planning.known`; at most the length
            of an episode.
        tolerance: largest difference between a real number of an action and the expert's, in units of the action, that
            counts as equal. None: 0.05, or a fortieth of the smallest range of such a number, if that is less.
        margin: smallest difference of the sums of rewards to speak about.
        others: number of actions that roll-outs try in each state, in search of a worse one than the expert's.
    """

    policy: Any = None
    rollouts: int = 16
    horizon: int | None = None
    tolerance: float | None = None
    margin: float = 0.001
    others: int = 2

    def __post_init__(self) -> None:
        if self.policy is not None:
            policy_of(self.policy)
        for name, least in (("rollouts", _FEWEST), ("horizon", 1), ("others", 0)):
            value = getattr(self, name)
            if not (value is None and name == "horizon") and (type(value) is not int or value < least):
                raise ValueError(f"{name} must be an integer of at least {least}, got {value!r}")
        for name in ("tolerance", "margin"):
            value = getattr(self, name)
            if not (value is None and name == "tolerance") and (
                type(value) not in (int, float) or not 0 < value < float("inf")
            ):
                raise ValueError(f"{name} must be a positive number, got {value!r}")

    def _plan(self, env: _Env, turns: int, success: Callable[..., Any] | None) -> Planned:
        """Try the expert, and test whether the environment is deterministic."""
        check_steps(env)
        listed = known(env)
        own = listed or Known()
        make = own.expert if self.policy is None else Same(policy_of(self.policy))
        if make is None:
            raise PlanningError(
                "no expert is known; pass oracle=Expert(policy=f) of teachers.planning, where f(observation, info) "
                "returns an action, or a model of Stable-Baselines3"
            )
        least = min(_ranges(env.action_space), default=inf)
        if self.tolerance is not None and self.tolerance >= least / 2:
            raise PlanningError(
                f"tolerance={self.tolerance} says nothing of an action with a number that ranges over {least:.3g}; "
                f"allowed: less than {least / 2:.3g}"
            )
        certain, hidden = try_out(env, make), sealed(env)
        certain = certain and not hidden
        guide = Guide(
            make,
            rollouts=self.rollouts,
            certain=certain,
            horizon=self.horizon or min(own.horizon, turns),
            tolerance=self.tolerance or min(_TOLERANCE, least * _TOLERANCE / 2),
            margin=self.margin,
            others=self.others,
        )
        whose = "that is known for it" if self.policy is None else "that was given"
        chance = "nothing was found to be left to chance" if certain else f"{guide.rollouts} for each comparison"
        chance += hidden and f", for {hidden}, into which Python cannot look, may draw random numbers"
        return Planned(
            tier="expert",
            why=f"an expert {whose}, and roll-outs of at most {guide.horizon} actions ({chance})",
            size=f"{'1 roll-out' if certain else f'{guide.rollouts} roll-outs'} of {guide.horizon} actions",
            objective=f"the sum of rewards, compared over at most {guide.horizon:,} actions",
            oracle=CertainExpertOracle if certain else ExpertOracle,
            phrases=Path(__file__).with_name("phrases.toml"),
            look=None,
            model=guide,
            action_words=words_of(env, own),
            describe=own.describe,
            success=success or own.success,
            privileged=privileged(env, listed),
        )


def _ranges(space: spaces.Space[Any]) -> Iterator[float]:
    """The widths of the ranges of an action's real numbers that are bounded and not 0."""
    if isinstance(space, spaces.Box) and space.dtype.kind == "f":
        found = space.high.astype(float) - space.low.astype(float)
        yield from found[(found > 0) & np.isfinite(found)].tolist()
    for part in _parts(space):
        yield from _ranges(part)


def _parts(space: spaces.Space[Any]) -> Iterable[spaces.Space[Any]]:
    if isinstance(space, spaces.Dict):
        return space.spaces.values()
    if isinstance(space, spaces.Tuple | spaces.OneOf):
        return space.spaces
    return (space.feature_space,) if isinstance(space, spaces.Sequence) else ()


class ExpertWarning(UserWarning):
    """The teacher omits a claim in a turn: the expert gave no answer, or could not be followed."""


class ExpertOracle(Oracle[Position, GymWorld]):
    """Says what an expert would do, and what roll-outs measured for other actions. It has no values."""

    tier = "expert"
    instruction_types: ClassVar[tuple[str, ...]] = ("b",)

    def __init__(self, scratch: Callable[[], GymWorld]) -> None:
        super().__init__(scratch)
        self.silences: Counter[str] = Counter()
        """How often a claim was omitted, by the reason."""

    @property
    def guide(self) -> Guide:
        """The knowledge about the environment."""
        guide: Guide = self.lab.model
        return guide

    def _basics(self, truth: Position) -> tuple[Claim, ...]:
        return Maximize(), Guided(horizon=self.guide.horizon), Syntax(expected=self.lab.action_syntax)

    def _hindsight(self, claims: list[Claim], moment: Moment[Position], kinds: Set[FeedbackType]) -> None:
        if kinds & {HP, HN}:
            verdict = self._unless_silent(
                "praise or blame", moment, self._verdict, moment.past, moment.action, moment.after
            )
            if verdict is not None and verdict.kind in kinds:
                claims.append(verdict)

    def _advice(self, claims: list[Claim], moment: Moment[Position], kinds: Set[FeedbackType]) -> None:
        if FP in kinds and (advice := self._unless_silent("advice", moment, self._would, moment.after)):
            claims.append(advice)
        if FN in kinds and (warning := self._unless_silent("warning", moment, self._warning, moment.after)):
            claims.append(warning)

    def _unless_silent(
        self, what: str, moment: Moment[Position], find: Callable[..., Claim | None], *of: Any
    ) -> Claim | None:
        """The result of `find`; None, with a warning, if the expert cannot be asked or followed."""
        if self.guide.ended:
            return None
        try:
            return find(*of)
        except ExpertError as error:
            if isinstance(error, ReplayError):
                self.guide.ended = f"{error}"
            self.silences[f"{error}"] += 1
            if self.silences[f"{error}"] == 1:
                lasting = ", nor any later" if self.guide.ended else ""
                warnings.warn(
                    f"there is no {what} in turn {moment.turn}{lasting}: {error}", ExpertWarning, stacklevel=2
                )
            return None

    def _would(self, truth: Position) -> Claim:
        action = self.guide.said(self.guide.action(truth, self.lab), self.lab)
        if is_real(action):
            return Around(action=action, answer=answer_of(action, self.lab), tolerance=self.guide.tolerance)
        return Would(action=action, answer=answer_of(action, self.lab))

    def _worse(self, truth: Position, own: Any) -> tuple[Any, Lead] | None:
        """An action that earns less than the expert's, with the difference; None if none is found."""
        for action in self.guide.candidates(truth, self.lab, own, self.guide.others):
            lead = self.guide.measure(truth, self.lab, action, own)
            if lead is not None and lead.more < 0:
                return action, lead
        return None

    def _warning(self, truth: Position) -> Claim | None:
        found = self._worse(truth, self.guide.action(truth, self.lab))
        return None if found is None else Costs(**self._measured(*found))

    def _verdict(self, truth: Position, action: Any, after: Position) -> Claim | None:
        self.guide.check(after, self.lab)  # what came of the action is what comes of it in roll-outs
        own = self.guide.action(truth, self.lab)
        if not self.guide.alike(own, action):
            lead = self.guide.measure(truth, self.lab, action, own)
            return None if lead is None else (Ahead if lead.more > 0 else Behind)(**self._measured(action, lead))
        found = self._worse(truth, own)
        lead = None if found is None else self.guide.measure(truth, self.lab, action, found[0])
        if found is None or lead is None or lead.more < 0:
            return None
        fields = {**self._measured(action, lead), "other": found[0], "instead": answer_of(found[0], self.lab)}
        return Neared(**fields, tolerance=self.guide.tolerance) if is_real(action) else Followed(**fields)

    def _measured(self, action: Any, lead: Lead) -> dict[str, Any]:
        basis = {"rollouts": lead.rollouts, "horizon": self.guide.horizon}
        return {"action": action, "answer": answer_of(action, self.lab), "amount": abs(lead.more), **basis}


class CertainExpertOracle(ExpertOracle):
    """The oracle for deterministic environments; it can also demonstrate a whole episode of the expert."""

    instruction_types = ("b", "c")

    def _solution(self, truth: Position) -> tuple[Claim, ...]:
        way = self._unless_silent("example", Moment.opening(truth), self._way, truth)
        return () if way is None else (way,)

    def _way(self, truth: Position) -> Claim:
        return shown(self.guide.demonstrate(truth, self.lab, self.guide.horizon), self.lab)
