"""An environment for verifiers (v1): a taskset of episodes, and two seats; a model may play either or both.

verifiers finds environments as modules of one name. A file `llf.py` with this line is one, for `vf-eval llf`:

    from llf_teacher.integrations.verifiers import LLFHarness, LLFSeats, LLFTaskset, __all__

A trace has the return as its reward, the other names of `SCORES` as metrics, and all turns with their words in its
info. verifiers averages rewards and metrics over all traces. So with tasks of several families, which measure returns
and regrets in different units, the reward is success, and neither is a metric.
"""

import itertools
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any

import verifiers.v1 as vf
from openai import AsyncOpenAI
from pydantic import Field
from verifiers.v1.dialects.chat import message_to_wire

from llf_teacher.integrations.dialogue import SCORES, Dialogue
from llf_teacher.registry import PREFIX, entry
from pz_envs.family import all_families
from pz_envs.settings import Settings

__all__ = ["LLFHarness", "LLFSeats", "LLFTaskset"]

_OF_UNITS = ("return", "regret")
"""Scores in a family's own unit."""

_TEACHING = """You teach a student who learns a task by doing it. The student was told this:

{instruction}

After each of its actions you are told what it did, what it sees now, and what is known to be true of that. Your answer
is all that the student hears of it before it acts again. Say what helps it most, in a sentence or two."""
_TURN = "The student did this: {action}\n\nIt sees this: {state}\n\nWhat is known: {suggestion}\n\nWhat do you say?"


class LLFData(vf.TaskData):
    """An episode to play."""

    env_id: str
    """An id of `llf_teacher.ids()`."""
    seed: int


class LLFTask(vf.Task[LLFData]):
    """An episode; `LLFSeats` records its results."""


class LLFTasksetConfig(vf.TasksetConfig):
    """The episodes of a taskset."""

    env_ids: list[str] = Field([])
    """Ids of `llf_teacher.ids()`, in turn; empty: the showcases of all families."""
    first_seed: int = 0


class LLFTaskset(vf.Taskset[LLFTask, LLFTasksetConfig]):
    """All episodes of some environments, seed after seed; infinite."""

    INFINITE = True

    def load(self) -> Iterator[LLFTask]:
        """The tasks, named by id and seed, as in `...-v0:7`."""
        ids = _ids(self.config.env_ids)
        for seed in itertools.count(self.config.first_seed):
            for id in ids:
                yield LLFTask(LLFData(name=f"{id}:{seed}", env_id=id, seed=seed), self.config.task)


def _ids(given: Sequence[str]) -> list[str]:
    """These ids, or the showcases of all families if there are none."""
    showcase = [f"{PREFIX}{name}" for family in all_families() for name in family.showcase]
    return [entry(id).id for id in given or showcase]


class LLFHarness(vf.Harness[vf.HarnessConfig]):
    """A bare conversation in this process: it installs nothing and runs no code."""

    APPENDS_SYSTEM_PROMPT = True
    SUPPORTS_RESUME = True
    EXECUTES_CODE = False
    NEEDS_CONTAINER = False

    @cached_property
    def client(self) -> AsyncOpenAI:
        """Holds the connections; each request sets address and key."""
        return AsyncOpenAI(base_url="http://127.0.0.1", api_key="none", max_retries=0)

    async def launch(
        self,
        ctx: vf.ModelContext,
        trace: vf.Trace,
        runtime: vf.Runtime,
        endpoint: str,
        secret: str,
        mcp_urls: dict[str, str],
        data: vf.TaskData,
    ) -> vf.ProgramResult:
        """Ask for one answer."""
        system, prompt = self.resolve_prompt(data)
        messages: list[Any] = [{"role": "system", "content": system}] if system else []
        if isinstance(prompt, str):
            messages.append({"role": "user", "content": prompt})
        else:
            messages += map(message_to_wire, prompt or ())
        client = self.client.with_options(base_url=endpoint, api_key=secret)
        await client.chat.completions.create(model=ctx.model, messages=messages)
        return vf.ProgramResult(exit_code=0, stdout="", stderr="")


