"""Movies: a user asks for something to watch, with wishes of which one may stay unsaid.

What is recommended is looked up in a catalogue, and judged title by title and wish by wish.
"""

import json
import re
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces

from worlds.catalogue import (
    GENRES,
    PERIODS,
    Catalogue,
    age_bit,
    genre_bit,
    load_catalogue,
    period_bit,
    type_bit,
)
from worlds.spaces import Prose
from worlds.world import World, illegal

MAX_LENGTH = 10_000
"""Greatest number of characters of an answer."""
MAX_TITLES = 100
"""Greatest number of titles in an answer."""
MAX_TITLE = 200
"""Greatest number of characters of a title, a year included."""
LEAST_MATCHES = 3
"""Titles of the catalogue that must fit a user's wishes, so that wishes nobody could meet are not drawn."""
TYPE, YEAR, GENRE, AGE = ATTRIBUTES = ("type", "year", "genre", "age rating")
"""What a title is judged by, beside being in the catalogue."""
TYPE_NAMES = ("movie", "TV show")
PERIOD_NAMES = ("the 80s", "the 90s", "the 2000s", "the years since 2010")
AGE_NAMES = ("child-friendly", "family-friendly", "R-rated")

_NO_AGE = 0.4  # probability that the user has no age wish
_UNFIT = ({"Crime", "Horror", "Thriller", "War"},) * 2 + ({"Animation", "Family"},)
_DRAWS = 1000


class Profile(NamedTuple):
    """A user's wishes. Each is met by a title that has one of what it lists; an empty one does not matter."""

    series: bool
    """Whether TV shows are wanted, not movies."""
    periods: tuple[int, ...] = ()
    """Indices of `PERIODS`, in order; a series belongs to every period in which it ran."""
    genres: tuple[int, ...] = ()
    """Indices of `GENRES`, in order."""
    age: int = -1
    """Index of the age group; -1 for none."""

    @property
    def wishes(self) -> dict[str, int]:
        """Per attribute that matters the bits of which a title must have one."""
        return _wishes(self)

    def words(self, attribute: str) -> str:
        """A wish in words, such as "Comedy or Drama"; empty if the attribute does not matter."""
        if attribute == TYPE:
            return TYPE_NAMES[self.series]
        if attribute == YEAR:
            return " or ".join(PERIOD_NAMES[period] for period in self.periods)
        if attribute == GENRE:
            return " or ".join(GENRES[genre] for genre in self.genres)
        return AGE_NAMES[self.age] if self.age >= 0 else ""

    def only(self, *attributes: str) -> "Profile":
        """The same user without the other wishes; the type stays."""
        return Profile(
            self.series,
            self.periods if YEAR in attributes else (),
            self.genres if GENRE in attributes else (),
            self.age if AGE in attributes else -1,
        )


class Truth(NamedTuple):
    """A user and what was recommended last."""

    profile: Profile
    unsaid: str
    """The attribute that the request leaves out."""
    manner: tuple[int, int]
    """How the user begins and ends the request: indices of the openings and the closings."""
    answer: str
    """The last list of titles, in canonical form; empty at the start."""


