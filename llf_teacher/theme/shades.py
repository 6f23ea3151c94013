"""The colours and sizes of pages and plots, shared with pictures."""

from typing import NamedTuple

from teachers.words import KIND_COLOURS
from worlds.pictures.themes import SERIES, SIZES, SPACES, THEMES


class Shade(NamedTuple):
    """A colour on a light and on a dark page, as `#rrggbb`."""

    light: str
    dark: str


def _both(name: str) -> Shade:
    return Shade(*(getattr(theme, name) for theme in THEMES.values()))


SHADES = {
    **{name: _both(name) for name in ("ink", "muted")},
    "rule": _both("faint"),
    "page": Shade(THEMES["light"].card, THEMES["dark"].ground),
    "stripe": Shade(THEMES["light"].ground, THEMES["dark"].card),
    "on": Shade("#ffffff", "#000000"),  # text on a coloured ground
    "link": _both("blue"),
    "good": _both("green"),
    "bad": _both("red"),
    "notice": Shade("#fff4d6", "#3a2f12"),
    "edge": _both("orange"),
    **{f"kind-{kind or 'none'}": _both(colour) for kind, colour in KIND_COLOURS.items()},
    **{f"series-{i}": Shade(*pair) for i, pair in enumerate(zip(*SERIES.values(), strict=True))},
}
"""Every colour by the name of its custom property."""
FONTS = {
    "sans": 'system-ui, -apple-system, "Segoe UI", "Liberation Sans", Arial, sans-serif',
    "mono": 'ui-monospace, "SF Mono", Menlo, Consolas, "Liberation Mono", monospace',
}
"""Families of fonts by the names of their custom properties."""
LENGTHS = {
    **SIZES,
    **{f"space-{i}": space for i, space in enumerate(SPACES, start=1)},
}
"""Sizes of type and spaces, in rem, by the names of their custom properties."""
