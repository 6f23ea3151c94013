"""Oracles for environments that bring none: they plan, and say no more than their tier of planning knows."""

from typing import Any

import gymnasium

from teachers.planning.exact import Exact
from teachers.planning.expert import Expert
from teachers.planning.planner import Planned, Planner, PlanningError

__all__ = ["TIERS", "Auto", "Exact", "Expert", "Planned", "Planner", "PlanningError", "parse_planner"]

TIERS: dict[str, type[Planner]] = {
    "exact": Exact,
    "expert": Expert,
}
"""Planners by name, those that know the most first."""


class Auto(Planner):
    """The highest tier that serves an environment."""

    def plan(self, env: gymnasium.Env[Any, Any], turns: int) -> Planned:
        """Try each tier."""
        reasons = []
        for name, planner in TIERS.items():
            try:
                return planner().plan(env, turns)
            except PlanningError as error:
                reasons.append(f"{name}: {error}")
        raise PlanningError(
            f"no tier of planning serves {env}; {'; '.join(reasons)}; leave out oracle=... for rewards in words, or "
            "write an oracle (docs/teach-your-own-environment.md)"
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
