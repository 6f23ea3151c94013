"""Asking: an action of the student that is a question to the teacher, not an action of the world."""

import re
from contextlib import suppress
from typing import Any

from gymnasium import spaces

from pz_envs.answers import Parted, split_thought
from worlds.actions import canonical
from worlds.spaces import Prose

ASK = "ask"
"""The text that asks, and the key of an action that may ask."""
_ASK = re.compile(rf"(.*response:)?\W*{ASK}\W*", re.IGNORECASE | re.DOTALL)


def asking_space(space: spaces.Space[Any]) -> spaces.Space[Any]:
    """The action space of a student that may ask.

    Of `Discrete(n)` it is `Discrete(n + 1)`, whose greatest number asks. Text stays text, and the word `ask` asks. Of
    any other space it is a Dict of `action`, the space, and `ask`, Discrete(2); with 1 the action does not count. A
    plain action of the space is also accepted there and does not ask, so that students that never ask can play.
    """
    if isinstance(space, spaces.Discrete):
        return spaces.Discrete(int(space.n) + 1, start=int(space.start))
    if isinstance(space, Prose | spaces.Text):
        return space
    return spaces.Dict({"action": space, ASK: spaces.Discrete(2)})


def read_question(action: Any, space: spaces.Space[Any]) -> tuple[bool, Any]:
    """Whether an action asks, and the action of the world in it.

    Args:
        action: an action of a student that may ask; a text may be `Parted`.
        space: `asking_space` of the student's action space.

    Raises:
        ValueError: it is outside the space.
    """
    if isinstance(space, spaces.Discrete):
        last = int(space.start) + int(space.n) - 1
        return bool(isinstance(action, str) is False and space.contains(action) and int(action) == last), action
    if isinstance(space, Prose | spaces.Text):
        said = split_thought(action).answer if isinstance(action, str | Parted) else ""
        return 0 < len(said) < 1000 and _ASK.fullmatch(said) is not None, action
    with suppress(ValueError, TypeError, OverflowError):  # an action of a student that never asks
        canonical(space["action"], action)  # type: ignore[index]  # the space is a Dict
        return False, action
    if not isinstance(action, dict) or action.keys() != {"action", ASK} or action[ASK] not in (0, 1):
        raise ValueError(
            f"the action of a student that may ask must be a dict of `action` and `{ASK}` (0 or 1), "
            f"got {action!r:.80}; the state is unchanged"
        )
    return bool(action[ASK]), action["action"]
