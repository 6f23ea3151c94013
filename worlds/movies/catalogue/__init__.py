"""A catalogue of films and series: facts in SQLite, an index of them in memory, and a look-up of titles.

The shipped catalogue is built from `data/catalogue.csv`; others are SQLite files, which `write` fills.
"""

import csv
import os
import sqlite3
import weakref
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from functools import cache, lru_cache, reduce
from importlib import resources
from operator import or_
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from worlds.movies.catalogue.titles import Titles

__all__ = [
    "AGES",
    "CERTIFICATES",
    "GENRES",
    "PERIODS",
    "SERIES",
    "Catalogue",
    "Entry",
    "Item",
    "age_bit",
    "aliases",
    "certificate_bit",
    "genre_bit",
    "load_catalogue",
    "period_bit",
    "shipped",
    "type_bit",
    "write",
]

SERIES = "series"
"""The `type` of a series in tables; that of a film is `film`."""
GENRES = (
    "Action", "Adventure", "Animation", "Biography", "Comedy", "Crime", "Documentary", "Drama", "Family", "Fantasy",
    "Film-Noir", "History", "Horror", "Music", "Musical", "Mystery", "Romance", "Sci-Fi", "Sport", "Superhero",
    "Thriller", "War", "Western",
)  # fmt: skip
"""The genres of profiles; others are ignored."""
CERTIFICATES = ("G", "PG", "PG-13", "R", "NC-17", "TV-Y", "TV-Y7", "TV-G", "TV-PG", "TV-14", "TV-MA")
"""The age ratings of films (MPA) and of series (TV Parental Guidelines) in the United States."""
PERIODS = ((1980, 1989), (1990, 1999), (2000, 2009), (2010, 9999))
"""First and last year of each period: the 80s, the 90s, the 2000s, and all later years."""
AGES = (
    ("G", "TV-Y", "TV-Y7", "TV-G"),
    ("G", "PG", "TV-Y", "TV-Y7", "TV-G", "TV-PG"),
    ("R", "NC-17", "TV-MA"),
)
"""The certificates that are child-friendly, family-friendly, and R-rated."""

_SCHEMA = """
CREATE TABLE title (
    id INTEGER PRIMARY KEY, title TEXT NOT NULL, series INTEGER NOT NULL,
    first INTEGER NOT NULL, last INTEGER, certificate TEXT, source TEXT NOT NULL);
CREATE TABLE genre (id INTEGER NOT NULL REFERENCES title, genre TEXT NOT NULL);
CREATE INDEX title_title ON title (title);
CREATE INDEX genre_id ON genre (id);
"""


class Entry(NamedTuple):
    """A film or a series, as given by a source."""

    title: str
    series: bool
    first: int
    """Year of the film, or of the series' beginning."""
    last: int | None
    """Year of the film, or of the series' end; None if it still runs or the end is unknown."""
    genres: tuple[str, ...]
    certificate: str | None
    """One of `CERTIFICATES`; None if it is unknown."""
    source: str
    """The source of the facts."""


class Item(NamedTuple):
    """A film or a series, as judged by the world."""

    label: str
    """The title, with the year in parentheses if several items have this title."""
    named: bool
    """Whether the label identifies this item."""
    title: str
    series: bool
    first: int
    last: int | None
    genres: tuple[str, ...]
    certificate: str | None
    bits: int
    """Its attributes: a bit for each type, period, genre, age group and certificate; see `type_bit` and others."""

    def meets(self, wishes: Iterable[int]) -> bool:
        """Whether it has one of the bits of each wish."""
        bits = self.bits
        for wish in wishes:  # noqa: SIM110  # `all` takes three times as long
            if not bits & wish:
                return False
        return True


def type_bit(series: bool) -> int:
    """The bit of films or of series."""
    return 1 << series


def period_bit(period: int) -> int:
    """The bit of a period of `PERIODS`; a series belongs to every period in which it ran."""
    return 4 << period


def genre_bit(genre: int) -> int:
    """The bit of a genre of `GENRES`."""
    return 4 << len(PERIODS) + genre


def age_bit(age: int) -> int:
    """The bit of an age group of `AGES`; an item whose certificate is unknown belongs to none."""
    return 4 << len(PERIODS) + len(GENRES) + age


