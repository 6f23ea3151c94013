"""Pictures of worlds, for people: a family's module here draws its worlds. They have no words of teaching.

A picture shows what the student may know: where it has been, what it has seen, what its actions brought. Only a
privileged sight shows the truth, and the plan of one who knows it.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, Generic, NamedTuple

import numpy as np
from typing_extensions import TypeVar

from worlds.pictures.canvas import Canvas, height_of
from worlds.world import TruthT, World

__all__ = ["Picture", "Sight", "Step", "Text", "TextPicture", "WorldT"]

WorldT = TypeVar("WorldT", bound=World[Any], default=Any)
"""The class of the world."""
Text = tuple[tuple[str, str], ...]
"""Pieces of text, each with its role: `here`, `goal`, `good`, `bad`, `muted`, or none."""


_SEEN = 3000  # characters; no more can be read on a canvas


class Step(NamedTuple, Generic[TruthT]):
    """One turn of the student."""

    action: Any
    """In canonical form; None at the opening, and where none was executed."""
    reward: float
    truth: TruthT
    """After it."""
    success: bool = False


class Sight(NamedTuple, Generic[TruthT]):
    """An episode up to now."""

    turns: tuple[Step[TruthT], ...]
    """The first is the opening."""
    seen: str
    """What the student observes now, as the world describes it."""
    privileged: bool = False
    """Whether the truth may be shown."""
    plan: tuple[Any, ...] = ()
    """Where the sight is privileged, the actions of an optimal policy from here on, as far as they are known."""

    @property
    def now(self) -> TruthT:
        """The truth now."""
        return self.turns[-1].truth


class Picture(ABC, Generic[TruthT, WorldT]):
    """Draws the worlds of a family.

    Args:
        lab: a world like the one that is drawn, for its rules; it knows no episode, and may be restored and stepped.
    """

    reach: int = 0
    """Actions of the plan that it draws."""

    def __init__(self, lab: WorldT) -> None:
        self.lab = lab

    @abstractmethod
    def draw(self, canvas: Canvas, sight: Sight[TruthT]) -> None:
        """Draw a sight; equal sights give equal pictures."""

    def text(self, sight: Sight[TruthT]) -> Text:
        """A sight in text; by default as the world describes it."""
        return ((sight.seen, ""),)

    def alike(self, turns: Sequence[Step[TruthT]], rng: np.random.Generator) -> Sequence[Step[TruthT]]:
        """The same turns in another world, which a student could not tell from this one.

        For checks: pictures of both have to be equal unless they are privileged. As it stands, nothing is hidden.
        """
        return turns


class TextPicture(Picture[Any]):
    """The description of a world, for families that have nothing to draw."""

    def draw(self, canvas: Canvas, sight: Sight[Any]) -> None:
        """Write it down, in letters as large as fit."""
        width, height = canvas.width - 32, canvas.height - 32
        text = sight.seen[:_SEEN] or "There is nothing to see."
        size = next((size for size in (18, 16, 14) if height_of(text, size, width) <= height), 13)
        canvas.paragraph((16, 16), text, width, height, size)
