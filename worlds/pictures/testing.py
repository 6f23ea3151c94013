"""A conformance kit for pictures. For your own, run `check_picture(MyWorld, MyPicture)`.

Each check takes a factory of worlds and a function that makes the picture of a world; it raises an AssertionError that
describes the error.
"""

import math
from collections.abc import Callable, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from typing_extensions import override

from worlds.pictures import Picture, Sight
from worlds.pictures.canvas import Canvas, Frame, Point, cut
from worlds.pictures.themes import MEDIUM, THEMES, Theme
from worlds.testing import require, some_actions, started
from worlds.world import World, WorldTurn, plain

__all__ = ["CHECKS", "Proof", "check_picture", "episode", "picture_of"]

Make = Callable[[], World[Any]]
MakePicture = Callable[[World[Any]], Picture[Any]]
_SIZE = 384, 442
_SEEDS = 3
_TURNS = 6
_SLACK = 1.0  # greatest overlap of two boxes of text, in pixels


def check_picture(make: Make, make_picture: MakePicture) -> None:
    """Run every check."""
    for check in CHECKS:
        check(make, make_picture)


def episode(world: World[Any], turns: int = _TURNS, seed: int = 0) -> list[WorldTurn[Any]]:
    """Turns with random actions, in a world that was reset."""
    played: list[WorldTurn[Any]] = [WorldTurn(None, 0.0, world.truth)]
    for action in some_actions(world, turns, seed):
        legal = world.legal(action)
        _, reward, terminated, truncated, info = world.advance(legal)
        played.append(WorldTurn(legal, reward, world.truth, info["success"]))
        if terminated or truncated:
            break
    return played


def sight_of(world: World[Any], turns: Sequence[WorldTurn[Any]], privileged: bool = False) -> Sight[Any]:
    """A sight of turns; the world is left in the state of the last one."""
    world.restore(turns[-1].truth)
    return Sight(tuple(turns), world.describe(world.observe()), privileged)


def picture_of(picture: Picture[Any], sight: Sight[Any], theme: str = "light") -> Frame:
    """The picture of a sight on a new canvas."""
    canvas = Canvas(*_SIZE, THEMES[theme])
    picture.draw(canvas, sight)
    return canvas.pixels()


def check_drawing(make: Make, make_picture: MakePicture) -> None:
    """Pictures of all turns are not blank in either theme, texts are well-formed, and the sight does not change."""
    world = started(make)
    picture = make_picture(world)
    turns = episode(world)
    for i in range(1, len(turns) + 1):
        for privileged in (False, True):
            sight = sight_of(world, turns[:i], privileged)
            before = plain(sight)
            frames = [picture_of(picture, sight, theme) for theme in THEMES]
            require(all((frame != frame[0, 0]).any() for frame in frames), f"the picture of turn {i - 1} is blank")
            require(
                not np.array_equal(frames[0], frames[1]),
                "the picture is the same in light and dark: use the theme's colours",
            )
            text = picture.text(sight)
            require(
                all(isinstance(piece, str) and isinstance(role, str) for piece, role in text),
                f"text must be pairs of a text and a role, got {text!r}",
            )
            require(plain(sight) == before, "drawing has changed the sight")


class _Written(NamedTuple):
    """A line of text on a canvas."""

    text: str
    asked: str
    """The text before it was shortened."""
    left: float
    top: float
    right: float
    bottom: float

    def meets(self, other: "_Written") -> bool:
        """Whether the boxes of both overlap."""
        wide = min(self.right, other.right) - max(self.left, other.left)
        high = min(self.bottom, other.bottom) - max(self.top, other.top)
        return wide > _SLACK and high > _SLACK


