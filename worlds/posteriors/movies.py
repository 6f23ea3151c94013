"""Posterior of movies: exact, over all users who could have made the request."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from types import MappingProxyType
from typing import Any

import numpy as np

from worlds.movies import (
    AGE,
    AGE_NAMES,
    ATTRIBUTES,
    GENRE,
    LEAST_MATCHES,
    TYPE,
    YEAR,
    Movies,
    Profile,
    Truth,
    titles_of,
)
from worlds.movies.catalogue import GENRES, PERIODS
from worlds.movies.users import FIELDS, Taste, odds_of
from worlds.movies.world import reward_of
from worlds.posteriors import NoWorldError, Posterior
from worlds.world import WorldTurn

__all__ = ["MoviesPosterior"]

_BLOCK = 64  # worlds that are drawn at once


def _some(count: int) -> list[tuple[int, ...]]:
    """Every set of one or two of `count` things."""
    return [each for size in (1, 2) for each in combinations(range(count), size)]


_HIDDEN: Mapping[str, Sequence[Any]] = MappingProxyType(
    {YEAR: _some(len(PERIODS)), GENRE: _some(len(GENRES)), AGE: range(len(AGE_NAMES))}
)
"""For each attribute that a request may leave out, the possible wishes."""


class MoviesPosterior(Posterior[Truth, Movies]):
    """The unsaid wish and its attribute, given the request and the rewards that the teacher said.

    A town draws its lasting wish like any other wish, then a user who leaves it out. So users are as probable as
    without a town, and the unsaid wish is the lasting one.
    """

    def openings(self, turns: Sequence[WorldTurn[Truth]], rng: np.random.Generator) -> Iterator[Truth]:
        """Draw a user from all users who could have made the request."""
        truths, shares = zip(*self.odds(turns), strict=True)
        while True:
            for i in rng.choice(len(truths), _BLOCK, p=shares).tolist():
                yield truths[i]

    def odds(self, turns: Sequence[WorldTurn[Truth]]) -> list[tuple[Truth, float]]:
        """Every user who could have made the request.

        A reset gives up after a thousand draws; this is neglected, since it does not happen with the shipped catalogue.
        """
        opening, catalogue = turns[0].truth, self.lab.catalogue
        answers = [turn for turn in turns if turn.reward_known and turn.action is not None]
        known = [(catalogue.look_up(titles_of(turn.action)), turn.reward) for turn in answers]
        truths, odds = [], []
        for profile, unsaid in _users(opening):
            wishes = profile.wishes.values()
            fits = all(reward_of(items, wishes) == reward for items, reward in known)
            if fits and catalogue.count(wishes) >= LEAST_MATCHES:
                law = Taste.of(profile, unsaid) if opening.law else None
                truths.append(opening._replace(profile=profile, unsaid=unsaid, law=law))
                odds.append(odds_of(profile) / len(wishes))
        if not sum(odds) > 0:
            raise NoWorldError("no user with this request pays these rewards")
        return list(zip(truths, (np.array(odds) / sum(odds)).tolist(), strict=True))

    def quantities(self, turns: Sequence[WorldTurn[Truth]]) -> dict[str, float]:
        """The attribute and value of the unsaid wish, the number of titles that meet all wishes, unknown rewards."""
        profile, unsaid, *_ = turns[0].truth
        rewards = [(turn.reward, turn.reward_known) for turn in turns if turn.action is not None]
        return {
            "attribute": ATTRIBUTES.index(unsaid),
            "wish": profile.wishes[unsaid].bit_length(),
            "titles": self.lab.catalogue.count(profile.wishes.values()),
            "unknown rewards": sum(reward for reward, known in rewards if not known),
        }


def _users(opening: Truth) -> list[tuple[Profile, str]]:
    """Every user who could have made the same request, with the attribute that it leaves out."""
    profile, unsaid = opening.profile, opening.unsaid
    if unsaid == TYPE:
        return [(profile._replace(series=series), TYPE) for series in (False, True)]
    name = FIELDS[unsaid]
    nothing: dict[str, Any] = {name: Profile._field_defaults[name]}
    said = profile._replace(**nothing)
    return [
        (said._replace(**{FIELDS[attribute]: wish}), attribute)
        for attribute, wishes in _HIDDEN.items()
        if attribute not in said.wishes
        for wish in wishes
    ]
