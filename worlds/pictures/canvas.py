"""Drawing with Pillow: anti-aliased shapes and text in the colours of a theme.

Everything is drawn at twice its size and scaled down at the end.
"""

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from typing import Any, Self

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from worlds.pictures.themes import MEDIUM, SMALL, THEMES, Theme, contrast

__all__ = ["SCALE", "THEMES", "Canvas", "Frame", "Point", "Theme", "height_of", "listed", "measure", "wrap"]

Frame = npt.NDArray[np.uint8]
"""Rows of pixels, (height, width, 3)."""
Point = tuple[float, float]
"""x to the right and y downwards, in pixels of the finished picture."""
SCALE = 2
"""Pixels of the canvas per pixel of the finished picture, along each axis."""
_LEADING = 1.32  # height of a line of text, in font sizes


class Canvas:
    """A rectangle to draw on, with the origin at the upper left; lengths are pixels of the finished picture.

    Args:
        width, height: its size.
        theme: its colours.
    """

    def __init__(self, width: int, height: int, theme: Theme) -> None:
        self.width, self.height, self.theme = width, height, theme
        self._image = Image.new("RGB", (width * SCALE, height * SCALE), theme.ground)
        self._pen = ImageDraw.Draw(self._image)
        self._x, self._y = 0.0, 0.0

    def part(self, x: float, y: float, width: int, height: int) -> Self:
        """A rectangle of this canvas as a canvas; drawings are not clipped at its edges."""
        part = object.__new__(type(self))
        part.__dict__.update(self.__dict__, width=width, height=height)
        part._x, part._y = self._x + x, self._y + y
        return part

    def pixels(self) -> Frame:
        """The finished picture."""
        return np.array(self._image.reduce(SCALE))

    def fine_pixels(self) -> Frame:
        """The picture as it was drawn, at `SCALE` times its size, for screens with small pixels."""
        return np.array(self._image)

    def _at(self, points: Sequence[Point]) -> list[Point]:
        x, y = self._x, self._y
        return [((px + x) * SCALE, (py + y) * SCALE) for px, py in points]

    def box(
        self,
        corner: Point,
        size: Point,
        fill: str | None = None,
        outline: str | None = None,
        width: float = 1,
        radius: float = 0,
    ) -> None:
        """A rectangle, with rounded corners if `radius` is positive."""
        (x, y), (w, h) = corner, size
        self._pen.rounded_rectangle(
            self._at([(x, y), (x + w, y + h)]), radius * SCALE, fill, outline, round(width * SCALE)
        )

    def line(self, points: Sequence[Point], colour: str, width: float = 1) -> None:
        """A line through points."""
        self._pen.line(self._at(points), colour, round(width * SCALE), joint="curve")

    def dashes(self, points: Sequence[Point], colour: str, width: float = 1, dash: float = 5, gap: float = 4) -> None:
        """A dashed line through points."""
        for (x1, y1), (x2, y2) in pairwise(points):
            length = math.hypot(x2 - x1, y2 - y1)
            for start in np.arange(0, length, dash + gap).tolist():
                a, b = start / length, min(start + dash, length) / length
                ends = [(x1 + (x2 - x1) * at, y1 + (y2 - y1) * at) for at in (a, b)]
                self._pen.line(self._at(ends), colour, round(width * SCALE))

    def disc(
        self, centre: Point, radius: float, fill: str | None = None, outline: str | None = None, width: float = 1
    ) -> None:
        """A circle."""
        x, y = centre
        corners = self._at([(x - radius, y - radius), (x + radius, y + radius)])
        self._pen.ellipse(corners, fill, outline, round(width * SCALE))

    def polygon(
        self, points: Sequence[Point], fill: str | None = None, outline: str | None = None, width: float = 1
    ) -> None:
        """A polygon."""
        self._pen.polygon(self._at(points), fill, outline, round(width * SCALE))

    def star(self, centre: Point, radius: float, fill: str, outline: str | None = None) -> None:
        """A five-pointed star."""
        x, y = centre
        turns = [(radius * (0.42 if i % 2 else 1.0), math.pi * (i / 5 - 0.5)) for i in range(10)]
        self.polygon([(x + r * math.cos(turn), y + r * math.sin(turn)) for r, turn in turns], fill, outline)

    def mark(self, centre: Point, right: bool, size: float = 5, width: float = 2) -> None:
        """A tick if `right`, else a cross."""
        (x, y), s = centre, size
        if right:
            self.line([(x - s, y), (x - s * 0.25, y + s * 0.75), (x + s, y - s * 0.8)], self.theme.green, width)
        else:
            for way in (1, -1):
                self.line([(x - s * 0.8, y - s * 0.8 * way), (x + s * 0.8, y + s * 0.8 * way)], self.theme.red, width)

    def paste(self, image: Frame, corner: Point, size: Point) -> None:
        """An image, scaled to a size."""
        (x, y), (w, h) = self._at([corner])[0], size
        stretched = Image.fromarray(image).resize((round(w * SCALE), round(h * SCALE)), Image.Resampling.BICUBIC)
        self._image.paste(stretched, (round(x), round(y)))

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
        """A line of text, shortened if it is wider than `most`; returns its width.

        Args:
            at: position of the anchor.
            text: unprintable characters are replaced.
            size: font size in pixels.
            colour: the theme's ink by default.
            anchor: two letters, horizontally `l`, `m` or `r`, vertically `t`, `m` (without descenders) or `b`.
            bold: whether to use bold type.
            most: greatest width.
        """
        text = cut(text, size, most, bold)
        if not text:
            return 0.0
        mask, (left, top), ascent = _mask(text, size, bold)
        width = measure(text, size, bold)
        (x, y) = self._at([at])[0]
        x -= {"l": 0.0, "m": width / 2, "r": width}[anchor[0]] * SCALE
        y -= {"t": 0.0, "m": ascent - 0.36 * size * SCALE, "b": ascent}[anchor[1]]
        self._image.paste(colour or self.theme.ink, (round(x + left), round(y + top)), mask)
        return width

    def paragraph(
        self,
        corner: Point,
        text: str,
        width: float,
        height: float = math.inf,
        size: float = MEDIUM,
        colour: str | None = None,
    ) -> float:
        """Text in as many lines as fit, with an ellipsis if lines are left out; returns the y of the next line."""
        x, y = corner
        lines: Sequence[str] = wrap(text, size, width)
        room = max(int((height + 0.01) // (size * _LEADING)), 1) if height < math.inf else len(lines)
        if len(lines) > room:
            lines = [*lines[: room - 1], _unfinished(lines[room - 1], size, width)]
        for line in lines:
            self.text((x, y), line, size, colour, anchor="lt", most=width)
            y += size * _LEADING
        return y

    def tag(self, at: Point, text: str, colour: str, size: float = SMALL) -> float:
        """A small label on a coloured ground, placed by the middle of its left side; returns its width."""
        x, y = at
        width = measure(text, size, True) + size * 0.9
        self.box((x, y - size * 0.72), (width, size * 1.44), colour, radius=size * 0.3)
        self.text((x + width / 2, y), text, size, _legible(colour), anchor="mm", bold=True)
        return width


def height_of(text: str, size: float, width: float) -> float:
    """The height of a paragraph."""
    return len(wrap(text, size, width)) * size * _LEADING


@lru_cache(maxsize=512)
def wrap(text: str, size: float, width: float) -> tuple[str, ...]:
    """The lines of a text, none wider than `width`. Words are measured one by one, so that measures are reused."""
    lines, space = [], measure(" ", size)
    for line in text.splitlines() or [""]:
        now: list[str] = []
        taken = 0.0
        for word in line.split():
            if now and taken + space + measure(word, size) > width:
                lines.append(" ".join(now))
                now = []
            if now:
                now.append(word)
                taken += space + measure(word, size)
            else:
                *full, rest = _pieces(word, size, width)
                lines += full
                now, taken = [rest], measure(rest, size)
        lines.append(" ".join(now))
    return tuple(lines)


def _pieces(word: str, size: float, width: float) -> Iterator[str]:
    """The pieces of a word, each of which fits a line."""
    while measure(word, size) > width and len(word) > 1:
        fits = next((n for n in range(len(word) - 1, 1, -1) if measure(word[:n], size) <= width), 1)
        yield word[:fits]
        word = word[fits:]
    yield word


def _unfinished(line: str, size: float, most: float) -> str:
    """A line that ends in an ellipsis for the omitted lines; drops its last words if the ellipsis does not fit."""
    while " " in line and measure(f"{line} …", size) > most:
        line = line[: line.rindex(" ")]
    return f"{line} …"


def cut(text: str, size: float, most: float, bold: bool = False) -> str:
    """A text with unprintable characters replaced; if it is wider than `most`, its first words with an ellipsis.

    Only a first word that is too wide is cut itself.
    """
    if not text.isprintable():
        text = "".join(each if each.isprintable() else "\N{REPLACEMENT CHARACTER}" for each in text)
    if measure(text, size, bold) <= most:
        return text
    while " " in text and measure(f"{text} …", size, bold) > most:
        text = text[: text.rindex(" ")].rstrip()
    if measure(f"{text} …", size, bold) <= most:
        return f"{text} …"
    while text and measure(f"{text}…", size, bold) > most:
        text = text[:-1]
    return f"{text}…" if text else ""


def listed(items: Sequence[str], size: float, most: float, separator: str = ", ", bold: bool = False) -> str:
    """Items in a line that is at most `most` wide; those that do not fit are counted at its end, as in `bowl 1, +2`."""
    for shown in range(len(items), 0, -1):
        more = [f"+{len(items) - shown}"] * (shown < len(items))
        if measure(line := separator.join([*items[:shown], *more]), size, bold) <= most:
            return line
    return f"{len(items)} in all" if len(items) > 1 else "".join(items)


@lru_cache(maxsize=16_384)
def measure(text: str, size: float, bold: bool = False) -> float:
    """The width of a line of text."""
    return _font(size, bold).getlength(text) / SCALE


@lru_cache(maxsize=1024)
def _mask(text: str, size: float, bold: bool) -> tuple[Image.Image, tuple[int, int], int]:
    """A line of text as a mask, the position of its upper left corner, and its ascent.

    Consecutive frames share most of their text.
    """
    font = _font(size, bold)
    left, top, right, bottom = (int(each) for each in font.getbbox(text))
    mask = Image.new("L", (max(right - left, 1), max(bottom - top, 1)))
    ImageDraw.Draw(mask).text((-left, -top), text, 255, font)
    return mask, (left, top), font.getmetrics()[0]


@lru_cache(maxsize=64)
def _font(size: float, bold: bool) -> ImageFont.FreeTypeFont:
    """DejaVu Sans from matplotlib: Pillow's own font has neither accents nor dashes."""
    found: Any = find_spec("matplotlib")
    folder = Path(found.submodule_search_locations[0], "mpl-data", "fonts", "ttf")
    # The basic layout does not depend on how Pillow was built.
    basic = ImageFont.Layout.BASIC
    return ImageFont.truetype(folder / f"DejaVuSans{'-Bold' * bold}.ttf", round(size * SCALE), layout_engine=basic)


@lru_cache(maxsize=64)
def _legible(colour: str) -> str:
    """Black or white, whichever has more contrast with a colour."""
    return max("#000000", "#ffffff", key=lambda ink: contrast(ink, colour))
