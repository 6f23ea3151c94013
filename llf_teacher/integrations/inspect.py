"""Tasks for Inspect, one a family: `inspect eval llf_teacher/gridworld --model ... -T teacher=silent -T seeds=20`.

The task `gym` is for environments of Gymnasium's registry: `inspect eval llf_teacher/gym -T ids=gym:FrozenLake-v1`.
The task `suite` has the scores of `llf suite`: `inspect eval llf_teacher/suite --model ... -T quick=true`.

A sample is an episode with the prompts of a study. Its scores are `llf_teacher.integrations.dialogue.SCORES`, such as
success, return and regret; all turns, with their claims, are in the sample's store.
"""

from collections.abc import Callable, Mapping, Sequence
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
from inspect_ai.scorer import (
    Metric,
    SampleScore,
    Score,
    Scorer,
    Target,
    Value,
    ci,
    mean,
    metric,
    scorer,
    stderr,
)
from inspect_ai.solver import Generate, Solver, TaskState, solver

from llf_teacher.integrations.dialogue import SCORES, Dialogue
from llf_teacher.registry import PREFIX, entry
from llf_teacher.students.conversation import Message
from llf_teacher.students.student import ModelReply
from llf_teacher.studies import run
from llf_teacher.suite import digest, studies_of
from llf_teacher.suite.experiment import TURNS, Experiment
from llf_teacher.suite.taking import QUICK_TURNS, chosen, scored, seeds_of
from pz_envs.family import Family, all_families
from pz_envs.registered import Registered
from pz_envs.settings import Settings
from pz_envs.subject import GYM

STORED = "llf_teacher"
"""The key of scores and turns in the sample's store."""
_CHAT: dict[str, Callable[..., ChatMessage]] = {
    "system": ChatMessageSystem,
    "user": ChatMessageUser,
    "assistant": ChatMessageAssistant,
}
_MODEL = "llm(model='inspect')"  # the student in the rows of the task `suite`
_FINISH = {"max_tokens": "length", "model_length": "length"}  # the names of records


@solver
def student(**settings: Any) -> Solver:
    """The model as the student in an episode.

    Args:
        settings: arguments of `Dialogue`, except those in the sample's metadata, which has at least `id` and `seed`.
    """

    async def solve(state: TaskState, generate: Generate) -> TaskState:
        dialogue = Dialogue(**settings | state.metadata)
        model = get_model()
        state.messages = _chat(dialogue.messages)
        try:
            while not (dialogue.over or state.completed):
                state.output = await model.generate(_chat(dialogue.messages))
                state.messages.append(state.output.message)
                dialogue.answer(state.output.completion, _reply_facts(state.output))
                dialogue.speak()
                state.messages += _chat(dialogue.messages[-1:])
        finally:  # a limit may also end it
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


def _task_of(family: Family | type[Registered]) -> Callable[..., Task]:
    """The task of a family, or of the environments of Gymnasium's registry."""
    name, showcase = (family.name, family.showcase) if isinstance(family, Family) else ("gym", ())

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
        options: dict[str, Any] | None = None,
    ) -> Task:
        wanted = [ids] if isinstance(ids, str) and ids else list(ids) or [f"{PREFIX}{each}" for each in showcase]
        if not wanted:
            raise ValueError(
                f"ids must have environments of Gymnasium's registry, such as {GYM}FrozenLake-v1, got none"
            )
        subjects = [entry(id).family for id in wanted]
        for id, found in zip(wanted, subjects, strict=True):
            if found is not family and type(found) is not family:
                raise ValueError(f"ids must be of the family {name}, got {id}, which is of {found.name}")
        solver = student(
            teacher=teacher,
            instruction_type=instruction_type,
            feedback_type=feedback_type,
            voice=voice,
            max_turns=max_turns,
            history=history,
            max_prompt_tokens=max_prompt_tokens,
            options=options or {},
        )
        samples = [
            Sample(input=f"{id}, seed {seed}", id=f"{id}:{seed}", metadata={"id": id, "seed": seed})
            for id in wanted
            for seed in range(first_seed, first_seed + seeds)
        ]
        turns = max_turns or max(found.max_turns for found in subjects)
        metadata = {"regret_unit": family.regret_unit, "max_turns": turns}
        return Task(dataset=samples, solver=solver, scorer=outcome(), metadata=metadata)

    summary = family.summary if isinstance(family, Family) else "environments of Gymnasium's registry"
    play.__name__ = play.__qualname__ = name
    play.__doc__ = f"""{summary.capitalize()}, with feedback in words.

    Args:
        ids: environments of the family; by default its showcase. The task `gym` has none, and needs some.
        teacher, instruction_type, feedback_type, voice, max_turns: see `llf_teacher.make`.
        seeds: number of episodes of each environment, from `first_seed` on.
        options: of the worlds, see `llf_teacher.make`.
        history, max_prompt_tokens: limits of the conversation that is sent; see `llf_teacher.Conversation`.
    """
    made: Callable[..., Task] = task(play)
    return made


