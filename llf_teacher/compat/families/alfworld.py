"""ALFWorld as LLF-Bench has it: its texts contain the phrases that existing code looks for."""

from typing import Any

from llf_teacher.compat.env import LLFEnv


class Surface(LLFEnv):
    """The task comes after "Your task is to:", commands after "You are allowed to take the following actions:"."""

    def _observe(self, text: str) -> Any:
        world = self._world
        commands = ", ".join(world.commands())
        return f"{world.truth.feedback.rstrip('.')}. You are allowed to take the following actions: {commands}."

    def _instruct(self, instruction: str) -> str:
        return f"Your task is to: {self._world.truth.game.goal}. {instruction}"
