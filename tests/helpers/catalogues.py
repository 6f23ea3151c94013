"""Catalogues of films, such as users make."""

import sqlite3
from contextlib import closing

from worlds.movies.catalogue import Entry, write


def write_catalogue(path, count=40, genres=("Drama",)):
    """Write so many films, one a year from 1980 on, without age ratings."""
    films = [Entry(f"Film {i}", False, 1980 + i, 1980 + i, genres, None, "made up") for i in range(count)]
    with closing(sqlite3.connect(path)) as database:
        write(database, films)
    return path
