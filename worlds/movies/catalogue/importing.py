"""Import of catalogues from the public files of IMDb and MovieLens, row by row.

- IMDb (its non-commercial datasets): `title.basics.tsv`, gzipped or not, and optionally `title.ratings.tsv` to
  leave out titles with few votes. Films and series are imported, except for adult titles.
- MovieLens: the table with the columns `movieId`, `title` and `genres`, whose titles end with a year. All are films.

Neither has certificates, so that the age rating of imported items is unknown: they meet no age wish, and a world
with such a catalogue draws none.
"""

import csv
import gzip
import os
import re
import sqlite3
import zlib
from collections.abc import Callable, Generator, Iterator
from contextlib import closing
from importlib import resources
from io import TextIOWrapper
from pathlib import Path
from typing import Any, NamedTuple, TypeGuard

from worlds.movies.catalogue import GENRES, SERIES, Catalogue, Entry, write

__all__ = ["BASICS", "LONGEST", "RATINGS", "Imported", "Progress", "import_catalogue"]

BASICS = (
    "tconst", "titleType", "primaryTitle", "originalTitle", "isAdult", "startYear", "endYear", "runtimeMinutes",
    "genres",
)  # fmt: skip
"""The columns of IMDb's `title.basics.tsv`."""
RATINGS = ("tconst", "averageRating", "numVotes")
"""The columns of IMDb's `title.ratings.tsv`."""
_MOVIELENS = ("movieId", "title", "genres")  # the columns of MovieLens's table of titles
LONGEST = 180
"""Greatest number of characters of a title; items with longer ones are left out."""
_YEARS = range(1870, 2200)
_NONE = "\\N"
_ALIASES = {"Children": "Family", "Children's": "Family"}  # MovieLens's names of `GENRES`
_DATED = re.compile(r"(.+?)\s*\((\d{4})\)\s*")
_ARTICLE_LAST = re.compile(r"(.+), (The|An?)((?: \(.*\))?)")


class Imported(NamedTuple):
    """The result of an import."""

    taken: int
    """Number of items in the new catalogue."""
    left_out: int
    """Number of rows of another type, without a year, or with too few votes."""


Progress = Callable[[int, int], None]
"""A callback that takes the bytes read so far and the total bytes."""


def import_catalogue(
    source: Path, target: Path, ratings: Path | None = None, least_votes: int = 0, progress: Progress | None = None
) -> Imported:
    """Make a catalogue of a file of IMDb or MovieLens, which its first line identifies.

    The target is replaced in one step at the end: after an error it is unchanged.

    Args:
        source: the file, gzipped or not.
        target: the SQLite file to write.
        ratings: IMDb's `title.ratings.tsv`, gzipped or not.
        least_votes: least number of votes of an item, at least 0; more than 0 requires `ratings`.
        progress: called about every thousand rows.

    Raises:
        ValueError: a file cannot be read or written, or is damaged; the message names the file and the line.
    """
    if least_votes < 0:
        raise ValueError(f"least_votes must be at least 0, got {least_votes}")
    if least_votes and ratings is None:
        raise ValueError(f"least_votes={least_votes} requires ratings, the path of IMDb's title.ratings.tsv, got None")
    try:
        votes = _votes(ratings, least_votes) if ratings else None
        file = target.with_name(f".{target.name}.{os.getpid()}")
        try:
            return _fill(file, source, target, votes, progress)
        finally:
            file.unlink(missing_ok=True)
    except (OSError, sqlite3.Error) as error:
        raise ValueError(f"cannot import {source} into {target}: {error}") from None


def _fill(file: Path, source: Path, target: Path, votes: set[str] | None, progress: Progress | None) -> Imported:
    rows = _Rows(source, progress)
    with closing(sqlite3.connect(file)) as database:
        taken = write(database, (entry for entry in _entries(rows, votes) if entry))
    if not taken:
        raise ValueError(f"{source}: none of {rows.count} rows is a film or a series with a year")
    Catalogue(str(file))  # it must open again
    os.replace(file, target)
    return Imported(taken, rows.count - taken)


class _Rows:
    """The lines of a file, decompressed and counted.

    Args:
        path: the file.
        progress: called about every thousand lines.
    """

    def __init__(self, path: Path, progress: Progress | None = None) -> None:
        self.path = path
        self.count = 0
        self._progress = progress

    def lines(self) -> Generator[str, None, None]:
        """The lines, without line ends.

        Raises:
            ValueError: the file is damaged.
        """
        size = self.path.stat().st_size
        number = 0
        with self.path.open("rb") as raw:
            packed = raw.read(2) == b"\x1f\x8b"
            raw.seek(0)
            stream: Any = gzip.GzipFile(fileobj=raw) if packed else raw
            with TextIOWrapper(stream, encoding="utf-8-sig", newline="\n") as text:
                try:
                    for number, line in enumerate(text, 1):
                        if self._progress and number % 1000 == 1:
                            self._progress(raw.tell(), size)
                        self.count = number - 1
                        yield line.rstrip("\r\n")
                except (EOFError, gzip.BadGzipFile, zlib.error, UnicodeDecodeError) as error:
                    raise ValueError(f"{self.path} is damaged after line {number}: {error}") from None
        if self._progress:
            self._progress(size, size)

    def damaged(self, line: int, what: str) -> ValueError:
        """The error for a malformed line."""
        return ValueError(f"{self.path}, line {line}: {what}")


