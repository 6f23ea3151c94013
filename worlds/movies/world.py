"""The world of movies: a user's request, and a catalogue that judges the answers."""

from collections.abc import Collection, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces

from worlds.movies.answers import MAX_LENGTH, MAX_TITLE, MAX_TITLES, answer_of, canonical, titles_of
from worlds.movies.catalogue import GENRES, PERIODS, Catalogue, Item, load_catalogue
from worlds.movies.users import AGE, AGE_NAMES, GENRE, TYPE, YEAR, Profile, Taste, draw_profile, draw_user
from worlds.spaces import Prose
from worlds.towns import town_stream
from worlds.world import World, illegal

LEAST_MATCHES = 3
"""Number of titles in the catalogue that must meet a user's wishes; others are not drawn."""
_DRAWS = 1000


class Truth(NamedTuple):
    """A user and the last answer."""

    profile: Profile
    unsaid: str
    """The attribute that the request leaves out."""
    manner: tuple[int, int]
    """Indices of the phrases that open and close the request."""
    answer: str
    """The last list of titles, in canonical form; empty at the start."""
    law: Taste | None = None
    """What the user of the town leaves out of each request; None without a town."""


class Movies(World[Truth, dict[str, Any], str]):
    """A user to whom titles are recommended, in repeated turns without a state.

    Observation: Dict of the request: `type` (Discrete(3): nothing, movie, TV show), `periods`
    (MultiBinary(4)), `genres` (MultiBinary(23)), `age` (Discrete(4): nothing, child-friendly, family-friendly,
    R-rated) and `manner` (MultiDiscrete(10, 5)), its opening and closing. The request leaves one wish out.
    Action: a `Prose`, a JSON list of 0 to 100 titles, each a string or an object with a `title` and optionally a
    `year`; in canonical form a list of strings. Reward: the share of titles that meet every wish, minus 1; -1 for
    an empty list. Unknown and ambiguous titles meet no wish. Success: all titles meet every wish. Nothing
    terminates.

    Args:
        catalogue: path of an SQLite file that `catalogue.write` has filled; None: the shipped one.
        max_items: number of titles, from the first on, that feedback treats individually, 0 to 100; it only counts
            the others. None: all. The reward counts all titles.
        town: number of a town, at least 0, whose user leaves the same wish out of each request; None: any wish.

    Raises:
        ValueError: the file is not a catalogue, or has fewer than three titles of each type; or `max_items` is not
            allowed.
    """

    reward_range = (-1.0, 0.0)
    failure_reward = -1.0
    verbatim = False
    text_items = (1, 10)  # longer lists are allowed
    answer_names = ("titles", "recommendations", "movies", "films", "series")
    _truth: Truth
    action_syntax = (
        f'a JSON list of at most {MAX_TITLES} titles, such as ["Title", "Title (1999)"] or [{{"title": "Title"}}]'
    )

    def __init__(
        self,
        catalogue: str | None = None,
        max_items: int | None = None,
        *,
        town: int | None = None,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(render_mode=render_mode, catalogue=catalogue, max_items=max_items, town=town)
        if max_items is not None and (type(max_items) is not int or not 0 <= max_items <= MAX_TITLES):
            raise ValueError(f"max_items must be None or a whole number from 0 to {MAX_TITLES}, got {max_items!r}")
        self.max_items: int = MAX_TITLES if max_items is None else max_items
        """Number of titles that feedback treats individually."""
        self.catalogue: Catalogue = load_catalogue(catalogue)
        if not any(self._enough(Profile(series)) for series in (False, True)):
            raise ValueError(f"the catalogue {catalogue!r} has fewer than {LEAST_MATCHES} titles of each type")
        rng = town_stream("movies", town)
        self._user = self._draw(rng) if rng else None
        self.law = self._user and Taste.of(*self._user)
        """What the user leaves out of each request; None without a town."""
        self.observation_space = spaces.Dict(
            {
                "type": spaces.Discrete(3),
                "periods": spaces.MultiBinary(len(PERIODS)),
                "genres": spaces.MultiBinary(len(GENRES)),
                "age": spaces.Discrete(len(AGE_NAMES) + 1),
                "manner": spaces.MultiDiscrete([len(_OPENINGS), len(_CLOSINGS)]),
            }
        )
        self.action_space = Prose(max_length=MAX_LENGTH)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Draw a user whose wishes at least three titles meet."""
        super().reset(seed=seed, options=options)
        rng = self.np_random
        user, law = self._user, self.law
        profile, unsaid = self._draw_again(rng, user, law) if user and law else self._draw(rng)
        manner = int(rng.integers(len(_OPENINGS))), int(rng.integers(len(_CLOSINGS)))
        self._load(Truth(profile, unsaid, manner, "", law))
        return self.observe(), {"success": False}

    def _draw(self, rng: np.random.Generator) -> tuple[Profile, str]:
        """A user, and the attribute that the request leaves out."""
        for _ in range(_DRAWS):
            profile = draw_profile(rng)
            if self._enough(profile):
                break
        else:
            profile = Profile(not self._enough(Profile(False)))
        wishes = tuple(profile.wishes)
        return profile, wishes[rng.integers(len(wishes))]

    def _draw_again(self, rng: np.random.Generator, user: tuple[Profile, str], law: Taste) -> tuple[Profile, str]:
        """The user of the town: the town's wish stays, the other wishes are drawn."""
        for _ in range(_DRAWS):
            profile = draw_user(rng, law)
            if profile and self._enough(profile):
                return profile, law.attribute
        return user

    @property
    def truth(self) -> Truth:
        """The user and the last answer."""
        return self._truth

    def read(self, text: str) -> str | None:
        """The list of titles in canonical form."""
        return canonical(text) if len(text) <= MAX_LENGTH else None

    def legal(self, action: Any) -> str:
        """The list of titles in canonical form."""
        answer = canonical(str(action)) if self.action_space.contains(action) else None
        if answer is None:
            raise illegal(action, f"{self.action_syntax}; of at most {MAX_LENGTH} characters")
        return answer

    def advance(self, action: str) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Look up the titles and judge them."""
        profile, unsaid, manner, _, law = self._truth
        self._truth = Truth(profile, unsaid, manner, action, law)
        reward = reward_of(self.catalogue.look_up(titles_of(action)), profile.wishes.values())
        return self.observe(), reward, False, False, {"success": reward == 0.0}

    def observe(self) -> dict[str, Any]:
        """The request."""
        kind, periods, genres, age, manner = self._said
        return {
            "type": kind,
            "periods": periods.copy(),
            "genres": genres.copy(),
            "age": age,
            "manner": manner.copy(),
        }

    def describe(self, observation: dict[str, Any]) -> str:
        """The request as text."""
        kind, age = int(observation["type"]), int(observation["age"])
        periods, genres = (np.flatnonzero(observation[name]).tolist() for name in ("periods", "genres"))
        said = Profile(kind == 2, tuple(periods), tuple(genres), age - 1)
        opening, closing = observation["manner"]
        words = [said.words(AGE)] if age else []
        words.append(("titles of any kind", "movies", "TV shows")[kind])
        if genres:
            words.append(f"of the genre {said.words(GENRE)}")
        if periods:
            words.append(f"from {said.words(YEAR)}")
        return f"{_OPENINGS[opening].format(' '.join(words))} {_CLOSINGS[closing]}"

    def sample_action(self, rng: np.random.Generator) -> str:
        """One to five titles of the catalogue, some of them misspelled or invented."""
        items = self.catalogue.items
        titles = []
        for draw, slip in rng.random((int(rng.integers(1, 6)), 2)).tolist():
            item = items[int(draw * len(items))]
            title = item.label if slip < 0.9 else item.title
            if slip < 0.1:
                title = title[:2] + title[3:]
            elif slip < 0.15:
                title = _UNKNOWN[int(draw * len(_UNKNOWN))]
            titles.append(title[:MAX_TITLE])
        return answer_of(titles)

    def _enough(self, profile: Profile) -> bool:
        return self.catalogue.count(profile.wishes.values()) >= LEAST_MATCHES

    def _load(self, truth: Truth) -> None:
        self._truth = truth
        self._said = _said(*truth[:3])


def reward_of(items: Sequence[Item | None], wishes: Collection[int]) -> float:
    """The reward for the items of a list of titles; an item is None if its title finds none."""
    met = sum([item is not None and item.meets(wishes) for item in items])
    return met / len(items) - 1.0 if items else -1.0


@lru_cache(maxsize=1024)
def _said(
    profile: Profile, unsaid: str, manner: tuple[int, int]
) -> tuple[int, np.ndarray, np.ndarray, int, np.ndarray]:
    """The parts of the request, in the order of the observation."""
    periods, genres = np.zeros(len(PERIODS), np.int8), np.zeros(len(GENRES), np.int8)
    if unsaid != YEAR:
        periods[list(profile.periods)] = 1
    if unsaid != GENRE:
        genres[list(profile.genres)] = 1
    kind = 0 if unsaid == TYPE else 1 + profile.series
    return kind, periods, genres, 0 if unsaid == AGE else 1 + profile.age, np.array(manner)


_OPENINGS = (
    "I am looking for {}.",
    "Could you recommend me {}?",
    "Tonight I would like to watch {}.",
    "My friends and I have been talking about {}; we could do with a tip.",
    "What do you know in the way of {}?",
    "I am in the mood for {}.",
    "Please help me to find {}.",
    "It is raining, and I have time for {}.",
    "For the weekend I need {}.",
    "Can you think of {} for me?",
)
_CLOSINGS = (
    "Thank you!",
    "I look forward to your list.",
    "What would you suggest?",
    "A few ideas would be welcome.",
    "I will watch whatever you name.",
)
_UNKNOWN = ("The Glimmerfoam Heist", "Seventeen Umbrellas of Doctor Vole", "Turnip Season", "Nine Lighthouses Away")
