"""Teaching in any Gymnasium environment, and observations as one text."""

from collections.abc import Callable, Mapping
from typing import Any, Unpack

import gymnasium

from llf_teacher.gym.student_env import StudentEnv
from pz_envs.lesson import Lesson
from pz_envs.settings import Settings, SettingsKeywords
from teachers.oracle import Oracle
from teachers.phrasebook import Phrases
from teachers.planning import Planner
from teachers.spec import is_count


def teach(
    env: gymnasium.Env | Callable[[], gymnasium.Env],
    oracle: Callable[..., Oracle] | Planner | str | None = None,
    *,
    phrases: Phrases | None = None,
    look: Callable[[gymnasium.Env], Any] | None = None,
    snapshot: str = "auto",
    success: Callable[..., Any] | None = None,
    describe: Callable[[Any], str] | None = None,
    action_words: Mapping[str, Any] | None = None,
    reward_range: tuple[float, float] | None = None,
    settings: Settings | None = None,
    **keywords: Unpack[SettingsKeywords],
) -> StudentEnv:
    """The student's seat of any Gymnasium environment, with a teacher in the other seat.

    Without an oracle this is reinforcement learning in words: the instruction is to maximize the accumulated rewards,
    and the feedback is the reward. The attribute `family` is the `Lesson`.

    Args:
        env: an environment, or a function without arguments that makes one.
        oracle: `auto` for a planned teacher if the environment allows it, otherwise for rewards in words, with a
            warning that names what would give more; a planner of `teachers.planning`; or a subclass of
            `teachers.oracle.Oracle`.
        phrases: the oracle's phrases: a dict of lists by claim class or by its name, or the path of a TOML file.
        look, snapshot, success, describe, action_words, reward_range: see `worlds.wrapped.gym_world.GymWorld`.
        settings, keywords: as of `StudentEnv`.

    Raises:
        ValueError: an argument is not allowed.
    """
    turns = keywords.get("max_turns", settings and settings.max_turns)
    lesson = Lesson(
        env,
        oracle,
        phrases=phrases,
        look=look,
        snapshot=snapshot,
        success=success,
        describe=describe,
        action_words=action_words,
        reward_range=reward_range,
        max_turns=turns if is_count(turns) else None,  # anything else is refused below
    )
    return StudentEnv(lesson, settings=settings, **keywords)


def prompt(observation: dict[str, Any]) -> str:
    """Instruction, observation and feedback of a text observation, joined by blank lines; empty parts are left out."""
    parts = (observation[key] for key in ("instruction", "observation", "feedback"))
    return "\n\n".join(str(part) for part in parts if part)