class Proof(Canvas):
    """A canvas that records the text on it, to find text that is cut, outside the canvas or on other text."""

    def __init__(self, width: int, height: int, theme: Theme) -> None:
        super().__init__(width, height, theme)
        self._whole = width, height
        self._written: list[_Written] = []

    @override
    def text(
        self,
        at: Point,
        text: str,
        size: float = MEDIUM,
        colour: str | None = None,
        *,
        anchor: str = "lm",
        bold: bool = False,
        most: float = math.inf,
    ) -> float:
        width = super().text(at, text, size, colour, anchor=anchor, bold=bold, most=most)
        x, y = at[0] + self._x, at[1] + self._y
        x -= {"l": 0.0, "m": width / 2, "r": width}[anchor[0]]
        y -= {"t": 0.0, "m": 0.42, "b": 0.84}[anchor[1]] * size
        if width:
            shown = cut(text, size, most, bold)
            self._written.append(_Written(shown, text, x, y, x + width, y + 0.84 * size))
        return width

    def faults(self) -> list[str]:
        """The faults of the text, a sentence each."""
        width, height = self._whole
        found = []
        for i, each in enumerate(self._written):
            cropped = each.text.endswith("…") and not each.text.endswith(" …") and not each.asked.endswith("…")
            if cropped:
                found.append(f"{each.asked!r} is cut to {each.text!r}")
            if min(each.left, each.top) < -_SLACK or each.right > width + _SLACK or each.bottom > height + _SLACK:
                found.append(f"{each.text!r} lies outside the canvas")
            found += [f"{each.text!r} lies on {one.text!r}" for one in self._written[:i] if each.meets(one)]
        return found


def check_text(make: Make, make_picture: MakePicture) -> None:
    """No word is cut, no text lies outside the canvas or on other text, in any turn."""
    for seed in range(_SEEDS):
        world = started(make, seed)
        picture, turns = make_picture(world), episode(world, seed=seed)
        for i, privileged in product(range(1, len(turns) + 1), (False, True)):
            canvas = Proof(*_SIZE, THEMES["light"])
            picture.draw(canvas, sight_of(world, turns[:i], privileged))
            faults = canvas.faults()
            require(not faults, f"the picture of turn {i - 1} with seed {seed}: {'; '.join(faults[:3])}")


def check_repetition(make: Make, make_picture: MakePicture) -> None:
    """Pictures of equal sights are equal, whatever was drawn before, and the world does not change."""
    world = started(make)
    turns = episode(world)
    first, second = make_picture(world), make_picture(world)
    sight = sight_of(world, turns)
    one = picture_of(first, sight)
    picture_of(second, sight_of(world, turns[:1], True))
    require(plain(world.save().truth) == plain(turns[0].truth), "drawing has changed the world: use the lab")
    require(np.array_equal(one, picture_of(second, sight)), "two pictures of the same sight differ")
    require(first.text(sight) == second.text(sight), "two texts of the same sight differ")


def check_hidden(make: Make, make_picture: MakePicture) -> None:
    """Sights that a student cannot distinguish have equal pictures and texts unless they are privileged."""
    for seed in range(_SEEDS):
        world = started(make, seed)
        turns = episode(world, seed=seed)
        picture = make_picture(world)
        other = list(picture.alike(turns, np.random.default_rng(seed)))
        require(len(other) == len(turns), f"alike must return as many turns, got {len(other)} for {len(turns)}")
        for mine, theirs in zip(turns, other, strict=True):
            same = plain((mine.action, mine.reward, mine.success)) == plain(
                (theirs.action, theirs.reward, theirs.success)
            )
            require(
                same and _seen(world, mine) == _seen(world, theirs),
                "a student can distinguish the turns that alike returns",
            )
        one, two = sight_of(world, turns), sight_of(world, other)
        equal = np.array_equal(picture_of(picture, one), picture_of(picture, two))
        require(equal, "the picture shows what the student may not know")
        require(picture.text(one) == picture.text(two), "the text shows what the student may not know")


def _seen(world: World[Any], turn: WorldTurn[Any]) -> Any:
    """The observation after a turn, and its description."""
    world.restore(turn.truth)
    observation = world.observe()
    return plain(observation), world.describe(observation)


CHECKS = (check_drawing, check_text, check_repetition, check_hidden)
"""Every check of a picture."""
