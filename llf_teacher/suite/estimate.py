"""What taking the suite costs a student at most, before it is asked: turns, and tokens and USD of a model."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from llf_teacher.gym import make
from llf_teacher.students.answers import written
from llf_teacher.students.builtin.llm import LLM
from llf_teacher.students.conversation import Conversation, text_of
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.trait import traits_of
from llf_teacher.studies.definition.custom_specs import arguments_of, parse_teacher
from llf_teacher.suite.experiment import TURNS
from llf_teacher.suite.play import QUICK_TURNS, chosen, seeds_of, studies_of

BYTES = 4
"""Bytes of a token of English, about."""


@dataclass(frozen=True, kw_only=True)
class CostEstimate:
    """The most that a student plays, and what that costs if its model is asked in each turn."""

    episodes: int
    turns: int
    """At most; an episode that is solved ends."""
    input_tokens: int | None
    """About; None for a student that asks no model."""
    output_tokens: int | None
    """At most; None if the model has no `max_tokens`, too."""
    usd: float | None
    """The price of these tokens; None if it is not known."""

    def __str__(self) -> str:
        text = f"at most {self.episodes} episodes, {self.turns} turns"
        if self.input_tokens is None:
            return text
        out = "unknown" if self.output_tokens is None else f"at most {self.output_tokens}"
        price = "price unknown" if self.usd is None else f"at most about {self.usd:.2f} USD"
        return f"{text}, about {self.input_tokens} tokens in, {out} out, {price}"


def estimate(student: str, names: Sequence[str] = (), quick: bool = False, key: str = "") -> CostEstimate:
    """The estimate for a student's spec, without what a store may have already.

    Of a model, one lesson of each teacher in each environment is played by chance, and the prompts are measured.
    """
    whole, seeds, longest = parse_student(student), seeds_of(key, quick), QUICK_TURNS if quick else TURNS
    bare, _ = traits_of(whole)
    lessons = [
        (id, teacher, dict(study.options.get(id, {})))
        for study in studies_of([student], chosen(names, quick), seeds, longest)
        if whole.remembers or not study.transfer
        for id in study.ids
        for teacher in (study.tests(id).teachers or study.grid(id).teachers)
        for _ in range(1 + sum(study.transfer.get("lessons", ())))
    ]  # a test has about the turns of a lesson
    episodes = len(lessons) * len(seeds)
    turns = episodes * longest
    if not isinstance(bare, LLM):
        return CostEstimate(episodes=episodes, turns=turns, input_tokens=None, output_tokens=None, usd=None)
    read = [_bytes(*lesson, longest, seeds[0], bare) for lesson in lessons]
    tokens = len(seeds) * sum(read) // BYTES
    out = None if bare.max_tokens is None else turns * bare.max_tokens
    prices = bare.settings.prices
    usd = None if prices is None or out is None else (tokens * prices.input + out * prices.output) / 1e6
    return CostEstimate(episodes=episodes, turns=turns, input_tokens=tokens, output_tokens=out, usd=usd)


def _bytes(id: str, teacher: str, options: Any, turns: int, seed: int, student: LLM) -> int:
    """The bytes of all prompts of a lesson."""
    env = make(id, **arguments_of(parse_teacher(teacher), "a"), text=True, max_turns=turns, **options)
    talk = Conversation(
        env,
        history=student.history,
        max_prompt_tokens=student.max_prompt_tokens,
        answer=student.answer,
        prompts=student.folder,
    )
    rng, world = np.random.default_rng(seed), env.session.world.scratch()
    observation, _ = env.reset(seed=seed)
    total = 0
    for _ in range(turns):
        total += sum(len(text_of(message).encode()) for message in talk.ask(observation))
        observation, _, terminated, truncated, _ = env.step(talk.answer(written(world, rng)))
        if terminated or truncated:
            break
    env.close()
    return total