class Movies(World):
    """A user to whom titles are recommended, again and again without a state.

    Observation: Dict of what the user says: `type` (Discrete(3): nothing, movie, TV show), `periods`
    (MultiBinary(4)), `genres` (MultiBinary(21)), `age` (Discrete(4): nothing, child-friendly, family-friendly,
    R-rated) and `manner` (MultiDiscrete(10, 5)), the turns of phrase. One wish is left out of it.
    Action: a `Prose`, a JSON list of 0 to 100 titles, each a string or an object with a `title` and perhaps a
    `year`; in canonical form a list of strings. Requirements on each title are to be in the catalogue and to meet
    each wish. Reward: the share of met requirements, less 1; -1 for an empty list. A title that is unknown or
    ambiguous meets none. Success: all are met. Nothing terminates.

    Args:
        catalogue: path of a catalogue that `llf catalogue import` made; None for the one that ships.

    Raises:
        ValueError: the file is no catalogue, or has less than three titles of a type.
    """

    reward_range = (-1.0, 0.0)
    failure_reward = -1.0
    action_syntax = (
        f'a JSON list of at most {MAX_TITLES} titles, such as ["Title", "Title (1999)"] or [{{"title": "Title"}}]'
    )

    def __init__(self, catalogue: str | None = None, *, render_mode: str | None = None) -> None:
        super().__init__(render_mode=render_mode, catalogue=catalogue)
        self.catalogue: Catalogue = load_catalogue(catalogue)
        if not any(self._enough(Profile(series)) for series in (False, True)):
            raise ValueError(f"the catalogue {catalogue!r} has less than {LEAST_MATCHES} titles of each type")
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
        """Draw a user with wishes that at least three titles meet."""
        super().reset(seed=seed)
        rng = self.np_random
        for _ in range(_DRAWS):
            profile = draw_profile(rng)
            if self._enough(profile):
                break
        else:
            profile = Profile(not self._enough(Profile(False)))
        wishes = tuple(profile.wishes)
        unsaid = wishes[rng.integers(len(wishes))]
        manner = int(rng.integers(len(_OPENINGS))), int(rng.integers(len(_CLOSINGS)))
        self._load(Truth(profile, unsaid, manner, ""))
        return self._observe(), {"success": False}

    @property
    def truth(self) -> Truth:
        """The user, and what was recommended last."""
        return self._truth

    def legal(self, action: Any) -> str:
        """The list of titles in canonical form."""
        answer = _canonical(str(action)) if self.action_space.contains(action) else None
        if answer is None:
            raise illegal(action, f"{self.action_syntax}; of at most {MAX_LENGTH} characters")
        return answer

    def advance(self, action: str) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Look the titles up and judge them."""
        self._truth = truth = Truth(*self._truth[:3], action)
        titles, wishes = titles_of(action), truth.profile.wishes.values()
        catalogue = self.catalogue
        met = 0
        for title in titles:
            found = catalogue.find(title)
            if len(found) == 1:
                bits = catalogue.items[found[0]].bits
                met += 1 + sum(bits & wish != 0 for wish in wishes)
        reward = met / (len(titles) * (1 + len(wishes))) - 1.0 if titles else -1.0
        return self._observe(), reward, False, False, {"success": reward == 0.0}

    def describe(self, observation: dict[str, Any]) -> str:
        """The request in the user's words."""
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
        """One to five titles of the catalogue, now and then a misspelled one or one that does not exist."""
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
        return len(self.catalogue.fitting(profile.wishes.values())) >= LEAST_MATCHES

    def _load(self, truth: Truth) -> None:
        self._truth = truth
        self._said = _said(*truth[:3])

    def _observe(self) -> dict[str, Any]:
        kind, periods, genres, age, manner = self._said
        return {
            "type": kind,
            "periods": periods.copy(),
            "genres": genres.copy(),
            "age": age,
            "manner": manner.copy(),
        }


def draw_profile(rng: np.random.Generator) -> Profile:
    """A user's wishes: a type, none to two periods and genres each, and an age group where it makes sense."""
    series = bool(rng.integers(2))
    periods = rng.permutation(len(PERIODS))[: rng.integers(3)]
    genres = rng.permutation(len(GENRES))[: rng.integers(3)]
    age = int(rng.integers(len(AGE_NAMES))) if rng.random() >= _NO_AGE else -1
    profile = Profile(series, tuple(sorted(periods.tolist())), tuple(sorted(genres.tolist())), age)
    if age >= 0 and not _UNFIT[age].isdisjoint(GENRES[genre] for genre in profile.genres):
        return profile._replace(age=-1)
    return profile


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


@lru_cache(maxsize=1024)
def _said(
    profile: Profile, unsaid: str, manner: tuple[int, int]
) -> tuple[int, np.ndarray, np.ndarray, int, np.ndarray]:
    """What the user says, in the order of the observation."""
    periods, genres = np.zeros(len(PERIODS), np.int8), np.zeros(len(GENRES), np.int8)
    if unsaid != YEAR:
        periods[list(profile.periods)] = 1
    if unsaid != GENRE:
        genres[list(profile.genres)] = 1
    kind = 0 if unsaid == TYPE else 1 + profile.series
    return kind, periods, genres, 0 if unsaid == AGE else 1 + profile.age, np.array(manner)


_FENCE = re.compile(r"```[a-z]*\n(.*)\n```", re.DOTALL)


def answer_of(titles: list[str] | tuple[str, ...]) -> str:
    """A list of titles in canonical form."""
    return json.dumps(list(titles), ensure_ascii=False)


@lru_cache(maxsize=1024)
def titles_of(answer: str) -> tuple[str, ...]:
    """The titles of an answer in canonical form."""
    return tuple(json.loads(answer)) if answer else ()


@lru_cache(maxsize=1024)
def _canonical(text: str) -> str | None:
    """The canonical form of an answer; None if it is none."""
    text = text.strip()
    fenced = _FENCE.fullmatch(text)
    try:
        entries = json.loads(fenced[1] if fenced else text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(entries, list) or len(entries) > MAX_TITLES:
        return None
    titles = [_title(entry) for entry in entries]
    answer = None if None in titles else answer_of(titles)  # type: ignore[arg-type]
    return answer if answer is not None and len(answer) <= MAX_LENGTH else None


def _title(entry: Any) -> str | None:
    """The title that an entry of an answer names, with the year if it gives one; None if it names none."""
    title, year = (entry.get("title"), entry.get("year")) if isinstance(entry, dict) else (entry, None)
    if not isinstance(title, str):
        return None
    title = " ".join(title.split())
    if isinstance(year, int) and not isinstance(year, bool) and 1000 <= year <= 9999 and f"({year})" not in title:
        title = f"{title} ({year})"
    return title if 0 < len(title) <= MAX_TITLE and title.isprintable() else None


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
