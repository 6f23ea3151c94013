"""dpo: pairs of answers to the same state, the one of less regret chosen and the other rejected."""

import json
import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

from llf_teacher.serialization import write_json_lines
from llf_teacher.students.conversation import Conversation
from llf_teacher.studies.export.dialogue import exchanges, said
from llf_teacher.studies.results import Results
from teachers.spec import check_range

_TABLE = "CREATE TABLE seen (id, seed, state, action, regret REAL, prompt, UNIQUE (id, seed, state, action))"
_STATES = "SELECT id, seed, state, action, regret, prompt FROM seen ORDER BY id, seed, state, regret, action"


def write(results: Results, path: Path, *, margin: float = 0.0) -> int:
    """Write the file; the number of pairs.

    A state is what is seen in the world of an id and a seed; what was said and done before is left out of the prompt,
    so that both answers are to the same one. The best action that any student took there is paired with each worse one.

    Args:
        results: the store.
        path: the file.
        margin: how much less the regret must be; equal ones are no pair.
    """
    check_range("margin", margin, 0, 1e9)
    # On disk: the same state comes up in episodes that lie far apart.
    with tempfile.TemporaryDirectory() as folder, closing(sqlite3.connect(Path(folder) / "seen.db")) as seen:
        seen.execute(_TABLE)
        for row in _seen(results):
            seen.execute("INSERT OR IGNORE INTO seen VALUES (?, ?, ?, ?, ?, ?)", row)
        return write_json_lines(path, _pairs(seen, margin))


def _seen(results: Results) -> Iterator[tuple[Any, ...]]:
    for episode in results.rows():
        first = None
        for exchange in exchanges(results, episode, history=0):
            row, told = exchange.row, exchange.told
            first = first or told["instruction"] or ""
            if row["parse_failure"] is not None:
                continue
            alone = {"observation": told["observation"], "instruction": first, "feedback": ""}
            prompt = json.dumps(Conversation(history=0).ask(alone), ensure_ascii=False)
            yield episode["id"], episode["seed"], told["observation"], exchange.action, row["regret"], prompt


def _pairs(seen: sqlite3.Connection, margin: float) -> Iterator[dict[str, Any]]:
    best: tuple[Any, ...] = (None,) * 6
    for row in seen.execute(_STATES):
        if row[:3] != best[:3]:
            best = row
        elif row[4] > best[4] + margin:
            yield {
                "id": row[0],
                "seed": row[1],
                "prompt": json.loads(best[5]),
                "chosen": [{"role": "assistant", "content": said(best[3])}],
                "rejected": [{"role": "assistant", "content": said(row[3])}],
                "chosen_regret": best[4],
                "rejected_regret": row[4],
            }
