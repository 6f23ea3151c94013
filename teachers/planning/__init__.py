"""Planned oracles for environments without one; the tier of planning limits what they say."""

import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import gymnasium

from teachers.planning.exact import Exact
from teachers.planning.expert import Expert
from teachers.planning.known import Known, known, words_of
from teachers.planning.planner import (
    REWARDS,
    Planned,
    Planner,
    PlanningError,
    RewardsOnlyWarning,
    UnfitError,
    check_steps,
    guarded,
)
from teachers.reward_oracle import RewardOracle
from teachers.spec import parse_call

__all__ = [
    "TIERS",
    "Auto",
    "Exact",
    "Expert",
    "Planned",
    "Planner",
    "PlanningError",
    "parse_planner",
    "survey",
]

_Env = gymnasium.Env[Any, Any]

TIERS: dict[str, type[Planner]] = {
    "exact": Exact,
    "expert": Expert,
}
"""Planners by name; the one that knows most comes first."""


class Auto(Planner):
    """Uses the first tier that serves an environment, with its default options; if none does, rewards alone."""

    def plan(
        self, env: _Env, turns: int, success: Callable[..., Any] | None = None, other: _Env | None = None
    ) -> Planned:
        """Try each tier; if none serves, warn of the reasons.

        Raises:
            PlanningError: the environment cannot be reset and stepped.
        """
        refused: dict[str, str] = {}
        try:
            guarded(env, lambda: check_steps(env), other)
            for name, planner in TIERS.items():
                try:
                    return replace(planner().plan(env, turns, success, other), refused=refused)
                except UnfitError:
                    raise
                except PlanningError as error:
                    refused[name] = f"{error}"
        except UnfitError as error:
            refused |= {name: f"{error}" for name in TIERS if name not in refused}
        return self.rewards_only(env, success, refused)

    _plan = plan  # each tier is guarded by itself

    @staticmethod
    def rewards_only(env: _Env, success: Callable[..., Any] | None, refused: dict[str, str]) -> Planned:
        """The plan of a teacher that states rewards, with a warning that has the reasons."""
        reasons = "".join(f"\n- {name}: {reason}" for name, reason in refused.items())
        own = known(env) or Known()
        note = own.unlike and f"\nNote: {own.unlike}"
        warnings.warn(
            f"no tier of planning serves {env}:{reasons}{note}\nThe teacher says what was paid, and no more. For more, "
            "follow one of these hints, or write an oracle (docs/teach-your-own-environment.md). If rewards are all "
            "that you want, leave out oracle=... (in a study or a command, set oracle='rewards')",
            RewardsOnlyWarning,
            stacklevel=3,
        )
        return Planned(
            tier=REWARDS,
            why="no tier of planning serves the environment",
            oracle=RewardOracle,
            phrases={},
            look=None,
            model=None,
            action_words=words_of(env, own),
            describe=own.describe,
            success=success or own.success,
            copies=False,
            refused=refused,
        )


def survey(env: _Env, turns: int, asked: Planner | None = None) -> dict[str, Planned | PlanningError]:
    """The plan of each tier for an environment, or the reason why it does not serve.

    Args:
        env: the environment.
        turns: most turns of an episode.
        asked: the planner to ask; None or `Auto`: each tier with its default options, the highest first.
    """
    found: dict[str, Planned | PlanningError] = {}
    planners = {name: planner() for name, planner in TIERS.items()}
    if asked is not None and not isinstance(asked, Auto):
        planners = {name: asked for name, planner in TIERS.items() if isinstance(asked, planner)}
    for name, planner in planners.items():
        try:
            found[name] = planner.plan(env, turns)
        except PlanningError as error:
            found[name] = error
    return found


def parse_planner(spec: str) -> Planner:
    """The planner of a spec string, such as `auto` or `exact(gamma=0.95)`.

    Raises:
        ValueError: the spec names no planner.
    """
    known: dict[str, type[Planner]] = {"auto": Auto, **TIERS}
    call = parse_call(
        "oracle", spec, f"the name of a planner, such as `auto` or `exact(gamma=0.95)`; names: {', '.join(known)}"
    )
    if call.name not in known:
        raise ValueError(
            "oracle must be a subclass of teachers.oracle.Oracle, or a function that makes an oracle, a planner, or "
            f"the name of one ({', '.join(known)}; in options and commands also rewards), got {spec!r}"
        )
    return call.make("oracle", known[call.name])
