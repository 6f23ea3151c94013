"""A stored episode as a chat model would have had it."""

import json
from collections.abc import Iterator
from functools import cache
from typing import Any, NamedTuple

from llf_teacher.registry import entry
from llf_teacher.serialization import to_json
from llf_teacher.students.conversation import Conversation
from llf_teacher.studies.results import Results
from teachers.atoms import FP

Message = dict[str, Any]


class Answered(NamedTuple):
    """One turn: what was asked, and what was answered."""

    prompt: list[Message]
    """All that was sent: instruction, past turns, and the question."""
    action: str
    """What the student did, as it is written in text mode."""
    answer: str
    """What a model answered, without its thoughts; of other students `said(action)`."""
    thought: str
    """What a model thought before; empty if that is not known."""
    row: dict[str, Any]
    """The turn, as fields of `TurnRow`."""
    told: dict[str, Any]
    """The turn before it, at whose end the student was told what it knows."""


def exchanges(results: Results, episode: dict[str, Any], history: int = 1000) -> Iterator[Answered]:
    """The turns of an episode."""
    told, *turns = results.turns(episode["key"])
    conversation = Conversation(history=history)
    instruction = told["instruction"] or ""
    for turn in turns:
        left = episode["max_turns"] - turn["turn"] + 1
        seen = {"observation": told["observation"], "instruction": instruction, "feedback": told["feedback"]}
        action = written(episode["id"], turn)
        answer = turn.get("answer") or said(action)
        yield Answered(conversation.ask(seen, left), action, answer, turn.get("thought") or "", turn, told)
        conversation.answer(answer)
        told, instruction = turn, ""


def said(action: str) -> str:
    """An answer of a chat model with an action, as its prompt asks for it."""
    return f"Response: {action}"


def written(id: str, turn: dict[str, Any]) -> str:
    """What was done in a turn, as it is written in text mode; of a text that was no action, its beginning."""
    failed: str | None = turn["parse_failure"]
    return failed if failed is not None else spelt(id, turn["action"])


def spelt(id: str, action: Any) -> str:
    """An action, decoded from JSON, as it is written in text mode: in a word if there is one for it."""
    return action if isinstance(action, str) else _words(id).get(to_json(action), to_json(action))


@cache
def _words(id: str) -> dict[str, str]:
    """The words for actions, each by the action in JSON."""
    found = entry(id)
    words = found.family.make_world(**found.options).action_words
    return {to_json(action): word for word, action in words.items()}


def advised(row: dict[str, Any]) -> Any:
    """The action that true advice of a turn names for the next one; None if there is none, or more than one."""
    actions = {
        json.dumps(atom["action"]): atom["action"]
        for atom in row["atoms"]
        if atom["kind"] == FP and atom["holds"] and atom["action"] is not None and atom["about_turn"] == row["turn"]
    }
    return actions.popitem()[1] if len(actions) == 1 else None


def facts(episode: dict[str, Any]) -> dict[str, Any]:
    """What tells an episode from others."""
    names = ("key", "id", "family", "teacher", "student", "instruction_type", "feedback_type", "seed", "sample")
    return {name: episode[name] for name in names}
