"""dpo: pairs of answers to the same state; the answer with less regret is chosen, the other rejected."""

import json
import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

from llf_teacher.serialization import write_json_lines
from llf_teacher.students.conversation import Conversation
from llf_teacher.studies.export.dialogue import as_answer, exchanges
from llf_teacher.studies.results import Results
from teachers.spec import check_range

_TABLE = "CREATE TABLE seen (id, seed, state, action, regret REAL, prompt, UNIQUE (id, seed, state, action))"
_STATES = "SELECT id, seed, state, action, regret, prompt FROM seen ORDER BY id, seed, state, regret, action"


def write(results: Results, path: Path, *, margin: float = 0.0) -> int:
    """Write the file; returns the number of pairs.

    A state is an observation in the world of an id and a seed. Prompts leave out earlier turns, so that both answers
    have the same prompt. The best action of any student in a state is paired with each worse one.

    Args:
        results: the store.
        path: the file.
        margin: the difference of regret that a pair must exceed.
    """
    check_range("margin", margin, 0, 1e9)
    # On disk, since a state may recur in any episode.
    with tempfile.TemporaryDirectory() as folder, closing(sqlite3.connect(Path(folder) / "seen.db")) as seen:
        seen.execute(_TABLE)
        for row in _seen(results):
            seen.execute("INSERT OR IGNORE INTO seen VALUES (?, ?, ?, ?, ?, ?)", row)
        return write_json_lines(path, _pairs(seen, margin))


def _seen(results: Results) -> Iterator[tuple[Any, ...]]:
    for episode in results.rows():
        first = None
        for exchange in exchanges(results, episode, history=0):
            row, before = exchange.row, exchange.before
            first = first or before["instruction"] or ""
            if row["parse_failure"] is not None:
                continue
            alone = {"observation": before["observation"], "instruction": first, "feedback": ""}
            prompt = json.dumps(Conversation(history=0, thought=0).ask(alone), ensure_ascii=False)
            yield episode["id"], episode["seed"], before["observation"], exchange.action, row["regret"], prompt


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
                "chosen": [{"role": "assistant", "content": as_answer(best[3])}],
                "rejected": [{"role": "assistant", "content": as_answer(row[3])}],
                "chosen_regret": best[4],
                "rejected_regret": row[4],
            }
