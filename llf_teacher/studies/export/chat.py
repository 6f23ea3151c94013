"""chat: one episode per line, as messages, with the facts of each turn."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from llf_teacher.serialization import write_json_lines
from llf_teacher.studies.export.dialogue import exchanges, facts
from llf_teacher.studies.results import Results


def write(results: Results, path: Path) -> int:
    """Write the file; returns the number of episodes."""
    return write_json_lines(path, _rows(results))


def _rows(results: Results) -> Iterator[dict[str, Any]]:
    for episode in results.rows():
        messages: list[dict[str, Any]] = []
        turns = []
        closing = ""
        for exchange in exchanges(results, episode):
            row = exchange.row
            messages = [*exchange.prompt, {"role": "assistant", "content": exchange.answer}]
            closing = row["feedback"]
            turns.append(
                {
                    "action": exchange.action,
                    "thought": exchange.thought,
                    "reward": row["reward"],
                    "regret": row["regret"],
                    "success": row["success"],
                    "parse_failure": row["parse_failure"] is not None,
                    "heard": [
                        {"kind": f"{atom['kind'] or 'brief'}", "label": f"{atom['label']}"}
                        for atom in exchange.before["atoms"]
                    ],
                }
            )
        yield {
            **facts(episode),
            "messages": messages,
            "turns": turns,
            "last_feedback": closing,
            "success": episode["success"],
            "total_reward": episode["total_reward"],
            "regret": episode["regret"],
        }
