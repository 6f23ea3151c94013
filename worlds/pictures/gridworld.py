"""Picture of gridworld: the known rooms, their doors, the trail, and the treasure if it may be shown."""

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from worlds.gridworld import NO_DOOR, Gridworld, Layout, Truth
from worlds.pictures import Picture, Sight, Text
from worlds.pictures.canvas import Canvas, Point, listed, measure
from worlds.pictures.themes import SMALL
from worlds.world import WorldTurn

__all__ = ["GridworldPicture"]

Cell = tuple[int, int]
_STEPS = ((0, -1), (1, 0), (-1, 0), (0, 1))  # north, east, west, south, on a screen
_MOST = 7, 8  # greatest number of columns and rows, around the current room
_LEAST = 4
_MARGIN = 8
_INSIDE = 0.82  # of the side of a cell: the inside of its room
_SMALLEST = 9  # pixels of letters that are legible; names of two words are written on two lines before they are smaller


class GridworldPicture(Picture[Truth, Gridworld]):
    """The visited rooms and those behind their doors; if privileged, the house, the treasure and the plan."""

    reach = 100

    def draw(self, canvas: Canvas, sight: Sight[Truth]) -> None:
        """Draw the part of the house around the current room."""
        theme, layout, now = canvas.theme, sight.now.layout, sight.now.room
        places = _places(layout.doors, sight.turns[0].truth.room)
        trail = [turn.truth.room for turn in sight.turns]
        been = set(trail)
        known = set(range(len(layout.doors))) if sight.privileged else _known(layout, been)
        cells = [places[room] for room in known if room in places]
        (left, top), (columns, rows) = _window(cells, places[now])
        side = min((canvas.width - 2 * _MARGIN) / columns, (canvas.height - 2 * _MARGIN) / rows, 104)
        x0, y0 = (canvas.width - side * columns) / 2, (canvas.height - side * rows) / 2

        def middle(room: int) -> Point:
            column, row = places[room]
            return x0 + (column - left + 0.5) * side, y0 + (row - top + 0.5) * side

        shown = [
            room
            for room in sorted(known)
            if room in places and 0 <= places[room][0] - left < columns and 0 <= places[room][1] - top < rows
        ]
        half = side * 0.43
        for room in shown:  # the doors first, so that the rooms cover them
            x, y = middle(room)
            for direction, behind in enumerate(layout.doors[room]):
                if behind != NO_DOOR and (room in been or sight.privileged):
                    dx, dy = _STEPS[direction]
                    ends = [(x + dx * half, y + dy * half), (x + dx * side / 2, y + dy * side / 2)]
                    canvas.line(ends, theme.muted if room in been else theme.faint, side * 0.2)
        for room in shown:
            x, y = middle(room)
            corner, size = (x - half, y - half), (2 * half, 2 * half)
            if room in been:
                here = room == now
                outline = theme.blue if here else theme.muted
                canvas.box(corner, size, theme.card, outline, 2.5 if here else 1.2, 7)
            else:
                canvas.box(corner, size, theme.ground, theme.faint, 1.2, 7)
        if len(sight.plan) and not sight.now.found:
            _follow(canvas, layout, now, sight.plan, middle)
        steps = [middle(room) for room in trail if room in shown]
        if len(steps) > 1:
            canvas.line(steps, theme.sky, max(side * 0.05, 2))
        for room in shown:
            _furnish(canvas, layout, room, middle(room), side, room in been)
        if sight.now.found or sight.privileged:
            x, y = middle(layout.treasure)
            canvas.star((x, y), side * (0.24 if now == layout.treasure else 0.17), theme.yellow, "#000000")
        canvas.disc(middle(now), side * 0.1, theme.blue, theme.card, 2)

    def text(self, sight: Sight[Truth]) -> Text:
        """A map of the known rooms, the current one in brackets, above the world's description.

        If privileged, a map of the whole house, with stars around the treasure.
        """
        layout, now = sight.now.layout, sight.now.room
        places = _places(layout.doors, sight.turns[0].truth.room)
        been = {turn.truth.room for turn in sight.turns}
        known = set(range(len(layout.doors))) if sight.privileged else _known(layout, been)
        at = {places[room]: room for room in sorted(known) if room in places}
        (left, top), (columns, rows) = _window(list(at), places[now])
        shown = sight.now.found or sight.privileged
        widths = dict.fromkeys(range(left, left + columns), 1)  # with brackets and stars
        for (column, row), room in at.items():
            if column in widths and top <= row < top + rows:
                stars = 2 * (shown and room == layout.treasure)
                widths[column] = max(widths[column], len(layout.names[room]) + 2 + stars)
        open_doors = known if sight.privileged else been
        pieces: list[tuple[str, str]] = []
        for row in range(top, top + rows):
            below = ""
            for column in range(left, left + columns):
                room = at.get((column, row), -1)
                name, role = "", ""
                if room >= 0:
                    name = f"[{layout.names[room]}]" if room == now else layout.names[room]
                    role = "here" if room == now else "" if room in been else "muted"
                    if shown and room == layout.treasure:
                        name, role = f"*{name}*", "goal"
                pieces.append((name.center(widths[column]), role))
                beside, under = at.get((column + 1, row), -1), at.get((column, row + 1), -1)
                pieces.append(("--" if _joined(layout, open_doors, room, beside, 1) else "  ", "muted"))
                below += ("|" if _joined(layout, open_doors, room, under, 3) else " ").center(widths[column]) + "  "
            pieces.append(("\n", ""))
            pieces.append((f"{below.rstrip()}\n", "muted"))
        return (*_trimmed(pieces), (sight.seen, ""))

    def alike(self, turns: Sequence[WorldTurn[Truth]], rng: np.random.Generator) -> Sequence[WorldTurn[Truth]]:
        """The treasure in another room that was not visited, and other names of unknown rooms."""
        layout = turns[-1].truth.layout
        been = {turn.truth.room for turn in turns}
        known = _known(layout, been)
        free = [room for room in range(len(layout.doors)) if room not in been]
        treasure = layout.treasure if layout.treasure in been or not free else free[rng.integers(len(free))]
        names = [f"{name}-x" if room not in known else name for room, name in enumerate(layout.names)]
        objects = [things if room in been else () for room, things in enumerate(layout.objects)]
        other = layout._replace(treasure=treasure, names=tuple(names), objects=tuple(objects))
        return [turn._replace(truth=turn.truth._replace(layout=other)) for turn in turns]


