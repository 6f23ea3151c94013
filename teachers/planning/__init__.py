"""Oracles for environments that bring none: they plan, and say no more than their tier of planning knows."""

from collections.abc import Callable
from typing import Any

import gymnasium

from teachers.planning.exact import Exact
from teachers.planning.planner import Planned, Planner, PlanningError
from teachers.planning.searched import Searched

__all__ = ["TIERS", "Auto", "Exact", "Planned", "Planner", "PlanningError", "Searched", "parse_planner"]

TIERS: dict[str, type[Planner]] = {
    "exact": Exact,
    "searched": Searched,
}
"""Planners by name, those that know the most first."""


class Auto(Planner):
    """The first of the tiers that serves an environment, each with its default options."""

    def plan(self, env: gymnasium.Env[Any, Any], turns: int, success: Callable[..., Any] | None = None) -> Planned:
        """Try each tier."""
        reasons = []
        for name, planner in TIERS.items():
            try:
                return planner().plan(env, turns, success)
            except PlanningError as error:
                reasons.append(f"\n- {name}: {error}")
        raise PlanningError(
            f"no tier of planning serves {env}:{''.join(reasons)}\nFollow one of these hints, leave out oracle=... for "
            "rewards in words, or write an oracle (docs/teach-your-own-environment.md)"
        )


def parse_planner(name: str) -> Planner:
    """The planner of this name.

    Raises:
        ValueError: there is none.
    """
    known: dict[str, type[Planner]] = {"auto": Auto, **TIERS}
    if name not in known:
        raise ValueError(
            "oracle must be a subclass of teachers.oracle.Oracle, or a function that makes an oracle, a planner, or "
            f"the name of one ({', '.join(known)}), got {name!r}"
        )
    return known[name]()
