"""What taking the suite costs at most, before it begins: turns of a student or teacher, tokens and USD of a model."""

from collections.abc import Sequence
from dataclasses import dataclass

from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.speakers.llm_teacher import LLMTeacher
from llf_teacher.students.builtin.llm import LLM
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.trait import traits_of
from llf_teacher.studies.definition.custom_specs import parse_teacher, student_spec, teacher_spec
from llf_teacher.studies.execution.prompts import bytes_of_prompts
from llf_teacher.suite.experiment import TURNS
from llf_teacher.suite.mirror import all_qualities
from llf_teacher.suite.mirror import play as mirror
from llf_teacher.suite.play import QUICK_TURNS, chosen, named, seeds_of, studies_of

BYTES = 4
"""Bytes of a token of English, about."""


@dataclass(frozen=True, kw_only=True)
class CostEstimate:
    """The most that a student or a teacher plays, and what that costs if its model is asked in each turn."""

    episodes: int
    turns: int
    """At most; an episode that is solved ends."""
    input_tokens: int | None = None
    """About; None without an `llm` or an `llm_teacher`."""
    output_tokens: int | None = None
    """At most; None if the model has no `max_tokens`, too."""
    usd: float | None = None
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
    student = student_spec(student)
    studies = studies_of([student], chosen(names, quick), seeds_of(key, quick), QUICK_TURNS if quick else TURNS)
    played = [each for study in studies for each in study.episodes() if each.student == student]
    bare, _ = traits_of(parse_student(student))
    return _estimate([lesson for each in played for lesson in (each,) * (1 + each.lessons)], bare)


def estimate_teacher(teacher: str, names: Sequence[str] = (), quick: bool = False, key: str = "") -> CostEstimate:
    """The same for a teacher's spec and the names of qualities.

    Of a model, one lesson in each environment is measured for each student, in which both answer by chance.
    """
    teacher, asked = teacher_spec(teacher), named("quality", names, all_qualities()).values()
    studies = mirror.studies_of(teacher, asked, mirror.seeds_for(quick, key))
    played = [each for study in studies for each in study.episodes() if each.teacher == teacher]
    return _estimate(played, parse_teacher(teacher))


def _estimate(lessons: Sequence[EpisodeSpec], subject: object) -> CostEstimate:
    """The estimate for lessons, of which those with the first seed are measured."""
    turns = sum(each.max_turns for each in lessons)
    if not isinstance(subject, LLM | LLMTeacher) or not lessons:
        return CostEstimate(episodes=len(lessons), turns=turns)
    measured = [each for each in lessons if each.seed == lessons[0].seed]
    tokens = sum(bytes_of_prompts(each, subject) for each in measured) * len(lessons) // len(measured) // BYTES
    out = None if subject.max_tokens is None else turns * subject.max_tokens
    prices = subject.settings.prices
    usd = None if prices is None or out is None else (tokens * prices.input + out * prices.output) / 1e6
    return CostEstimate(episodes=len(lessons), turns=turns, input_tokens=tokens, output_tokens=out, usd=usd)
