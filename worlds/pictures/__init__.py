"""Pictures of worlds for people, one module per family, without words of teaching.

A picture shows what the student may know: its way, what it has observed, the results of its actions. Only a
privileged sight includes the truth and an optimal plan.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, Generic, NamedTuple

import numpy as np
from typing_extensions import TypeVar

from worlds.pictures.canvas import Canvas, height_of
from worlds.pictures.themes import LARGE, MEDIUM, SMALL
from worlds.world import TruthT, World, WorldTurn

__all__ = ["Picture", "Sight", "Text", "TextPicture", "WorldT"]

WorldT = TypeVar("WorldT", bound=World[Any], default=Any)
"""The class of the world."""
Text = tuple[tuple[str, str], ...]
"""Pieces of text, each with its role: `here`, `goal`, `good`, `bad`, `muted`, or empty."""

_SEEN = 3000  # characters; more would not be legible on a canvas


class Sight(NamedTuple, Generic[TruthT]):
    """An episode up to the current turn."""

    turns: tuple[WorldTurn[TruthT], ...]
    """The first is the opening."""
    seen: str
    """The world's description of the current observation."""
    privileged: bool = False
    """Whether the truth may be shown."""
    plan: tuple[Any, ...] = ()
    """If the sight is privileged, the next actions of an optimal policy, as far as they are known."""

    @property
    def now(self) -> TruthT:
        """The current truth."""
        return self.turns[-1].truth


class Picture(ABC, Generic[TruthT, WorldT]):
    """Draws the worlds of a family.

    Args:
        lab: a scratch world with the options of the drawn world; the picture may restore and step it.
    """

    reach: int = 0
    """Number of actions of the plan that the picture shows."""

    def __init__(self, lab: WorldT) -> None:
        self.lab = lab

    @abstractmethod
    def draw(self, canvas: Canvas, sight: Sight[TruthT]) -> None:
        """Draw a sight; pictures of equal sights are equal."""

    def text(self, sight: Sight[TruthT]) -> Text:
        """A sight as text; by default the world's description."""
        return ((sight.seen, ""),)

    def alike(self, turns: Sequence[WorldTurn[TruthT]], rng: np.random.Generator) -> Sequence[WorldTurn[TruthT]]:
        """The same turns in another world that the student cannot distinguish from this one, for checks.

        Pictures of both must be equal unless they are privileged. By default nothing is hidden: returns `turns`.
        """
        return turns


class TextPicture(Picture[Any]):
    """The description of a world as text, for families without a picture."""

    def draw(self, canvas: Canvas, sight: Sight[Any]) -> None:
        """Draw the text in the largest size that fits."""
        width, height = canvas.width - 32, canvas.height - 32
        text = sight.seen[:_SEEN] or "There is nothing to see."
        size = next((size for size in (LARGE, MEDIUM) if height_of(text, size, width) <= height), SMALL)
        canvas.paragraph((16, 16), text, width, height, size)
