"""Episodes that a report shows turn by turn."""

import sqlite3
from typing import Any, NamedTuple

from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.studies.store import Store, StoreError
from llf_teacher.theme import prepare_turns


class Transcript(NamedTuple):
    """An episode with its turns."""

    episode: sqlite3.Row
    """As `Store.episode` gives it."""
    turns: list[dict[str, Any]]
    """As `told` prepares them."""


def transcript(store: Store, spec: EpisodeSpec) -> Transcript:
    """An episode that the store holds.

    Raises:
        StoreError: its turns are not there, or cannot be read.
    """
    episode, turns = store.episode(spec.key), store.turns(spec.key)
    if len(turns) != episode["turns"] + 1:
        raise StoreError(f"{store.path}: the turns of the episode {spec.key} are not all there; see `llf study check`")
    return Transcript(episode, prepare_turns(turns, episode["family"]))
