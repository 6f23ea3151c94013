"""Any Gymnasium environment drawn: as it renders itself, for those who may see everything."""

from typing import Any

import numpy as np

from worlds.pictures import Sight, TextPicture
from worlds.pictures.canvas import Canvas
from worlds.wrapped.gym_world import GymWorld

__all__ = ["RenderedPicture"]

_MARGIN = 12


class RenderedPicture(TextPicture):
    """The environment's own `rgb_array`; the description where it has none, or only what a student may know is shown.

    What an environment renders may be more than it lets be observed.

    Args:
        world: the one that is drawn, in the state that it is in.
    """

    def __init__(self, world: GymWorld) -> None:
        super().__init__(world)
        self.world = world

    def draw(self, canvas: Canvas, sight: Sight[Any]) -> None:
        """Draw the image as large as it fits."""
        if not sight.privileged or self.world.env.render_mode != "rgb_array":
            super().draw(canvas, sight)
            return
        image: Any = np.asarray(self.world.env.render(), np.uint8)
        height, width = image.shape[:2]
        share = min((canvas.width - 2 * _MARGIN) / width, (canvas.height - 2 * _MARGIN) / height)
        size = width * share, height * share
        canvas.paste(image, ((canvas.width - size[0]) / 2, (canvas.height - size[1]) / 2), size)
