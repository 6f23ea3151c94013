"""The lengths of a lesson's prompts and answers, measured with random play; no model is asked."""

import json
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.gym import make
from llf_teacher.models.model import Model
from llf_teacher.models.replies import Answer
from llf_teacher.speakers.parsing import arguments_of, parse_teacher
from llf_teacher.students.builtin.llm import LLM
from llf_teacher.students.conversation import text_of
from pz_envs.text.answer_formats import written

__all__ = ["PromptSizes", "sizes_of_prompts"]

_REPLY = "That was not the best that you could do here. Try another way, and look at what the state tells you."


class _Counter(Model):
    """Counts the bytes of requests without sending them."""

    def __init__(self) -> None:
        self.bytes = 0

    def answer(
        self, messages: list[dict[str, Any]], form: Mapping[str, Any] | None = None, needed: int | None = None
    ) -> Answer:
        self.bytes += len("".join(map(text_of, messages)).encode()) + len(json.dumps(form) if form else "")
        return Answer(_REPLY)


class PromptSizes(NamedTuple):
    """The lengths of a lesson's prompts and answers."""

    bytes: int
    """Bytes of all prompts."""
    longest_answer: int | None
    """Greatest number of tokens of an answer; None: no limit."""


def sizes_of_prompts(lesson: EpisodeSpec, student: LLM) -> PromptSizes:
    """The lengths of a model's prompts and answers in a lesson with random play."""
    counter = _Counter()
    taught = arguments_of(parse_teacher(lesson.teacher), "a")
    env = make(lesson.id, **taught, text=True, max_turns=lesson.max_turns, **json.loads(lesson.options or "{}"))
    rng, world = np.random.default_rng(lesson.seed), env.session.world.scratch()
    talk = student.conversation(env, rng)
    observation, _ = env.reset(seed=lesson.seed)
    over = False
    while not over:
        text = written(world, rng)
        counter.answer(talk.ask(observation))
        observation, _, terminated, truncated, _ = env.step(talk.answer(text))
        over = terminated or truncated
    env.close()
    return PromptSizes(counter.bytes, student.settings.limit(talk.most_tokens))