_SEAT = vf.AgentConfig(runtime=vf.SubprocessConfig())  # the harness does not use it


_SETTINGS = {"instruction_type", "feedback_type", "voice", "max_turns"}  # settings of the lesson in the configuration


class LLFSeatsConfig(vf.EnvConfig):
    """The agents in the seats, and the settings of an episode."""

    student: vf.AgentConfig = _SEAT
    teacher: vf.AgentConfig = _SEAT
    """Speaks only if `model_teaches`; the personality gives instruction and known facts in either case."""
    model_teaches: bool = False
    personality: str = "oracle"
    """The teacher's, as in `llf_teacher.make(..., teacher=...)`."""
    instruction_type: str = Settings.instruction_type
    feedback_type: str = "a"
    voice: str = "plain"
    max_turns: int | None = Settings.max_turns
    """Turns of an episode; None: the family's."""
    reward: str = ""
    """The score that is the reward, one of `SCORES`; empty: the return, or success if there are several families."""


class LLFSeats(vf.Env[LLFSeatsConfig]):
    """One task is one episode of a student and its teacher."""

    def __init__(self, config: LLFSeatsConfig) -> None:
        super().__init__(config)
        ids = _ids(getattr(config.taskset, "env_ids", ()))
        families = sorted({entry(id).family.name for id in ids})
        self._reward = config.reward or ("return" if len(families) == 1 else "success")
        self._left_out = {self._reward, *(_OF_UNITS if len(families) > 1 else ())}
        if self._reward not in SCORES:
            raise ValueError(f"reward must be one of {', '.join(SCORES)}, got {config.reward!r}")
        if len(families) > 1 and self._reward in _OF_UNITS:
            raise ValueError(
                f"reward must be success for environments of several families ({', '.join(families)}), got "
                f"{config.reward!r}, which has a unit of its own in each; give env_ids of one family, or another reward"
            )

    async def run(self, task: LLFTask, agents: vf.Agents) -> None:
        """Play it."""
        config = self.config
        dialogue = Dialogue(
            task.data.env_id,
            task.data.seed,
            teacher=config.personality,
            **config.model_dump(include=_SETTINGS),
        )
        try:
            if config.model_teaches:
                prompt = _TEACHING.format(instruction=dialogue.talk.instruction)
                async with agents.teacher.interaction(_seated(task, prompt)) as teacher:
                    student = await _play(dialogue, task, agents, teacher)
                traces = [student, teacher.trace]
            else:
                traces = [await _play(dialogue, task, agents, None)]
        finally:
            dialogue.close()
        scores = dialogue.scores()
        for trace in traces:  # a teacher's reward is its student's
            trace.record_reward(self._reward, scores[self._reward])
            trace.record_metrics({name: value for name, value in scores.items() if name not in self._left_out})
            unit = dialogue.env.family.regret_unit
            trace.info["llf_teacher"] = {"regret_unit": unit, "scores": scores, "turns": dialogue.record()}


async def _play(dialogue: Dialogue, task: LLFTask, agents: vf.Agents, teacher: vf.Interaction | None) -> vf.Trace:
    """Play the episode; it ends early when verifiers' limits end the conversation of an agent."""
    system, question = dialogue.messages
    async with agents.student.interaction(_seated(task, system["content"])) as student:
        said = await student.turn(question["content"])
        while not said.terminated:
            dialogue.answer(said.last_reply)
            lesson = teacher and await teacher.turn(_TURN.format_map(dialogue.teacher_prompt()))
            dialogue.speak(lesson and lesson.last_reply)
            if dialogue.over or (lesson and lesson.terminated):
                break
            said = await student.turn(dialogue.messages[-1]["content"])
    return student.trace


def _seated(task: LLFTask, system_prompt: str) -> LLFTask:
    """The task with the system prompt of a seat."""
    seated: LLFTask = task.with_data(system_prompt=system_prompt)
    return seated
