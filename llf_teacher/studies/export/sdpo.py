"""sdpo: one turn per line, as a prompt and the feedback on its answer, for self-distillation with TRL."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from llf_teacher.serialization import write_json_lines
from llf_teacher.studies.export.dialogue import exchanges, facts
from llf_teacher.studies.results import Results
from teachers.spec import check_range


def write(results: Results, path: Path, *, regret_above: float | None = None) -> int:
    """Write the file; gives the number of turns.

    The columns `prompt` and `privileged_context` are those of TRL's `SDPOTrainer` and `SDFTTrainer`: the model with the
    second column teaches the model without it. Turns without feedback are left out.

    Args:
        results: the store.
        path: the file.
        regret_above: only turns with more regret than this, and texts that were no action; None: all.
    """
    if regret_above is not None:
        check_range("regret_above", regret_above, 0, 1e9)
    return write_json_lines(path, _rows(results, regret_above))


def _rows(results: Results, regret_above: float | None) -> Iterator[dict[str, Any]]:
    for episode in results.rows():
        for exchange in exchanges(results, episode):
            row = exchange.row
            failed = row["parse_failure"] is not None
            if not row["feedback"] or not (regret_above is None or failed or row["regret"] > regret_above):
                continue
            yield {
                **facts(episode),
                "turn": row["turn"],
                "prompt": exchange.prompt,
                "privileged_context": f"{exchange.answer}\n\nThe teacher says: {row['feedback']}",
                "feedback": row["feedback"],
                "taken": exchange.action,
                "regret": row["regret"],
                "reward": row["reward"],
            }
