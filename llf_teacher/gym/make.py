"""Environments by their ids."""

from typing import Any, Unpack

import gymnasium

from llf_teacher.gym.student_env import NOT_SEATED, StudentEnv
from llf_teacher.registry import entry
from pz_envs.settings import Settings, SettingsKeywords, takes_settings


@takes_settings(without=NOT_SEATED)
def make(id: str, *, settings: Settings | None = None, **keywords: Unpack[SettingsKeywords]) -> StudentEnv:
    """The student's seat of an environment, with a teacher in the other seat.

    Args:
        id: an id of `ids()`, its alias `verbal-...`, or one of Gymnasium's registry with the prefix `gym:`, as in
            `gym:FrozenLake-v1` or `gym:package.module:ID`, with the arguments of `gymnasium.make` as options, and
            `oracle`, such as `"exact(gamma=0.95)"`.
        settings: the settings of the lesson; None: the defaults.
        keywords: fields of `pz_envs.settings.Settings` that replace them, such as `teacher`, `feedback_type` or `text`,
            and the world's options.

    Raises:
        ValueError: the id is unknown, or an argument is not allowed.
    """
    given: dict[str, Any] = {**keywords} if settings is None else {"settings": settings, **keywords}
    found = entry(id)
    if found.id not in gymnasium.registry:
        return StudentEnv(found.id, **given)
    env: StudentEnv = gymnasium.make(found.id, **given)  # type: ignore[assignment]  # it has no wrapper
    return env
