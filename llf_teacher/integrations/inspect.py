"""Tasks for Inspect, one a family: `inspect eval llf_teacher/gridworld --model ... -T teacher=silent -T seeds=20`.

A sample is an episode with the prompts of a study. Its scores are `llf_teacher.integrations.dialogue.SCORES`, such as
success, return and regret; all turns, with their claims, are in the sample's store.
"""

from collections.abc import Callable
from typing import Any

from inspect_ai import Task, task
from inspect_ai.dataset import Sample
from inspect_ai.model import (
    ChatMessage,
    ChatMessageAssistant,
    ChatMessageSystem,
    ChatMessageUser,
    ModelOutput,
    get_model,
)
from inspect_ai.scorer import Score, Scorer, Target, ci, mean, scorer, stderr
from inspect_ai.solver import Generate, Solver, TaskState, solver

from llf_teacher.integrations.dialogue import SCORES, Dialogue
from llf_teacher.registry import PREFIX, entry
from llf_teacher.students.conversation import Message
from llf_teacher.students.student import ModelReply
from pz_envs.family import Family, all_families
from pz_envs.settings import Settings

STORED = "llf_teacher"
"""The key of scores and turns in the sample's store."""
_CHAT: dict[str, Callable[..., ChatMessage]] = {
    "system": ChatMessageSystem,
    "user": ChatMessageUser,
    "assistant": ChatMessageAssistant,
}
_FINISH = {"max_tokens": "length", "model_length": "length"}  # the names of records


@solver
def student(**settings: Any) -> Solver:
    """The model as the student in an episode.

    Args:
        settings: of `Dialogue`, but for `id` and `seed`, which the sample's metadata have.
    """

    async def solve(state: TaskState, generate: Generate) -> TaskState:
        dialogue = Dialogue(state.metadata["id"], state.metadata["seed"], **settings)
        model = get_model()
        state.messages = _chat(dialogue.messages)
        try:
            while not (dialogue.over or state.completed):
                state.output = await model.generate(_chat(dialogue.messages))
                state.messages.append(state.output.message)
                dialogue.answer(state.output.completion, _reply_facts(state.output))
                dialogue.speak()
                state.messages += _chat(dialogue.messages[-1:])
        finally:  # a limit may end it, too
            state.store.set(STORED, {"scores": dialogue.scores(), "turns": dialogue.record()})
            dialogue.close()
        return state

    return solve


def _chat(messages: list[Message]) -> list[ChatMessage]:
    return [_CHAT[message["role"]](content=message["content"]) for message in messages]


def _reply_facts(output: ModelOutput) -> ModelReply:
    """Finish reason, seconds and tokens of an output."""
    reply: ModelReply = {"finish": _FINISH.get(output.stop_reason, output.stop_reason)}
    if output.time is not None:
        reply["seconds"] = output.time
    if output.usage is not None:
        reply |= {"input_tokens": output.usage.input_tokens, "output_tokens": output.usage.output_tokens}
    return reply


_METRICS = [mean(), stderr(cluster="seed"), ci(cluster="seed")]


@scorer(metrics=dict.fromkeys(SCORES, _METRICS))
def outcome() -> Scorer:
    """The scores of the episode; environments of one seed are one cluster, as in a study."""

    async def score(state: TaskState, target: Target) -> Score:
        return Score(value=state.store.get(STORED)["scores"])

    return score


def _task_of(family: Family) -> Callable[..., Task]:
    def play(
        ids: str | list[str] = "",
        teacher: str = "oracle",
        instruction_type: str = Settings.instruction_type,
        feedback_type: str | list[str] = "a",
        voice: str = "plain",
        max_turns: int | None = Settings.max_turns,
        seeds: int = 10,
        first_seed: int = 0,
        history: int = 20,
        max_prompt_tokens: int | None = None,
    ) -> Task:
        wanted = [ids] if isinstance(ids, str) and ids else list(ids) or [f"{PREFIX}{name}" for name in family.showcase]
        for id in wanted:
            if (found := entry(id).family.name) != family.name:
                raise ValueError(f"ids must be of the family {family.name}, got {id}, which is of {found}")
        solver = student(
            teacher=teacher,
            instruction_type=instruction_type,
            feedback_type=feedback_type,
            voice=voice,
            max_turns=max_turns,
            history=history,
            max_prompt_tokens=max_prompt_tokens,
        )
        samples = [
            Sample(input=f"{id}, seed {seed}", id=f"{id}:{seed}", metadata={"id": id, "seed": seed})
            for id in wanted
            for seed in range(first_seed, first_seed + seeds)
        ]
        metadata = {"regret_unit": family.regret_unit, "max_turns": max_turns or family.max_turns}
        return Task(dataset=samples, solver=solver, scorer=outcome(), metadata=metadata)

    play.__name__ = play.__qualname__ = family.name
    play.__doc__ = f"""{family.summary.capitalize()}, with feedback in words.

    Args:
        ids: environments of the family; by default its showcase.
        teacher, instruction_type, feedback_type, voice, max_turns: see `llf_teacher.make`.
        seeds: number of episodes of each environment, from `first_seed` on.
        history, max_prompt_tokens: limits of the conversation that is sent; see `llf_teacher.Conversation`.
    """
    made: Callable[..., Task] = task(play)
    return made


TASKS = {family.name: _task_of(family) for family in all_families()}
"""A task for each family, by its name."""
