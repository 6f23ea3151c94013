"""Movies: a user asks for something to watch, with wishes of which one may stay unsaid.

What is recommended is looked up in a catalogue, and judged title by title and wish by wish.
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
