"""BabyAI's levels of MiniGrid, with MiniGrid's bot as their expert."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import gymnasium

from teachers.planning.known.minigrid import KNOWN as MINIGRID
from teachers.planning.planner import PlanningError


class _Bot:
    """MiniGrid's `BabyAIBot`. It plans anew after each action, its own or not."""

    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        from minigrid.envs.babyai.unlock import KeyInBox
        from minigrid.utils.baby_ai_bot import BabyAIBot

        bare: Any = env.unwrapped
        if isinstance(bare, KeyInBox) or bare.carrying is not None:
            raise PlanningError(
                "MiniGrid's bot fails at levels in which a key is in a box, or something is carried at the start "
                "(KeyInBox, PutNext...Carrying); write an expert of your own, and pass it as oracle=Expert(policy=...)"
            )
        self._bot: Any = BabyAIBot(env)  # type: ignore[no-untyped-call]  # of MiniGrid
        self._taken = self._answer = None

    def __call__(self, observation: Any, info: Mapping[str, Any]) -> Any:
        if self._answer is None:
            self._answer = self._bot.replan(self._taken)
        return self._answer

    def took(self, action: Any) -> None:
        """Note an action, for the next plan."""
        self._taken, self._answer = action, None


KNOWN = replace(MINIGRID, expert=_Bot)