def certificate_bit(certificate: str) -> int:
    """The bit of one of `CERTIFICATES`."""
    return 4 << len(PERIODS) + len(GENRES) + len(AGES) + CERTIFICATES.index(certificate)


_BITS = certificate_bit(CERTIFICATES[-1]).bit_length()


class Catalogue:
    """Films and series. A catalogue is immutable: deep copies share it, and a pickle holds its path only.

    Args:
        path: an SQLite file; None: the shipped catalogue.

    Raises:
        ValueError: the file is not a catalogue.
    """

    def __init__(self, path: str | None = None) -> None:
        self.path = path
        # Worlds may be stepped in another thread than they were made in; the database is read-only from here on.
        self._database = sqlite3.connect(":memory:", check_same_thread=False)
        weakref.finalize(self, self._database.close)
        if path is None:
            write(self._database, shipped())
        else:
            _copy(path, self._database)
        try:
            entries = list(_entries(self._database))
        except (sqlite3.Error, ValueError, TypeError) as error:
            raise _refusal(path, error) from None
        self._titles = Titles([(entry.title, entry.first) for entry in entries], aliases())
        self.items = tuple(_item(entry, *self._titles.label(i)) for i, entry in enumerate(entries))
        """All items, in the order of the source."""
        bits = np.array([item.bits for item in self.items], np.int64)
        self.bits = int(np.bitwise_or.reduce(bits))
        """The union of the items' bits."""
        self._named = _set_of([item.named for item in self.items])
        self._having = tuple(_set_of(bits >> place & 1) for place in range(_BITS))
        self._having_any = cache(self._unite)
        self._by_label = {item.label: item for item in self.items if item.named}
        self.find: Callable[[str], tuple[int, ...]] = lru_cache(maxsize=32_768)(self._titles.find)
        """The indices of the items with a title: none, one, or several if it is ambiguous."""
        self.near: Callable[[str], tuple[int, ...]] = lru_cache(maxsize=8192)(self._titles.near)
        """The indices of the items with a title of similar spelling."""
        self.look_up: Callable[[tuple[str, ...]], tuple[Item | None, ...]] = lru_cache(maxsize=1024)(self._look_up)
        """For each title, its item; None if there is none, or several."""

    def item(self, title: str) -> Item | None:
        """The item with a title; None if there is none, or several."""
        if item := self._by_label.get(title):
            return item
        found = self.find(title)
        return self.items[found[0]] if len(found) == 1 else None

    def _look_up(self, titles: tuple[str, ...]) -> tuple[Item | None, ...]:
        return tuple(map(self.item, titles))

    def fitting(self, wishes: Iterable[int]) -> np.ndarray:
        """Indices, in order, of the items with an unambiguous label that have one of the bits of each wish."""
        octets = self._fitting(wishes).to_bytes(len(self.items) // 8 + 1, "little")
        return np.flatnonzero(np.unpackbits(np.frombuffer(octets, np.uint8), bitorder="little").view(bool))

    def count(self, wishes: Iterable[int]) -> int:
        """The number of items that `fitting` returns."""
        return self._fitting(wishes).bit_count()

    def bits_of(self, wishes: Iterable[int]) -> int:
        """The union of the bits of the items that `fitting` returns."""
        fits = self._fitting(wishes)
        return sum([1 << place for place, having in enumerate(self._having) if having & fits])

    def _fitting(self, wishes: Iterable[int]) -> int:
        fits = self._named
        for wish in wishes:
            fits &= self._having_any(wish)
        return fits

    def _unite(self, wish: int) -> int:
        """The items that have any of some bits, as a bit set."""
        return reduce(or_, (having for place, having in enumerate(self._having) if wish >> place & 1), 0)

    def meets(self, title: str, wishes: Iterable[int]) -> bool:
        """Whether a title identifies an item that has one of the bits of each wish."""
        item = self.item(title)
        return item is not None and item.meets(wishes)

    def query(self, sql: str, *parameters: Any, **named: Any) -> list[tuple[Any, ...]]:
        """Query the tables `title` (id, title, series, first, last, certificate, source) and `genre` (id, genre)."""
        return self._database.execute(sql, named or parameters).fetchall()

    def __deepcopy__(self, memo: dict[int, Any]) -> "Catalogue":
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return load_catalogue, (self.path,)


def load_catalogue(path: str | os.PathLike[str] | None = None) -> Catalogue:
    """The catalogue in a file, or the shipped one; cached per process until the file changes.

    Raises:
        ValueError: there is no such file, or it is not a catalogue.
    """
    if path is None:
        return _load(None, 0, 0)
    try:
        state = os.stat(path)
    except (OSError, TypeError, ValueError) as error:
        raise ValueError(f"cannot read the catalogue {path!r}: {error}") from None
    return _load(os.path.abspath(path), state.st_mtime_ns, state.st_size)


@lru_cache(maxsize=4)
def _load(path: str | None, modified: int, size: int) -> Catalogue:
    return Catalogue(path)


def shipped() -> Iterable[Entry]:
    """The entries of the shipped catalogue."""
    for row in _rows("catalogue.csv"):
        yield Entry(
            title=row["title"],
            series=row["type"] == SERIES,
            first=int(row["first"]),
            last=int(row["last"]) if row["last"] else None,
            genres=tuple(row["genres"].split("|")),
            certificate=row["certificate"] or None,
            source=row["source"],
        )


@lru_cache(maxsize=1)
def aliases() -> tuple[tuple[str, str, int], ...]:
    """Other names of works, such as `Star Wars`: each with the title and first year of its work."""
    return tuple((row["alias"], row["title"], int(row["year"])) for row in _rows("aliases.csv"))


def _rows(name: str) -> Iterator[dict[str, str]]:
    text = resources.files(__name__).joinpath("data", name).read_text(encoding="utf-8")
    return csv.DictReader(text.splitlines())


def write(database: sqlite3.Connection, entries: Iterable[Entry]) -> int:
    """Create and fill the tables; returns the number of entries."""
    database.executescript(_SCHEMA)
    count = 0
    for count, (title, series, first, last, genres, certificate, source) in enumerate(entries, 1):
        row = (count, title, series, first, last, certificate, source)
        database.execute("INSERT INTO title VALUES (?, ?, ?, ?, ?, ?, ?)", row)
        database.executemany("INSERT INTO genre VALUES (?, ?)", [(count, genre) for genre in genres])
    database.commit()
    return count


def _copy(path: str, database: sqlite3.Connection) -> None:
    try:
        with closing(sqlite3.connect(f"{Path(path).absolute().as_uri()}?mode=ro", uri=True)) as file:
            file.backup(database)
    except sqlite3.Error as error:
        raise _refusal(path, error) from None


def _refusal(path: str | None, error: Exception) -> ValueError:
    return ValueError(f"{path} is not a catalogue ({error}); make one with `{__name__}.write`")


def _entries(database: sqlite3.Connection) -> Iterable[Entry]:
    genres: dict[int, tuple[str, ...]] = {}
    one: dict[Any, Any] = {}  # a shared object for equal values, which saves memory
    for id, genre in database.execute("SELECT id, genre FROM genre ORDER BY rowid"):
        several = (*genres.get(id, ()), one.setdefault(genre, genre))
        genres[id] = one.setdefault(several, several)
    rows = database.execute("SELECT id, title, series, first, last, certificate, source FROM title ORDER BY id")
    for id, title, series, first, last, certificate, source in rows:
        begin, end, rating = (one.setdefault(value, value) for value in (first, last, certificate))
        yield Entry(title, bool(series), begin, end, genres.get(id, ()), rating, source)


def _item(entry: Entry, label: str, named: bool) -> Item:
    title, series, first, last, genres, certificate, _ = entry
    bits = type_bit(series)
    for period, (begin, end) in enumerate(PERIODS):
        if first <= end and (last is None or last >= begin):
            bits |= period_bit(period)
    for genre in genres:
        if genre in GENRES:
            bits |= genre_bit(GENRES.index(genre))
    for age, certificates in enumerate(AGES):
        if certificate in certificates:
            bits |= age_bit(age)
    if certificate in CERTIFICATES:
        bits |= certificate_bit(certificate)
    return Item(label, named, title, series, first, last, genres, certificate, bits)


def _set_of(members: Any) -> int:
    """A set of items as an integer whose bit `i` is set if item `i` is a member, for fast intersections."""
    return int.from_bytes(np.packbits(np.asarray(members, bool), bitorder="little").tobytes(), "little")
