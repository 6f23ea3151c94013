"""Stored episodes as messages to and from a chat model."""

import json
from collections.abc import Iterator
from functools import cache
from typing import Any, NamedTuple

from llf_teacher.registry import entry
from llf_teacher.serialization import to_json
from llf_teacher.students.conversation import Conversation, Message, reply_of, text_of
from llf_teacher.studies.results import Results
from teachers.atoms import FP


class Answered(NamedTuple):
    """One turn: a prompt and its answer."""

    prompt: list[Message]
    """The messages: instruction, past turns, and the question. For a model those that it was sent, if they were kept,
    else those of the form in which it was asked; for other students a prompt for the action alone."""
    question: str
    """This turn's own question, at the end of the prompt; the end may also have earlier questions without answers."""
    completion: Message
    """The answer of a model, without its thoughts, as it was asked for; for other students `as_answer(action)`."""
    tools: list[dict[str, Any]]
    """The tools that the model could call, if it was asked for a call."""
    action: str
    """The action as text, as in text mode."""
    plain: list[Message]
    """A prompt that asks for the action alone, to be answered by `as_answer`."""
    thought: str
    """The thoughts of a model; empty if unknown."""
    row: dict[str, Any]
    """The turn, as fields of `TurnRow`."""
    before: dict[str, Any]
    """The previous turn, whose feedback the student has heard."""


def exchanges(results: Results, episode: dict[str, Any], history: int = 1000) -> Iterator[Answered]:
    """The turns of an episode; prompts that were not kept have at most `history` past turns."""
    before, *turns = results.turns(episode["key"])
    form = next((turn["form"] for turn in turns if turn["form"]), "text")
    plain, formed = Conversation(history=history, thought=0), Conversation(history=history, answer=form)
    instruction, asked = before["instruction"] or "", ""
    for turn in turns:
        left = episode["max_turns"] - turn["turn"] + 1
        seen = {"observation": before["observation"], "instruction": instruction, "feedback": before["feedback"]}
        action, answer = action_text(episode["id"], turn), turn["answer"]
        alone = prompt = plain.ask(seen, left)
        completion = reply_of(as_answer(action))
        plain.answer(as_answer(action))
        fields: dict[str, Any] = {}
        if answer is not None:
            call = f"call_{turn['turn']}" if form == "tool" and turn["parse_failure"] is None else ""
            prompt, completion, fields = formed.ask(seen, left), reply_of(answer, call), formed.options
            formed.answer(answer, call=call)
            if turn["asked"]:
                prompt, fields = _without_images(turn["asked"]["messages"]), turn["asked"]["fields"]
        merged = prompt[-1]["content"]
        question, asked = merged.removeprefix(f"{asked}\n\n") if asked else merged, merged
        thought, tools = turn["thought"] or "", fields.get("tools", [])
        yield Answered(prompt, question, completion, tools, action, alone, thought, turn, before)
        before, instruction = turn, ""


def _without_images(messages: list[Message]) -> list[Message]:
    """Messages as texts, since records keep no images."""
    texts = [
        message | {"content": text_of(message)} if isinstance(message["content"], list) else message
        for message in messages
    ]
    return [message for message in texts if message["content"] != "" or message["role"] == "system"]


def as_answer(action: str) -> str:
    """An action in the form of an answer that the prompts request."""
    return f"Response: {action}"


def action_text(id: str, turn: dict[str, Any]) -> str:
    """The action of a turn as text, as in text mode; for a text that was not an action, its beginning."""
    failed: str | None = turn["parse_failure"]
    return failed if failed is not None else spell(id, turn["action"])


def spell(id: str, action: Any) -> str:
    """An action, decoded from JSON, as text: its word if it has one, else JSON."""
    return action if isinstance(action, str) else _words(id).get(to_json(action), to_json(action))


@cache
def _words(id: str) -> dict[str, str]:
    """The word of each action, by the action as JSON."""
    found = entry(id)
    words = found.family.make_world(**found.options).action_words
    return {to_json(action): word for word, action in words.items()}


def advised(row: dict[str, Any]) -> Any:
    """The only action that true advice names for the next turn; None without such advice, or with several actions."""
    actions = {
        json.dumps(atom["action"]): atom["action"]
        for atom in row["atoms"]
        if atom["kind"] == FP and atom["holds"] and atom["action"] is not None and atom["about_turn"] == row["turn"]
    }
    return actions.popitem()[1] if len(actions) == 1 else None


def facts(episode: dict[str, Any]) -> dict[str, Any]:
    """The fields that identify an episode."""
    names = ("key", "id", "family", "teacher", "student", "instruction_type", "feedback_type", "seed", "sample")
    return {name: episode[name] for name in names}
