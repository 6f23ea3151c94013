"""Episodes that a report shows turn by turn."""

import json
import sqlite3
from typing import Any, NamedTuple

from llf_teacher.studies.store import Store, StoreError
from llf_teacher.studies.study import EpisodeSpec
from teachers.atoms import KINDS, Label

KIND_NAMES = {
    "r": "reward",
    "hp": "hindsight positive: what was good",
    "hn": "hindsight negative: what was bad",
    "fp": "future positive: what to do",
    "fn": "future negative: what to avoid",
    None: "instruction or notice",
}
MARKS = {
    Label.TRUTHFUL: "✓ true",
    Label.LATE: "✓ true, late",
    Label.PLACEBO: "✓ true, placebo",
    Label.DISTORTED: "✗ false",
}


class Transcript(NamedTuple):
    """An episode with its turns."""

    episode: sqlite3.Row
    """As `Store.episode` gives it."""
    turns: list[dict[str, Any]]
    """As `Store.turns` gives them, with `said`, atoms by kind, each with its claim as `code`, with `spelled_out`,
    whether these make up all of the text, and with `did`, the action in words.
    """


def transcript(store: Store, spec: EpisodeSpec) -> Transcript:
    """An episode that the store holds.

    Raises:
        StoreError: its turns are not there, or cannot be read.
    """
    episode, turns = store.episode(spec.key), store.turns(spec.key)
    if len(turns) != episode["turns"] + 1:
        raise StoreError(f"{store.path}: the turns of the episode {spec.key} are not all there; see `llf study check`")
    for turn in turns:
        atoms = turn["atoms"]
        for atom in atoms:
            fields = ", ".join(f"{name}={_plain(value)}" for name, value in atom["fields"].items())
            name = atom["claim"].removeprefix(f"{episode['family']}.")
            atom["code"] = f"{name}({fields})"
        text = " ".join(filter(None, (turn["instruction"], turn["feedback"])))
        turn["said"] = {kind: said for kind in (None, *KINDS) if (said := [a for a in atoms if a["kind"] == kind])}
        turn["spelled_out"] = text == " ".join(atom["text"] for atom in atoms)
        turn["did"] = turn["action_words"] or turn["action"]
    return Transcript(episode, turns)


def _plain(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)
