"""sft: one turn per line, as prompt and completion, for supervised fine-tuning."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from llf_teacher.serialization import write_json_lines
from llf_teacher.students.conversation import reply_of
from llf_teacher.studies.export.dialogue import advised, as_answer, exchanges, facts, spell
from llf_teacher.studies.results import Results
from teachers.spec import check_range


def write(
    results: Results,
    path: Path,
    *,
    success: bool = False,
    regret_below: float | None = None,
    hindsight: bool = False,
) -> int:
    """Write the file; returns the number of turns.

    Args:
        results: the store.
        path: the file.
        success: only episodes that end in success.
        regret_below: only turns with less regret than this, or with a hindsight completion; None: all.
        hindsight: whether true advice of a single action replaces the student's action; the column `hindsight` then is
            true.
    """
    if regret_below is not None:
        check_range("regret_below", regret_below, 0, 1e9)
    for name, value in (("success", success), ("hindsight", hindsight)):
        if not isinstance(value, bool):
            raise ValueError(f"{name} must be True or False, got {value!r}")
    return write_json_lines(path, _rows(results, success, regret_below, hindsight))


def _rows(results: Results, success: bool, regret_below: float | None, hindsight: bool) -> Iterator[dict[str, Any]]:
    for episode in results.rows():
        if success and not episode["success"]:
            continue
        for exchange in exchanges(results, episode):
            row = exchange.row
            better = advised(exchange.before) if hindsight else None
            if better is None and (
                row["parse_failure"] is not None or (regret_below is not None and row["regret"] >= regret_below)
            ):
                continue
            prompt, completion, tools = exchange.prompt, exchange.completion, exchange.tools
            if better is not None:  # the model was asked for more than this: for a thought, or for JSON
                prompt, completion, tools = exchange.plain, reply_of(as_answer(spell(episode["id"], better))), []
            yield {
                **facts(episode),
                "turn": row["turn"],
                "prompt": prompt,
                "completion": [completion],
                **({"tools": tools} if tools else {}),
                "hindsight": better is not None,
                "taken": exchange.action,
                "thought": exchange.thought if better is None else "",
                "regret": row["regret"],
                "reward": row["reward"],
            }
