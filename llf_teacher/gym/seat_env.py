"""One seat of a session as a Gymnasium environment."""

import inspect
import sys
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import gymnasium
from gymnasium.envs.registration import EnvSpec
from gymnasium.error import ResetNeeded

from llf_teacher.registry import entry
from llf_teacher.speakers.parsing import with_teacher
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.student import Policy, Student
from pz_envs.assembly import assemble
from pz_envs.settings import RENDER_MODES, Settings
from pz_envs.subject import Subject
from pz_envs.window import FPS, Renderer
from teachers.atoms import Moment
from teachers.personality import Personality
from teachers.spec import is_count
from teachers.teacher import Teacher

_FRAMES = 6  # calls from `gymnasium.make` to here


class SeatEnv(gymnasium.Env):
    """The base of `StudentEnv` and `TeacherEnv`.

    Args:
        env_id: an id of `llf_teacher.ids()`, or a `Lesson`.
        settings: the settings of the lesson; None: the defaults.
        keywords: fields that replace them, and the world's options.
        refused: fields that this seat does not use.
        policies: whether `teacher` may be a policy for the teacher's seat.
        episodes: the number of the world's episodes in one of this seat.
        last_words: steps of each of them beside the student's turns.
        defaults: fields with other defaults at this seat.

    Raises:
        ValueError: an argument is not allowed.
    """

    metadata = {"render_modes": [*RENDER_MODES], "render_fps": FPS}  # noqa: RUF012 (Gymnasium's convention)

    def __init__(
        self,
        env_id: str | Subject,
        settings: Settings | None,
        keywords: Mapping[str, Any],
        *,
        refused: Iterable[str] = (),
        policies: bool = False,
        episodes: int = 1,
        last_words: int = 0,
        **defaults: Any,
    ) -> None:
        self.family: Subject
        options: Mapping[str, Any] = {}
        self._steps = episodes, last_words
        if (limit := _asked_limit()) is not None:
            turns = keywords.get("max_turns", settings and settings.max_turns)
            if (most := limit // episodes - last_words) < 1:
                least = episodes * (1 + last_words)
                raise ValueError(f"max_episode_steps must be at least {least} at this seat, got {limit}")
            keywords = {**keywords, "max_turns": shorter(most, turns)}
        if isinstance(env_id, Subject):
            self.env_id, self.family = env_id.name, env_id
        else:
            self.env_id, self.family, options, _ = entry(env_id)
        self.settings = Settings.of(
            self.env_id,
            {**options, **keywords},
            self.family.options(),
            given=settings,
            others=set(inspect.signature(type(self)).parameters) - {"env_id"},
            refused=refused,
            elsewhere=self.family.elsewhere,
            **defaults,
        )
        self.family = self.family.for_lesson(self.settings)
        self._policy: Any = None
        """The user's policy in the teacher's seat, if there is one."""
        lesson = with_teacher(self.settings, policies)
        if policies and not isinstance(lesson.teacher, Personality | Teacher):
            self._policy, lesson = lesson.teacher, lesson.with_teacher("oracle")
            if not (hasattr(self._policy, "reset") and hasattr(self._policy, "act")):
                remedy = f"; call it, as in {self._policy.__name__}()" if isinstance(self._policy, type) else ""
                raise ValueError(
                    "teacher must be a spec string, a Personality, or a policy with reset(rng) and "
                    f"act(observation, info), got {self._policy!r}{remedy}"
                )
        self.session, self.student_view, (self.teacher_view,) = assemble(self.family, lesson)
        self.render_mode = lesson.render_mode
        self._renderer = Renderer(self.render_mode, self.env_id, self.student_view.as_text, self.student_view.frame)
        self._running = False
        self._made_from: EnvSpec | None = None

    @property
    def reward_range(self) -> tuple[float, float]:
        """Least and greatest reward of one step of the world."""
        return self.session.world.reward_range

    @property
    def spec(self) -> EnvSpec | None:
        """The spec that it was made from, with the steps of an episode as `max_episode_steps`; None without one."""
        return self._made_from

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        episodes, last_words = self._steps
        self._made_from = spec and replace(spec, max_episode_steps=episodes * (self.session.max_turns + last_words))

    # For users' own loops.

    @property
    def moment(self) -> Moment[Any]:
        """The last moment, with the truths: privileged. `resume_from` and `start_next_episode` continue from it."""
        return self.session.moment

    def values(self) -> tuple[float, ...] | None:
        """The oracle's value of each action now: privileged; None without values, or after the end of the episode."""
        moment = self.session.moment
        return None if moment.over else self.session.teacher.oracle.values(moment.after)

    def seat(self, student: str | Student) -> Policy[Any]:
        """A policy for the student's seat of this environment; `reset(rng)` begins its episodes.

        Raises:
            ValueError: the student is unknown, or cannot play here.
        """
        return parse_student(student).seat(self.family, self.session.world)

    def seen_by(self, policy: Any) -> tuple[Any, dict[str, Any]]:
        """The present observation and info for a policy in the student's seat, in the form that its `act` takes."""
        return self.student_view.observe(), self.student_view.info_for(policy)

    def _restart(self, seed: int | None, options: dict[str, Any] | None) -> None:
        """Open an episode. Without a seed all streams go on."""
        self.session.world.check_reset(options)
        self._running = False
        self.session.open(seed, options)
        super().reset(seed=seed)

    def _check_running(self) -> None:
        if not self._running:
            raise ResetNeeded("the episode has not begun, or has ended; call reset() before step()")

    def render(self) -> Any:
        """Render by the render mode: a text, a frame or None; see `pz_envs.window.Renderer`."""
        return self._renderer.render()

    def close(self) -> None:
        """Close the window and the world."""
        self._renderer.close()
        self.session.world.close()


def shorter(limit: Any, turns: Any) -> Any:
    """The `max_turns` of a lesson with the argument `max_episode_steps`: the smaller number counts."""
    return min(limit, turns) if is_count(limit) and is_count(turns) else limit


def _asked_limit() -> int | None:
    """The argument `max_episode_steps` of the call of `gymnasium.make` that makes this environment; None without one.

    Gymnasium gives it to a `TimeLimit` around the environment alone, which would cut the teacher's last word off.

    Raises:
        ValueError: it is True.
    """
    frame = sys._getframe()
    for _ in range(_FRAMES):
        if frame.f_back is None:
            return None
        frame = frame.f_back
        if frame.f_code is gymnasium.make.__code__:
            given = frame.f_locals["max_episode_steps"]
            limit = frame.f_locals["env_spec"].max_episode_steps if given is None else given
            if limit is True:  # which is 1 for Gymnasium's own limit, and would cut the lesson without a last word
                raise ValueError("max_episode_steps must be an integer of at least 1, got True")
            return limit if is_count(limit) else None
    return None
