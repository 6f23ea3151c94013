"""The greatest cost of the suite, before it begins: turns of the student, tokens and USD of a model."""

from collections.abc import Sequence
from dataclasses import dataclass

from llf_teacher.students.builtin.llm import LLM
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.trait import traits_of
from llf_teacher.studies.definition.custom_specs import student_spec
from llf_teacher.studies.execution.prompts import sizes_of_prompts
from llf_teacher.suite.experiment import TURNS
from llf_teacher.suite.taking import QUICK_TURNS, chosen, seeds_of, studies_of

BYTES = 4
"""Approximate number of bytes of an English token."""


@dataclass(frozen=True, kw_only=True)
class CostEstimate:
    """The greatest number of turns, and their cost if a model is asked in each."""

    episodes: int
    turns: int
    """Greatest number of turns; solved episodes end earlier."""
    input_tokens: int | None = None
    """About; None without an `llm`."""
    output_tokens: int | None = None
    """Upper bound; None also if the model has no `max_tokens`."""
    usd: float | None = None
    """The price of these tokens; None if unknown."""

    def __str__(self) -> str:
        text = f"at most {self.episodes} episodes, {self.turns} turns"
        if self.input_tokens is None:
            return text
        out = "unknown" if self.output_tokens is None else f"at most {self.output_tokens}"
        price = "price unknown" if self.usd is None else f"at most about {self.usd:.2f} USD" if self.usd else "free"
        return f"{text}, about {self.input_tokens} tokens in, {out} out, {price}"


def estimate(student: str, names: Sequence[str] = (), quick: bool = False, key: str = "") -> CostEstimate:
    """The estimate for a student's spec, as if the store were empty.

    For a model, it plays one lesson of each teacher in each environment at random, and measures the prompts.
    """
    student = student_spec(student)
    studies = studies_of([student], chosen(names, quick), seeds_of(key, quick), QUICK_TURNS if quick else TURNS)
    played = [each for study in studies for each in study.episodes() if each.student == student]
    lessons = [lesson for each in played for lesson in (each,) * (1 + each.lessons)]
    bare, _ = traits_of(parse_student(student))
    turns = sum(each.max_turns for each in lessons)
    if not isinstance(bare, LLM) or not lessons:
        return CostEstimate(episodes=len(lessons), turns=turns)
    measured = [each for each in lessons if each.seed == lessons[0].seed]
    sizes = [(each.max_turns, sizes_of_prompts(each, bare)) for each in measured]
    tokens = sum(size.bytes for _, size in sizes) * len(lessons) // len(measured) // BYTES
    answers = [turns * size.longest_answer for turns, size in sizes if size.longest_answer is not None]
    out = sum(answers) * len(lessons) // len(measured) if len(answers) == len(sizes) else None
    prices = bare.settings.prices
    usd = None if prices is None or out is None else (tokens * prices.input + out * prices.output) / 1e6
    return CostEstimate(episodes=len(lessons), turns=turns, input_tokens=tokens, output_tokens=out, usd=usd)
