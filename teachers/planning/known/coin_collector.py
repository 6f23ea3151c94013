"""TextWorld's coin collector, with TextWorld's `policy_commands` as its expert."""

from collections.abc import Mapping
from typing import Any

import gymnasium

from teachers.planning.known import Known
from worlds.wrapped.coin_collector import COMMANDS


class _Walker:
    """Gives the first of the commands that lead to the coin."""

    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        self._env: Any = env.unwrapped

    def __call__(self, observation: Any, info: Mapping[str, Any]) -> int:
        return COMMANDS.index(self._env.policy_commands()[0])


KNOWN = Known(
    action_words={command: action for action, command in enumerate(COMMANDS)}, describe=str, expert=_Walker, hides=True
)
