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
        tools: list[dict[str, Any]] = []
        turns = []
        closing = ""
        for exchange in exchanges(results, episode):
            row = exchange.row
            # What came before this episode, then each turn once, also those that later prompts leave out.
            messages = [*messages, _question(messages, exchange.question)] if messages else [*exchange.prompt]
            messages.append(exchange.completion)
            tools = exchange.tools
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
            **({"tools": tools} if tools else {}),
            "turns": turns,
            "last_feedback": closing,
            "success": episode["success"],
            "total_reward": episode["total_reward"],
            "regret": episode["regret"],
        }


def _question(messages: list[dict[str, Any]], text: str) -> dict[str, Any]:
    """A question after these messages: the result of a call, if the last one is a call."""
    calls = messages[-1].get("tool_calls")
    asker = {"role": "tool", "tool_call_id": calls[0]["id"]} if calls else {"role": "user"}
    return {**asker, "content": text}
