"""MiniGrid: rooms on a grid; the student sees the part ahead of it."""

from collections.abc import Callable, Hashable
from typing import Any

import gymnasium

from teachers.planning.known import Known

_Env = gymnasium.Env[Any, Any]
_HEADINGS = ("east", "south", "west", "north")
_THINGS = ("unseen", "empty", "wall", "floor", "door", "key", "ball", "box", "goal", "lava", "agent")
_COLORS = ("red", "green", "blue", "purple", "yellow", "grey")
_DOORS = ("open", "closed", "locked")
_WALL, _DOOR = _THINGS.index("wall"), _THINGS.index("door")
_DULL = {0, 1, 2, 3, 10}  # unseen, empty, wall, floor, the agent itself
_FADES = 0.9  # of the reward, over all steps of an episode


def _thing(thing: Any) -> Hashable:
    """An object with its content."""
    return None if thing is None else (*map(int, thing.encode()), _thing(getattr(thing, "contains", None)))


def _state(env: _Env) -> Hashable:
    """Grid, agent and carried object. MiniGrid's own hash omits the carried object and the content of boxes."""
    bare: Any = env.unwrapped
    x, y = map(int, bare.agent_pos)
    return tuple(map(_thing, bare.grid.grid)), x, y, int(bare.agent_dir), _thing(bare.carrying), bare.mission


def _fading(env: _Env) -> Callable[[int], float]:
    return _Fading(int(env.get_wrapper_attr("max_steps")))


class _Fading:
    """The factor of a reward after so many actions."""

    def __init__(self, steps: int) -> None:
        self._steps = steps

    def __call__(self, turn: int) -> float:
        return 1 - _FADES * (turn + 1) / self._steps


def _describe(observation: Any) -> str:
    """The visible objects, the farthest first."""
    image = observation["image"]
    width, height, _ = image.shape
    seen = [
        f"{_where(height - 1 - y, x - width // 2)}: {_words(*map(int, image[x, y]))}"
        for y in range(height)
        for x in range(width)
        if int(image[x, y, 0]) not in _DULL
    ]
    wall = next((ahead for ahead in range(1, height) if int(image[width // 2, height - 1 - ahead, 0]) == _WALL), None)
    return (
        f"Your mission: {observation['mission']}. You face {_HEADINGS[int(observation['direction'])]}"
        f"{'' if wall is None else f', with a wall {wall} ahead'}. You see {'; '.join(seen) or 'nothing else'}."
    )


def _where(ahead: int, side: int) -> str:
    """A place relative to the agent; the agent's own place shows the carried object."""
    parts = [f"{ahead} ahead"] * (ahead > 0) + [f"{abs(side)} to the {'right' if side > 0 else 'left'}"] * (side != 0)
    return " and ".join(parts) or "with you"


def _words(kind: int, color: int, state: int) -> str:
    return f"a {_COLORS[color]} {_THINGS[kind]}{f', {_DOORS[state]}' if kind == _DOOR else ''}"


KNOWN = Known(
    describe=_describe,
    state=_state,
    fading=_fading,
    hides=True,
    free=frozenset({"_gen_grid", "_gen_mission"}),
)
