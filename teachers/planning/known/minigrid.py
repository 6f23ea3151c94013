"""MiniGrid: rooms on a grid, of which the student sees what is ahead."""

from collections.abc import Callable, Hashable, Iterator, Mapping
from functools import lru_cache
from typing import Any

import gymnasium
import networkx as nx

from teachers.planning.known import Known

_Env = gymnasium.Env[Any, Any]
_HEADINGS = ("east", "south", "west", "north")
_THINGS = ("unseen", "empty", "wall", "floor", "door", "key", "ball", "box", "goal", "lava", "agent")
_COLORS = ("red", "green", "blue", "purple", "yellow", "grey")
_DOORS = ("open", "closed", "locked")
_WALL, _DOOR = _THINGS.index("wall"), _THINGS.index("door")
_DULL = {0, 1, 2, 3, 10}  # unseen, empty, wall, floor, the agent itself
_AHEAD = ((1, 0), (0, 1), (-1, 0), (0, -1))  # by direction
_FADES = 0.9  # of the reward, over all steps of an episode


def _thing(thing: Any) -> Hashable:
    """A thing with what is in it."""
    return None if thing is None else (*map(int, thing.encode()), _thing(getattr(thing, "contains", None)))


def _state(env: _Env) -> Hashable:
    """Grid, agent and what it carries; MiniGrid's own hash leaves out what is carried, and what is in boxes."""
    bare: Any = env.unwrapped
    x, y = map(int, bare.agent_pos)
    return tuple(map(_thing, bare.grid.grid)), x, y, int(bare.agent_dir), _thing(bare.carrying), bare.mission


def _fading(env: _Env) -> Callable[[int], float]:
    return _Fading(int(env.get_wrapper_attr("max_steps")))


class _Fading:
    """What is left of a reward after so many actions."""

    def __init__(self, steps: int) -> None:
        self._steps = steps

    def __call__(self, turn: int) -> float:
        return 1 - _FADES * (turn + 1) / self._steps


def _describe(observation: Any) -> str:
    """What is seen, the farthest first."""
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
    """A place, from the agent; its own shows what it carries."""
    parts = [f"{ahead} ahead"] * (ahead > 0) + [f"{abs(side)} to the {'right' if side > 0 else 'left'}"] * (side != 0)
    return " and ".join(parts) or "with you"


def _words(kind: int, color: int, state: int) -> str:
    return f"a {_COLORS[color]} {_THINGS[kind]}{f', {_DOORS[state]}' if kind == _DOOR else ''}"


_Place = tuple[int, int, int, bool]  # column, row, direction, and whether a key was picked up


def _heuristic(env: _Env) -> float:
    """The fewest actions to a goal, if keys fit every door and things in the way are gone after one action.

    0 where there is no goal on the grid, or no way there.
    """
    bare: Any = env.unwrapped
    things = ((i, thing) for i, thing in enumerate(bare.grid.grid) if thing is not None and thing.type != "floor")
    layout = tuple((i, _hindrance(thing)) for i, thing in things)
    x, y = map(int, bare.agent_pos)
    carries = bare.carrying is not None and bare.carrying.type == "key"
    return _distances(layout, bare.grid.width, bare.grid.height).get((x, y, int(bare.agent_dir), carries), 0.0)


def _hindrance(thing: Any) -> str:
    """What a thing is to somebody who walks."""
    if thing.type == "door":
        return "open" if thing.is_open else "locked" if thing.is_locked else "closed"
    if thing.type == "box" and getattr(thing.contains, "type", "") == "key":
        return "key"
    return "open" if thing.can_overlap() and thing.type not in ("goal", "lava") else str(thing.type)


@lru_cache(maxsize=1024)
def _distances(layout: tuple[tuple[int, str], ...], width: int, height: int) -> Mapping[_Place, float]:
    """The fewest actions from each place to a goal."""
    things = {(i % width, i // width): kind for i, kind in layout}
    goals = [cell for cell, kind in things.items() if kind == "goal"]
    if not goals:
        return {}
    ways = nx.DiGraph()
    for x in range(width):
        for y in range(height):
            if things.get((x, y)) not in ("wall", "lava"):
                for place in ((x, y, heading, key) for heading in range(4) for key in (False, True)):
                    ways.add_weighted_edges_from((after, place, cost) for after, cost in _moves(place, things))
    ends = [(*goal, heading, key) for goal in goals for heading in range(4) for key in (False, True)]
    found: Mapping[_Place, float] = nx.multi_source_dijkstra_path_length(ways, [end for end in ends if end in ways])
    return found


def _moves(place: _Place, things: Mapping[tuple[int, int], str]) -> Iterator[tuple[_Place, float]]:
    """The places after few actions, with their number or less."""
    x, y, heading, key = place
    yield (x, y, (heading + 1) % 4, key), 1.0
    yield (x, y, (heading - 1) % 4, key), 1.0
    ahead = x + _AHEAD[heading][0], y + _AHEAD[heading][1]
    kind = things.get(ahead, "")
    if kind == "key":
        yield (x, y, heading, True), 1.0
    if kind not in ("wall", "lava") and (key or kind != "locked"):
        free = kind in ("", "open", "goal") or (key and kind == "key")
        yield (*ahead, heading, key), 1.0 if free else 2.0


KNOWN = Known(
    describe=_describe,
    state=_state,
    fading=_fading,
    hides=True,
    free=frozenset({"_gen_grid", "_gen_mission"}),
    heuristic=_heuristic,
    admissible=True,
    goal="carry out your mission",
)
