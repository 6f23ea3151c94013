"""Picture of optimization: the path of the proposals in the plane."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from worlds.optimization.loss import Landscape, Loss, Point
from worlds.optimization.world import Optimization, Truth
from worlds.pictures import Picture, Sight
from worlds.pictures.canvas import SCALE, Canvas, Frame
from worlds.pictures.themes import MEDIUM, SMALL
from worlds.world import WorldTurn

__all__ = ["OptimizationPicture"]

_GRID = 56  # points along each axis at which the loss is evaluated
_BANDS = 12


class OptimizationPicture(Picture[Truth, Optimization]):
    """The proposals, in order, with their losses; if privileged, on a map of the loss."""

    def draw(self, canvas: Canvas, sight: Sight[Truth]) -> None:
        """Draw the domain, with x1 to the right and x2 upwards."""
        theme, world = canvas.theme, self.lab
        (low1, low2), (high1, high2) = world.lows, world.highs
        left, top, side = 46, 18, min(canvas.width - 62, canvas.height - 92)

        def place(x: Point) -> Point:
            return left + (x[0] - low1) / (high1 - low1) * side, top + (high2 - x[1]) / (high2 - low2) * side

        if sight.privileged:
            image = _map(world.loss, sight.now.shift, (theme.card, theme.blue), round(side * SCALE))
            canvas.paste(image, (left, top), (side, side))
        else:
            canvas.box((left, top), (side, side), theme.card)
        for i in range(5):
            share = i / 4
            x, y = left + share * side, top + side - share * side
            canvas.line([(x, top), (x, top + side)], theme.faint)
            canvas.line([(left, y), (left + side, y)], theme.faint)
            if not i % 2:
                canvas.text(
                    (x, top + side + 13), f"{low1 + share * (high1 - low1):.4g}", SMALL, theme.muted, anchor="mm"
                )
                canvas.text((left - 5, y), f"{low2 + share * (high2 - low2):.4g}", SMALL, theme.muted, anchor="rm")
        if sight.privileged:
            for minimiser in Landscape(world.loss, sight.now.shift).minimisers():
                canvas.star(place(minimiser), 9, theme.yellow, "#000000")
        path = [turn.truth for turn in sight.turns if turn.action is not None or turn is sight.turns[0]]
        points = [place(each.x) for each in path]
        best = min(range(len(path)), key=lambda i: path[i].y)
        if len(points) > 1:
            canvas.line(points, theme.ink, 1.5)
        for i, point in enumerate(points):
            colour = theme.green if i == best else theme.orange if i + 1 == len(points) else theme.muted
            canvas.disc(point, 6.5 if i in (best, len(points) - 1) else 4, colour, theme.ink, 1)
        x, y = points[-1]
        canvas.disc((x, y), 10, None, theme.orange, 2)
        below = top + side + 34
        for i, (colour, name, each) in enumerate(
            ((theme.orange, "now", path[-1]), (theme.green, "best so far", path[best]))
        ):
            canvas.disc((left + 6, below + 20 * i), 6, colour, theme.ink, 1)
            (x1, x2), loss = each.x, each.y
            canvas.text((left + 18, below + 20 * i), f"{name}: y = {loss:.4g} at [{x1:.3g}, {x2:.3g}]", MEDIUM)

    def alike(self, turns: Sequence[WorldTurn[Truth]], rng: np.random.Generator) -> Sequence[WorldTurn[Truth]]:
        """A loss with another shift; its values at the proposed points are set to those that the student saw."""
        if not self.lab.options["shift"]:
            return turns
        first, second = (float(rng.uniform(low, high)) for low, high in self.lab.shift_bounds())
        return [turn._replace(truth=turn.truth._replace(shift=(first, second))) for turn in turns]


@lru_cache(maxsize=16)
def _map(loss: Loss, shift: Point, colours: tuple[str, str], pixels: int) -> Frame:
    """The loss in bands of equal width in the logarithm, the least one darkest."""
    value, (low1, low2), (high1, high2) = Landscape(loss, shift).value, loss.lows, loss.highs
    firsts, seconds = np.linspace(low1, high1, _GRID).tolist(), np.linspace(high2, low2, _GRID).tolist()
    heights = np.array([[value(x1, x2) for x1 in firsts] for x2 in seconds]) - loss.minimum
    heights = np.log(np.maximum(heights, 0) + 0.01 * max(float(np.median(heights)), 1e-9))
    fine = np.linspace(0, _GRID - 1, pixels)
    whole = np.arange(_GRID)
    heights = np.array([np.interp(fine, whole, row) for row in heights])
    heights = np.array([np.interp(fine, whole, column) for column in heights.T]).T
    low, high = float(heights.min()), float(heights.max())
    bands = np.floor((heights - low) / max(high - low, 1e-12) * (_BANDS - 1e-9)) / (_BANDS - 1)
    light, dark = (np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) for colour in colours)
    mixed = dark + (light - dark) * (0.25 + 0.75 * bands[..., None])
    return np.ascontiguousarray(mixed, np.uint8)
