"""Picture of parking: the car park from above, the car and its track, and the spot."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from worlds.parking import LENGTH, WALL_X, WALL_Y, WIDTH, Action, Car, Parking, Truth
from worlds.pictures import Picture, Sight
from worlds.pictures.canvas import Canvas, Point
from worlds.pictures.themes import MEDIUM
from worlds.world import WorldTurn

__all__ = ["ParkingPicture"]

_BAY, _BAYS, _NEAR, _DEEP = 4.0, 14, 10.0, 8.0
"""highway-env's two rows of spots: width of a spot, number per row, least |y|, and depth; lengths in metres."""


class ParkingPicture(Picture[Truth, Parking]):
    """The whole car park, above dials of the car; if privileged, with the oracle's plan."""

    reach = 200

    def draw(self, canvas: Canvas, sight: Sight[Truth]) -> None:
        """Draw the car park, with y downwards as in highway-env."""
        truth = sight.now
        track = [(turn.truth.car.x, turn.truth.car.y) for turn in sight.turns]
        way = self._way(truth, sight.plan)
        scale = (canvas.width - 20) / (2 * WALL_X + 2)
        middle = canvas.width / 2, 14 + (WALL_Y + 1) * scale
        _lot(canvas, truth, track, way, middle, scale)
        top = 14 + 2 * (WALL_Y + 1) * scale + 12
        self._dials(canvas, truth.car, top)

    def _dials(self, canvas: Canvas, car: Car, top: float) -> None:
        """Draw speed and heading, as numbers and as hands of dials."""
        theme, radius = canvas.theme, (canvas.height - top) / 2 - 26
        radius = min(radius, 56)
        y = top + 16 + radius
        speed = min(max(car.speed / 10, -1), 1)
        for x, name, turn in (
            (canvas.width * 0.3, f"speed {car.speed:.1f} m/s", speed * math.pi * 0.75 - math.pi / 2),
            (canvas.width * 0.7, f"heading {math.degrees(car.heading) % 360:.0f}°", car.heading),
        ):
            canvas.disc((x, y), radius, theme.card, theme.muted, 1.5)
            hand = x + math.cos(turn) * radius * 0.85, y + math.sin(turn) * radius * 0.85
            canvas.line([(x, y), hand], theme.blue, 4)
            canvas.disc((x, y), 5, theme.blue)
            canvas.text((x, y + radius + 14), name, MEDIUM, anchor="mm")

    def _way(self, truth: Truth, plan: Sequence[Action]) -> list[Point]:
        """The positions of the car along a plan."""
        if not plan:
            return []
        lab, way = self.lab, [(truth.car.x, truth.car.y)]
        lab.restore(truth)
        for action in plan:
            _, _, ended, _, _ = lab.advance(action)
            car = lab.truth.car
            way.append((car.x, car.y))
            if ended:
                break
        return way

    def alike(self, turns: Sequence[WorldTurn[Truth]], rng: np.random.Generator) -> Sequence[WorldTurn[Truth]]:
        """Another time, other walls and spots touched, and another imminent collision."""
        later, impact = float(rng.uniform(1, 9)), tuple(rng.uniform(-1, 1, 2).tolist())
        return [
            turn._replace(
                truth=turn.truth._replace(
                    time=turn.truth.time + later,
                    touched=tuple(not each for each in turn.truth.touched),
                    car=turn.truth.car._replace(impact=impact),
                )
            )
            for turn in turns
        ]


def _lot(
    canvas: Canvas, truth: Truth, track: Sequence[Point], way: Sequence[Point], middle: Point, scale: float
) -> None:
    theme = canvas.theme

    def place(x: float, y: float) -> Point:
        return middle[0] + x * scale, middle[1] + y * scale

    left, top = place(-WALL_X - 0.5, -WALL_Y - 0.5)
    canvas.box((left, top), ((2 * WALL_X + 1) * scale, (2 * WALL_Y + 1) * scale), theme.card, theme.muted, 3, 3)
    for side in (-1, 1):
        for i in range(_BAYS + 1):
            x = (i - _BAYS / 2) * _BAY
            canvas.line([place(x, side * _NEAR), place(x, side * (_NEAR + _DEEP))], theme.faint, 1.5)
    spot = truth.spot
    corners = _outline(spot.x, spot.y, spot.heading, _DEEP * 0.9, _BAY * 0.85)
    canvas.polygon([place(*corner) for corner in corners], theme.yellow, theme.orange, 2)
    nose = _outline(spot.x, spot.y, spot.heading, LENGTH, 0.0)[1]
    canvas.line([place(spot.x, spot.y), place(*nose)], theme.orange, 2)
    canvas.disc(place(*nose), 3.5, theme.orange)
    for other in truth.parked:
        _car(canvas, other, place, theme.muted)
    if len(way) > 1:
        canvas.dashes(_thinned([place(*point) for point in way]), theme.green, 2.5)
    if len(track) > 1:
        canvas.line([place(*point) for point in track], theme.sky, 2.5)
    _car(canvas, truth.car, place, theme.red if truth.car.crashed else theme.blue)


def _thinned(points: Sequence[Point], least: float = 9) -> list[Point]:
    """Points of a line at least this far apart, so that it can be dashed."""
    kept = [points[0]]
    for point in points[1:]:
        if math.dist(point, kept[-1]) >= least:
            kept.append(point)
    return [*kept, points[-1]]


def _car(canvas: Canvas, car: Car, place: Callable[[float, float], Point], colour: str) -> None:
    """Draw a car, with a window at its front."""
    body = _outline(car.x, car.y, car.heading, LENGTH, WIDTH)
    canvas.polygon([place(*corner) for corner in body], colour, canvas.theme.ink, 1)
    ahead = LENGTH * 0.2
    x, y = car.x + ahead * math.cos(car.heading), car.y + ahead * math.sin(car.heading)
    glass = _outline(x, y, car.heading, LENGTH * 0.18, WIDTH * 0.75)
    canvas.polygon([place(*corner) for corner in glass], canvas.theme.card)


def _outline(x: float, y: float, heading: float, length: float, width: float) -> list[Point]:
    """The corners of a rectangle along a heading."""
    cos, sin = math.cos(heading), math.sin(heading)
    return [
        (x + along * cos - across * sin, y + along * sin + across * cos)
        for along, across in (
            (-length / 2, -width / 2),
            (length / 2, -width / 2),
            (length / 2, width / 2),
            (-length / 2, width / 2),
        )
    ]
