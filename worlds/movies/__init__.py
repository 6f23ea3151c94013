"""Movies: recommend titles to a user whose request leaves one wish out.

Recommended titles are looked up in a catalogue and judged by each wish.
"""

from worlds.movies.answers import MAX_LENGTH, MAX_TITLE, MAX_TITLES, answer_of, titles_of
from worlds.movies.users import (
    AGE,
    AGE_NAMES,
    ATTRIBUTES,
    GENRE,
    PERIOD_NAMES,
    TYPE,
    TYPE_NAMES,
    YEAR,
    Profile,
    draw_profile,
)
from worlds.movies.world import LEAST_MATCHES, Movies, Truth

__all__ = [
    "AGE",
    "AGE_NAMES",
    "ATTRIBUTES",
    "GENRE",
    "LEAST_MATCHES",
    "MAX_LENGTH",
    "MAX_TITLE",
    "MAX_TITLES",
    "PERIOD_NAMES",
    "TYPE",
    "TYPE_NAMES",
    "YEAR",
    "Movies",
    "Profile",
    "Truth",
    "answer_of",
    "draw_profile",
    "titles_of",
]