TASKS = {family.name: _task_of(family) for family in all_families()} | {"gym": _task_of(Registered)}
"""A task for each family, by its name, and `gym`."""


@task
def suite(
    quick: bool = False,
    key: str = "",
    only: str | list[str] = "",
    store: str = "llf-suite.db",
    history: int = 20,
    max_prompt_tokens: int | None = None,
) -> Task:
    """What the model can do with feedback: the scores of `llf suite`, by experiment; NaN without a measured score.

    Experiments that need memory of earlier episodes are left out.

    Args:
        quick, key: as in `llf suite`.
        only: names of experiments.
        store: file for the references' episodes, which are played before the task begins.
        history, max_prompt_tokens: limits of the conversation that is sent; see `llf_teacher.Conversation`.
    """
    names = [only] if isinstance(only, str) and only else list(only)
    experiments = {name: each for name, each in chosen(names, quick).items() if not each.lessons}
    if not experiments:
        raise ValueError(f"only must have an experiment without earlier episodes, got {', '.join(names)}")
    seeds, turns = seeds_of(key, quick), QUICK_TURNS if quick else TURNS
    studies, rows = studies_of([], experiments, seeds, turns), []
    for study in studies:
        with run(study, store, 1) as results:
            keys = {each.key for each in study.episodes()}
            rows += [row for row in results.rows() if row["key"] in keys]
    samples = [
        Sample(
            input=f"{id}, {teacher}, seed {seed}",
            id=f"{id}:{teacher}:{seed}",
            metadata={"id": id, "teacher": teacher, "seed": seed, "options": dict(study.options.get(id, {}))},
        )
        for study in studies
        for id in study.ids
        for teacher in study.grid(id).teachers
        for seed in seeds
    ]
    solver = student(max_turns=turns, history=history, max_prompt_tokens=max_prompt_tokens)
    return Task(dataset=samples, solver=solver, scorer=_regret(experiments, rows), metadata={"digest": digest()})


def _regret(experiments: Mapping[str, Experiment], rows: Sequence[Mapping[str, Any]]) -> Scorer:
    """The regret of each episode, and the suite's scores over all; `rows` are the episodes of the references."""

    @metric
    def abilities() -> Metric:
        def compute(scores: list[SampleScore]) -> Value:
            own = [dict(each.score.metadata or {}) for each in scores]
            seeds = sorted({row["seed"] for row in own})
            found = {name: scored(each, _MODEL, [*rows, *own], seeds).score for name, each in experiments.items()}
            return {name: float("nan") if value is None else value for name, value in found.items()}

        return compute

    @scorer(metrics=[abilities()])
    def regret() -> Scorer:
        async def score(state: TaskState, target: Target) -> Score:
            stored = state.store.get(STORED)
            row = {name: state.metadata[name] for name in ("id", "teacher", "seed")}
            row |= {"student": _MODEL, "lessons": 0, "worlds": "", "turns": int(stored["scores"]["turns"])}
            row |= {"regrets": [turn["regret"] for turn in stored["turns"][1:]]}
            row |= {"parse_failures": int(stored["scores"]["parse_failures"])}
            return Score(value=stored["scores"]["regret"], metadata=row)

        return score

    return regret()