def _entries(rows: _Rows, votes: set[str] | None) -> Iterator[Entry | None]:
    """The items; None for a row that is left out."""
    with closing(rows.lines()) as lines:
        yield from _read(rows, lines, votes)


def _read(rows: _Rows, lines: Iterator[str], votes: set[str] | None) -> Iterator[Entry | None]:
    header = next(lines, "")
    if tuple(header.split("\t")) == BASICS:
        yield from _imdb(rows, lines, votes)
    elif tuple(header.split(",")) == _MOVIELENS:
        if votes is not None:
            raise ValueError(f"{rows.path}: ratings apply to IMDb's titles only, got MovieLens's; allowed: None")
        yield from _movielens(rows, lines)
    else:
        raise rows.damaged(
            1,
            f"got {header[:80]!r}; allowed: the columns of IMDb's title.basics.tsv ({', '.join(BASICS)}), separated by "
            f"tabs, or of MovieLens ({','.join(_MOVIELENS)})",
        )


def _imdb(rows: _Rows, lines: Iterator[str], votes: set[str] | None) -> Iterator[Entry | None]:
    types = _title_types()
    for number, line in enumerate(lines, 2):
        cells = line.split("\t")
        if len(cells) != len(BASICS):
            raise rows.damaged(number, f"has {len(cells)} columns, not {len(BASICS)}")
        id, title_type, title, _, adult, first, last, _, genres = cells
        if not re.fullmatch(r"tt\d+", id):
            raise rows.damaged(number, f"an id such as tt0133093 was expected, got {id[:80]!r}")
        series = types.get(title_type)
        if series is None or adult != "0" or first == _NONE or not _sayable(title):
            yield None
            continue
        if votes is not None and id not in votes:
            yield None
            continue
        begin = _year(rows, number, first)
        end = begin if not series else None if last == _NONE else _year(rows, number, last)
        yield Entry(title, series, begin, end, _genres(genres.split(",")), None, f"IMDb title.basics {id}")


def _movielens(rows: _Rows, lines: Iterator[str]) -> Iterator[Entry | None]:
    try:
        for number, cells in enumerate(csv.reader(lines, strict=True), 2):
            if len(cells) != len(_MOVIELENS):
                raise rows.damaged(number, f"has {len(cells)} columns, not {len(_MOVIELENS)}")
            id, text, genres = cells
            if not id.isdecimal():
                raise rows.damaged(number, f"a number was expected as movieId, got {id[:80]!r}")
            dated = _DATED.fullmatch(text)
            title = dated and _ARTICLE_LAST.sub(r"\2 \1\3", dated[1])
            if not dated or not _sayable(title):
                yield None
                continue
            year = _year(rows, number, dated[2])
            yield Entry(title, False, year, year, _genres(genres.split("|")), None, f"MovieLens movieId {id}")
    except csv.Error as error:
        raise ValueError(f"{rows.path} is damaged: {error}") from None


def _votes(path: Path, least: int) -> set[str]:
    """The ids with at least this number of votes."""
    rows, ids = _Rows(path), set()
    with closing(rows.lines()) as lines:
        header = next(lines, "")
        if tuple(header.split("\t")) != RATINGS:
            allowed = f"allowed: the columns of title.ratings.tsv ({', '.join(RATINGS)})"
            raise rows.damaged(1, f"got {header[:80]!r}; {allowed}")
        for number, line in enumerate(lines, 2):
            cells = line.split("\t")
            if len(cells) != len(RATINGS) or not cells[2].isdecimal():
                raise rows.damaged(number, f"an id, a rating and a number of votes were expected, got {line[:80]!r}")
            if int(cells[2]) >= least:
                ids.add(cells[0])
    return ids


def _title_types() -> dict[str, bool]:
    """For each of IMDb's title types to import, whether it is a series."""
    text = resources.files("worlds.movies.catalogue").joinpath("data/imdb_title_types.csv").read_text(encoding="utf-8")
    return {row["title_type"]: row["type"] == SERIES for row in csv.DictReader(text.splitlines())}


def _year(rows: _Rows, number: int, digits: str) -> int:
    if not (digits.isdecimal() and int(digits) in _YEARS):
        raise rows.damaged(number, f"a year was expected, got {digits[:80]!r}")
    return int(digits)


def _sayable(title: str | None) -> TypeGuard[str]:
    return title is not None and 0 < len(title) <= LONGEST and title.isprintable() and title == " ".join(title.split())


def _genres(names: list[str]) -> tuple[str, ...]:
    known = {_ALIASES.get(name, name) for name in names}
    return tuple(genre for genre in GENRES if genre in known)
