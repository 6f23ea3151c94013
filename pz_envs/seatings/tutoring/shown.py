"""Tutoring that can be looked at: the episode is kept, and drawn when asked for."""

from typing import Any

from pz_envs.frames import Watch
from pz_envs.seatings.tutoring.env import TutoringEnv
from pz_envs.seats import SeatsEnv
from teachers.atoms import Moment
from teachers.teacher import Teacher
from worlds.pictures import Text
from worlds.pictures.canvas import Frame
from worlds.world import World

__all__ = ["ShownTutoring"]


class ShownTutoring(TutoringEnv):
    """A `TutoringEnv` with frames. What a bare one does is not slowed down by it.

    Args:
        world, teacher, settings: those of `TutoringEnv`.
        watch: what looks on.
    """

    def __init__(self, world: World[Any, Any, Any], teacher: Teacher, *, watch: Watch, **settings: Any) -> None:
        super().__init__(world, teacher, **settings)
        self.watch = watch

    def take_up(self, moment: Moment[Any], terminated: bool = False) -> None:
        """Go on from a moment of another episode, of whose earlier turns nothing is known here."""
        super().take_up(moment, terminated)
        if moment.turn:
            self.watch.begin(moment)

    def _move(self, action: Any) -> float:
        reward = super()._move(action)
        self.watch.acted(self.moment)
        return reward

    def hear(self, said: str) -> int:
        """Let the student hear the teacher's words."""
        cost = super().hear(said)
        self.watch.said(said, self.said)
        return cost

    def frame(self) -> Frame:
        """The episode now, uint8 (480, 640, 3)."""
        return self.watch.frame(self._seen())

    def image(self) -> Any:
        """The world's own image, if it has one, else its picture, of what the student may know."""
        return super().image() if self.world.options.get("visual") else self.watch.view(self._seen())

    def pieces(self) -> Text:
        """The turn, the student's action and the world in text, each piece with its role."""
        return self.watch.text(self._seen())

    def as_text(self) -> str:
        """The turn, the student's action, the world, and the teacher's last words."""
        text = "".join(piece for piece, _ in self.pieces())
        return f"{text}\nTeacher: {self.feedback or self.instruction}"

    def close(self) -> None:
        """Close the window and the world."""
        SeatsEnv.close(self)
        super().close()

    def _seen(self) -> str:
        return self.world.describe(self._state)

    def _open_lesson(self) -> None:
        super()._open_lesson()
        self.watch.begin(self.moment, self.said)
