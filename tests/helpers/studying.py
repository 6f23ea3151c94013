"""What tests of studies share."""

import contextlib
import sqlite3

from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.store import Store

FILE = """
ids = ["llf-gridworld-v0"]
teachers = ["oracle", "mistake(eps=0.2)", "silent"]
students = ["random", "obedient"]
feedback_types = ["a"]
seeds = 3
"""
"""A small study as a file."""


def small(**changes):
    settings = {
        "ids": ["verbal-gridworld-v0", "llf-bandits-BanditTwoArmedHighLowFixed-v0"],
        "teachers": ["oracle", "mistake( eps = 0.5 )"],
        "students": ["random", "text_only"],
        "seeds": 2,
        "max_turns": 5,
    }
    return Study(**(settings | changes))


def stored(path, study, manifest=None):
    """The path of a new store with all episodes of a study, played here."""
    return filled(path, map(play, study.episodes()), manifest)


def filled(path, records, manifest=None):
    """The path of a new store with some episodes."""
    with Store(path) as store:
        for record in records:
            store.add(record)
        if manifest is not None:
            store.write_manifest(manifest)
    return path


def rows(path):
    """All episodes and turns of a store."""
    turns = "SELECT key, packed FROM result JOIN story USING (number) ORDER BY key"
    with contextlib.closing(sqlite3.connect(path)) as db:
        return [db.execute(query).fetchall() for query in ("SELECT * FROM episode ORDER BY key", turns)]
