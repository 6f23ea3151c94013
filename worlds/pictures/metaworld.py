"""Picture of Meta-World: MuJoCo's rendering, above the numbers that the student observes."""

import math

from worlds.metaworld.state import Truth
from worlds.metaworld.world import MetaWorld
from worlds.pictures import Picture, Sight
from worlds.pictures.canvas import Canvas
from worlds.pictures.themes import SMALL

__all__ = ["MetaWorldPicture"]

_PIXELS = 360


class MetaWorldPicture(Picture[Truth, MetaWorld]):
    """The camera image; if privileged, with the advised pose."""

    reach = 1

    def draw(self, canvas: Canvas, sight: Sight[Truth]) -> None:
        """Draw the robot.

        Raises:
            RuntimeError: there is no off-screen OpenGL.
        """
        theme, numbers = canvas.theme, sight.now.observation
        self.lab.restore(sight.now)
        left = (canvas.width - _PIXELS) / 2
        canvas.paste(self.lab.simulator().image(_PIXELS), (left, 12), (_PIXELS, _PIXELS))
        canvas.box((left, 12), (_PIXELS, _PIXELS), None, theme.muted, 1.5)
        hand, goal = numbers[:3], numbers[36:39]
        rows = [
            (theme.ink, "hand", hand, f"gripper {numbers[3]:.2f}"),
            (theme.green, "goal", goal, f"{math.dist(hand, goal):.2f} m away" if any(goal) else ""),
        ]
        if sight.plan:
            x, y, z, grip = sight.plan[0]
            rows[1:] = [
                (theme.blue, "advised", self.lab.target(sight.now, (x, y, z, grip)), f"grip {grip:.2f}"),
                rows[1],
            ]
        y = 12 + _PIXELS + 17.0
        for colour, name, place, more in rows:
            canvas.text((left, y), name, SMALL, colour, bold=True)
            canvas.text((left + 66, y), "  ".join(f"{each:+.3f}" for each in place), SMALL)
            canvas.text((left + _PIXELS, y), more, SMALL, theme.muted, anchor="rm")
            y += 19
