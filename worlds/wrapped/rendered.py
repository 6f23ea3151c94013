"""Picture of any Gymnasium environment: its own rendering, if privileged."""

from typing import Any

import numpy as np

from worlds.pictures import Sight, TextPicture
from worlds.pictures.canvas import Canvas
from worlds.wrapped.gym_world import GymWorld, Position

__all__ = ["RenderedPicture"]

_MARGIN = 12


class RenderedPicture(TextPicture):
    """If privileged, the environment's own `rgb_array`, if it has one; otherwise the description.

    An environment may render more than its observation contains. Many environments cannot be copied any more once they
    have rendered; if truths are restored by copies, the picture therefore renders another environment than the played
    one.

    Args:
        world: the world to draw, in its current state.
    """

    def __init__(self, world: GymWorld) -> None:
        super().__init__(world)
        self.world = world
        self._last: Position | None = None

    def draw(self, canvas: Canvas, sight: Sight[Any]) -> None:
        """Draw the image in the largest size that fits."""
        if not sight.privileged or self.world.env.render_mode != "rgb_array":
            super().draw(canvas, sight)
            return
        world = self._another_at(sight.now) if self.world.copied else self.world
        image: Any = np.asarray(world.env.render(), np.uint8)
        height, width = image.shape[:2]
        share = min((canvas.width - 2 * _MARGIN) / width, (canvas.height - 2 * _MARGIN) / height)
        size = width * share, height * share
        canvas.paste(image, ((canvas.width - size[0]) / 2, (canvas.height - size[1]) / 2), size)

    def _another_at(self, truth: Position) -> GymWorld:
        """Another world at a truth: the last drawn world, if it is at this truth or one step before."""
        last, self._last = self._last, truth
        if last is None or last.episode is not truth.episode or truth.turn - last.turn not in (0, 1):
            self.lab = self.world.scratch()
        self.lab.restore(truth)
        lab: GymWorld = self.lab
        return lab
