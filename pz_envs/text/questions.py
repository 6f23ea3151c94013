"""Questions: actions of a student that ask the teacher and do not act in the world."""

import re
from contextlib import suppress
from typing import Any

from gymnasium import spaces

from pz_envs.text.answer_place import find_place
from pz_envs.text.thoughts import SplitReply, split_thought
from worlds.actions import canonical
from worlds.spaces import Prose

ASK = "ask"
"""The text of a question, and the key that marks one in an action."""
_LONGEST = 1000  # characters of a question
_ASK = re.compile(rf"\W*{ASK}\W*", re.IGNORECASE)


def asking_space(space: spaces.Space[Any]) -> spaces.Space[Any]:
    """The action space of a student that may ask.

    `Discrete(n)` becomes `Discrete(n + 1)`, and its greatest number asks. Text stays text, and the word `ask` asks. Any
    other space becomes a Dict of `action`, the space, and `ask`, Discrete(2); with `ask` 1 the action does not count.
    There a plain action of the space asks nothing, so that students that never ask play unchanged.
    """
    if isinstance(space, spaces.Discrete):
        return spaces.Discrete(int(space.n) + 1, start=int(space.start))
    if isinstance(space, Prose | spaces.Text):
        return space
    return spaces.Dict({"action": space, ASK: spaces.Discrete(2)})


def read_question(action: Any, space: spaces.Space[Any]) -> tuple[bool, Any]:
    """Whether an action asks, and the world's action within it.

    Args:
        action: the student's action; a text may come as a `SplitReply`.
        space: `asking_space` of the student's action space.

    Raises:
        ValueError: the action is outside the space.
    """
    if isinstance(space, spaces.Discrete):
        last = int(space.start) + int(space.n) - 1
        return bool(isinstance(action, str) is False and space.contains(action) and int(action) == last), action
    if isinstance(space, Prose | spaces.Text):
        said = split_thought(action).answer if isinstance(action, str | SplitReply) else ""
        return len(said) < _LONGEST and _ASK.fullmatch(find_place(said).said) is not None, action
    with suppress(ValueError, TypeError, OverflowError):  # an action of a student that never asks
        canonical(space["action"], action)  # type: ignore[index]  # the space is a Dict
        return False, action
    if not isinstance(action, dict) or action.keys() != {"action", ASK} or action[ASK] not in (0, 1):
        raise ValueError(
            f"the action of a student that may ask must be a dict of `action` and `{ASK}` (0 or 1), "
            f"got {action!r:.80}; the state is unchanged"
        )
    return bool(action[ASK]), action["action"]
