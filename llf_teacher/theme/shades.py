"""The colours of pages and plots."""

from typing import NamedTuple


class Shade(NamedTuple):
    """A colour on a light and on a dark page, as `#rrggbb`."""

    light: str
    dark: str


SHADES = {
    "ink": Shade("#1c2128", "#e8eaed"),
    "muted": Shade("#59636e", "#a3acb8"),
    "rule": Shade("#dfe3e8", "#353c45"),
    "stripe": Shade("#f5f7f9", "#1f242b"),
    # Okabe & Ito (2008), for colour-blind readers; adjusted for contrast, black and yellow replaced.
    "series-0": Shade("#0072b2", "#4fa9e0"),
    "series-1": Shade("#d55e00", "#f08342"),
    "series-2": Shade("#008a64", "#2fc596"),
    "series-3": Shade("#b9578f", "#e59bc6"),
    "series-4": Shade("#db9600", "#f0b73f"),
    "series-5": Shade("#47a5da", "#97d3f6"),
    "series-6": Shade("#7d7000", "#d9cf55"),
    "series-7": Shade("#4a4f57", "#c3c8cf"),
}
"""Every colour by the name of its custom property."""
