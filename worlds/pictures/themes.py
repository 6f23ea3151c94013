"""Colours and sizes of pictures, films, pages, reports and the site."""

from typing import NamedTuple

__all__ = ["LARGE", "MEDIUM", "SERIES", "SIZES", "SMALL", "SPACES", "THEMES", "Theme", "contrast", "luminance"]

SIZES = {"small": 0.86, "body": 1.0, "large": 1.14, "head": 1.43, "title": 2.0}
"""The scale of type, in sizes of the body's font."""
SPACES = (0.25, 0.5, 0.75, 1.0, 1.5, 2.5, 4.0)
"""The scale of spacing, in sizes of the body's font."""
_BODY = 14  # pixels of a picture
SMALL, MEDIUM, LARGE = (round(_BODY * SIZES[name]) for name in ("small", "body", "large"))
"""Sizes of the type of pictures, in pixels."""


class Theme(NamedTuple):
    """Colours by use, as `#rrggbb`.

    Text may have every colour but `faint`, `sky` and `yellow`: its contrast with `ground` and `card` is at least 4.5.
    """

    ground: str
    """Background."""
    card: str
    """Background of raised parts."""
    ink: str
    muted: str
    """For secondary information."""
    faint: str
    """For separating lines."""
    blue: str
    green: str
    orange: str
    red: str
    purple: str
    sky: str
    """For areas, as `yellow` is."""
    yellow: str


THEMES = {
    "light": Theme(
        *("#f6f6f3", "#ffffff", "#1c1f24", "#59616b", "#d8dbde"),
        *("#0170c2", "#087d52", "#9f5e00", "#c42b1c", "#a847a2", "#56b4e9", "#f5bd1f"),
    ),
    "dark": Theme(
        *("#15181d", "#22262d", "#f1f2f4", "#a9b0ba", "#3f4550"),
        *("#4aa7ff", "#36b87f", "#e58f27", "#fe7b68", "#e47edc", "#7cc6f2", "#f5c542"),
    ),
}
"""The themes by name."""
SERIES = {
    "light": ("#064f8a", "#d87903", "#057352", "#d635a0", "#20212b", "#77021b"),
    "dark": ("#268be4", "#fecc91", "#0ebb89", "#ff9dd5", "#eff0f7", "#d42e43"),
}
"""Colours of the lines of a plot, at most six, by theme.

No two have the same lightness, so that they differ in grey: their luminances stand in a ladder of equal ratios.
"""


def luminance(colour: str) -> float:
    """The relative luminance of a colour, 0 to 1, as WCAG 2 defines it."""
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    red, green, blue = (each / 12.92 if each <= 0.04045 else ((each + 0.055) / 1.055) ** 2.4 for each in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one: str, other: str) -> float:
    """The contrast of two colours, 1 to 21, as WCAG 2 defines it; text needs 4.5."""
    dark, light = sorted((luminance(one), luminance(other)))
    return (light + 0.05) / (dark + 0.05)