@lru_cache(maxsize=16)
def _places(doors: tuple[tuple[int, ...], ...], start: int) -> dict[int, Cell]:
    """The column and row of each room, relative to the start."""
    places = {start: (0, 0)}
    queue = [start]
    for room in queue:
        column, row = places[room]
        for (dx, dy), behind in zip(_STEPS, doors[room], strict=True):
            if behind != NO_DOOR and behind not in places:
                places[behind] = column + dx, row + dy
                queue.append(behind)
    return places


def _known(layout: Layout, been: set[int]) -> set[int]:
    """The visited rooms and those behind their doors."""
    return been | {behind for room in been for behind in layout.doors[room] if behind != NO_DOOR}


def _window(cells: list[Cell], here: Cell) -> tuple[Cell, Cell]:
    """The least column and row to draw, and their numbers: all cells, or those around the current room."""
    least, count = [], []
    for axis, most in enumerate(_MOST):
        low, high = (bound(cell[axis] for cell in cells) for bound in (min, max))
        if high - low >= most:
            low = min(max(here[axis] - most // 2, low), high - most + 1)
            high = low + most - 1
        low -= max(_LEAST - (high - low + 1), 0) // 2
        least.append(low)
        count.append(max(high - low + 1, _LEAST))
    return (least[0], least[1]), (count[0], count[1])


def _furnish(canvas: Canvas, layout: Layout, room: int, at: Point, side: float, entered: bool) -> None:
    """The name of a room, its number below it if both do not fit a line, and what lies in it."""
    theme, (x, y) = canvas.theme, at
    kind, _, number = layout.names[room].rpartition("-")
    lines = [f"{kind} {number}".strip()]
    if _size(lines[0], side) < _SMALLEST:
        lines = [kind, number] if kind else lines
    size = min(_size(line, side) for line in lines)
    for i, line in enumerate(lines):
        place = x, y - side * (0.27 if len(lines) == 1 else 0.32) + i * size * 1.05
        _label(canvas, line, place, size, side, theme.ink if entered else theme.muted, entered)
    if entered and layout.objects[room]:
        things = listed(layout.objects[room], _SMALLEST, side * _INSIDE)
        _label(canvas, things, (x, y + side * 0.28), _size(things, side), side, theme.purple, entered)


def _size(text: str, side: float) -> float:
    """The font size that makes a text fit into a room."""
    sizes = range(min(int(side * 0.17), SMALL), 7, -1)
    return next((size for size in sizes if measure(text, size) <= side * _INSIDE), 7)


def _label(canvas: Canvas, text: str, at: Point, size: float, side: float, colour: str, entered: bool) -> None:
    """Words in a room, over the trail."""
    (x, y), width = at, measure(text, size)
    ground = canvas.theme.card if entered else canvas.theme.ground
    canvas.box((x - width / 2, y - size * 0.5), (width, size), ground)
    canvas.text(at, text, size, colour, anchor="mm", most=side)


def _follow(canvas: Canvas, layout: Layout, room: int, plan: Sequence[int], middle: Callable[[int], Point]) -> None:
    """The rooms along a plan."""
    way = [middle(room)]
    for direction in plan:
        behind = layout.doors[room][direction]
        room = room if behind == NO_DOOR else behind
        way.append(middle(room))
    canvas.dashes(way, canvas.theme.green, 3)


def _joined(layout: Layout, been: set[int], room: int, other: int, direction: int) -> bool:
    """Whether there is a known door between two rooms."""
    return room >= 0 <= other and layout.doors[room][direction] == other and bool(been & {room, other})


def _trimmed(pieces: list[tuple[str, str]]) -> Text:
    """A map without trailing blank lines, and without blanks at the ends of its lines."""
    lines: list[list[tuple[str, str]]] = [[]]
    for text, role in pieces:
        lines[-1].append((text.rstrip("\n"), role))
        if text.endswith("\n"):
            while lines[-1] and not lines[-1][-1][0].strip():
                lines[-1].pop()
            lines.append([])
    full = [(*line[:-1], (line[-1][0].rstrip(), line[-1][1])) for line in lines if line]
    return tuple(piece for line in full for piece in (*line, ("\n", "")))
