"""Users and their wishes."""

from functools import lru_cache
from math import comb
from typing import Any, NamedTuple

import numpy as np

from worlds.movies.catalogue import GENRES, PERIODS, age_bit, genre_bit, period_bit, type_bit

TYPE, YEAR, GENRE, AGE = ATTRIBUTES = ("type", "year", "genre", "age rating")
"""The attributes that decide whether a title meets a wish."""
TYPE_NAMES = ("movie", "TV show")
PERIOD_NAMES = ("the 80s", "the 90s", "the 2000s", "the years since 2010")
AGE_NAMES = ("child-friendly", "family-friendly", "R-rated")

_NO_AGE = 0.4  # probability that the user has no age wish
_UNFIT = ({"Crime", "Horror", "Thriller", "War"},) * 2 + ({"Animation", "Family"},)


class Profile(NamedTuple):
    """A user's wishes. A title meets a wish if it has any of the listed values; an empty wish does not matter."""

    series: bool
    """Whether the user wants TV shows; otherwise movies."""
    periods: tuple[int, ...] = ()
    """Indices of `PERIODS`, in order; a series belongs to every period in which it ran."""
    genres: tuple[int, ...] = ()
    """Indices of `GENRES`, in order."""
    age: int = -1
    """Index of the age group; -1 for none."""

    @property
    def wishes(self) -> dict[str, int]:
        """For each attribute that matters, bits of which a title must have at least one."""
        return _wishes(self)

    def words(self, attribute: str) -> str:
        """A wish as text, such as "Comedy or Drama"; empty if the attribute does not matter."""
        if attribute == TYPE:
            return TYPE_NAMES[self.series]
        if attribute == YEAR:
            return " or ".join(PERIOD_NAMES[period] for period in self.periods)
        if attribute == GENRE:
            return " or ".join(GENRES[genre] for genre in self.genres)
        return AGE_NAMES[self.age] if self.age >= 0 else ""

    def only(self, *attributes: str) -> "Profile":
        """The profile with the wishes of these attributes and the type only."""
        return Profile(
            self.series,
            self.periods if YEAR in attributes else (),
            self.genres if GENRE in attributes else (),
            self.age if AGE in attributes else -1,
        )


FIELDS = dict(zip(ATTRIBUTES, Profile._fields, strict=True))
"""Per attribute the field of a profile."""


class Taste(NamedTuple):
    """The wish that a town's user leaves out of each request."""

    attribute: str
    """One of `ATTRIBUTES`."""
    wish: Any
    """The value of its field in a `Profile`."""

    @classmethod
    def of(cls, profile: Profile, attribute: str) -> "Taste":
        """The wish of a user."""
        return cls(attribute, getattr(profile, FIELDS[attribute]))


def draw_user(rng: np.random.Generator, taste: Taste) -> Profile | None:
    """Draw a user with this taste, who leaves it out of the request; None: the draw failed, draw again.

    The distribution is that of all users, given that the request leaves this wish out. A request leaves out each of
    a user's wishes with equal probability, so users with many wishes are drawn less often.
    """
    drawn = _draw(rng)._replace(**{FIELDS[taste.attribute]: taste.wish})
    profile = _suited(drawn)
    fits = (profile == drawn or taste.attribute != AGE) and rng.random() * len(profile.wishes) < 1
    return profile if fits else None


def draw_profile(rng: np.random.Generator) -> Profile:
    """Draw a user's wishes: a type, up to two periods and genres each, and an age group that suits the genres."""
    return _suited(_draw(rng))


def _draw(rng: np.random.Generator) -> Profile:
    series = bool(rng.integers(2))
    periods = rng.permutation(len(PERIODS))[: rng.integers(3)]
    genres = rng.permutation(len(GENRES))[: rng.integers(3)]
    age = int(rng.integers(len(AGE_NAMES))) if rng.random() >= _NO_AGE else -1
    return Profile(series, tuple(sorted(periods.tolist())), tuple(sorted(genres.tolist())), age)


def _suited(profile: Profile) -> Profile:
    """The profile without an age group that does not suit the genres."""
    age = profile.age
    if age >= 0 and not _UNFIT[age].isdisjoint(GENRES[genre] for genre in profile.genres):
        return profile._replace(age=-1)
    return profile


def odds_of(profile: Profile) -> float:
    """The probability that `draw_profile` draws a profile."""
    _, periods, genres, age = profile
    unfit = [not words.isdisjoint(GENRES[genre] for genre in genres) for words in _UNFIT]
    each = (1 - _NO_AGE) / len(AGE_NAMES)
    of_age = _NO_AGE + each * sum(unfit) if age < 0 else each * (not unfit[age])
    return of_age / 2 / 9 / comb(len(PERIODS), len(periods)) / comb(len(GENRES), len(genres))


@lru_cache(maxsize=1024)
def _wishes(profile: Profile) -> dict[str, int]:
    wishes = {TYPE: type_bit(profile.series)}
    if profile.periods:
        wishes[YEAR] = sum(map(period_bit, profile.periods))
    if profile.genres:
        wishes[GENRE] = sum(map(genre_bit, profile.genres))
    if profile.age >= 0:
        wishes[AGE] = age_bit(profile.age)
    return wishes
