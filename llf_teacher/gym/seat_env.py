"""One seat of a `TutoringEnv` as a Gymnasium environment."""

from typing import Any

import gymnasium
from gymnasium.error import ResetNeeded

from llf_teacher.registry import entry
from pz_envs.seatings.tutoring import SEATING as TUTORING
from pz_envs.subject import Subject, settings_of
from teachers.spec import unknown


class SeatEnv(gymnasium.Env):
    """What `StudentEnv` and `TeacherEnv` have in common; the other seat is theirs to fill."""

    metadata = {"render_modes": ["ansi", "human", "rgb_array"], "render_fps": 4}  # noqa: RUF012 (Gymnasium's convention)

    def __init__(
        self, seat: str, env_id: str | Subject, max_turns: int | None, render_mode: str | None, **settings: Any
    ) -> None:
        self.family: Subject
        options: dict[str, Any] = {}
        if isinstance(env_id, Subject):
            self.env_id, self.family = env_id.name, env_id
        else:
            self.env_id, self.family, options, _ = entry(env_id)
        known = {*settings_of(type(self), TUTORING.raw_env), *self.family.options()}
        allowed = sorted(known - {"env_id", "max_cycles", "subject"})
        if unknown_names := [name for name in settings if name not in allowed]:
            raise ValueError(
                f"{self.env_id} does not take these options: {unknown('option', unknown_names[0], allowed)}"
            )
        self.aec = TUTORING.raw_env(
            self.family, max_cycles=max_turns, render_mode=render_mode, **{**options, **settings}
        )
        self.aec.label = self.env_id
        self.render_mode = render_mode
        self.action_space = self.aec.action_space(seat)
        self._running = False

    @property
    def reward_range(self) -> tuple[float, float]:
        """Least and greatest reward that the world pays for one step."""
        return self.aec.world.reward_range

    def _restart(self, seed: int | None, options: dict[str, Any] | None) -> None:
        """Reset the seats. Without a seed all streams go on."""
        self.aec.world.check_reset(options)  # which at PettingZoo's doors are ignored where they are unknown
        self.aec.reset(seed, options)
        super().reset(seed=seed)
        self._running = True

    def _check_running(self) -> None:
        if not self._running:
            raise ResetNeeded("the episode has not begun, or has ended; call reset() before step()")

    def render(self) -> Any:
        """What `SeatsEnv.render` gives: a text, a frame or nothing, as the render mode has it."""
        return self.aec.render()

    def close(self) -> None:
        """Close the world."""
        self.aec.close()
