"""The results of each family: success and regret of every teacher with every student, and transcripts."""

import sqlite3
from collections.abc import Mapping
from typing import Any, NamedTuple

from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.students.student import TAUGHT
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.figure import Plot
from llf_teacher.studies.report.parts.part import Part
from llf_teacher.studies.store import Store, StoreError
from llf_teacher.theme import prepare_turns
from teachers.words import type_words

LONGEST, FIRST = 20, 10
"""A transcript that the study does not choose has at most so many turns; of a longer episode, only the first ones."""


class Transcript(NamedTuple):
    """An episode with its turns."""

    episode: sqlite3.Row
    """The result of `Store.episode`."""
    turns: list[dict[str, Any]]
    """The result of `prepare_turns`."""


def transcript(store: Store, spec: EpisodeSpec) -> Transcript:
    """An episode of the store with its turns.

    Raises:
        StoreError: its turns are incomplete or cannot be read.
    """
    episode, turns = store.episode(spec.key), store.turns(spec.key)
    if len(turns) != episode["turns"] + 1:
        raise StoreError(f"{store.path}: the turns of the episode {spec.key} are incomplete; see `llf study check`")
    return Transcript(episode, prepare_turns(turns, episode["family"]))


def _values(data: Data) -> Mapping[str, Any]:
    return {
        "taught": TAUGHT,
        "longest": LONGEST,
        "first": FIRST,
        "secondary": sum(map(len, data.secondary.values())),
        "transcripts": lambda section: [transcript(data.store, spec) for spec in section.transcripts],
    }


def _links(data: Data) -> list[tuple[str, str, str]]:
    return [(s.anchor, s.family.name, type_words(s.instruction_type, s.feedback_type)) for s in data.sections]


def _plots(data: Data) -> list[Plot]:
    return [plot for section in data.sections for plot in section.plots]


PART = Part("families", _values, plots=_plots, links=_links)
