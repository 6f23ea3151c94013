"""What a student did in the lessons of an experiment: how it answered, and a lesson to read."""

import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from llf_teacher.escaping import escape_control_chars
from llf_teacher.gym import make
from llf_teacher.models.replies import LENGTH
from llf_teacher.students.builtin.llm import LLM
from llf_teacher.students.conversation import text_of
from llf_teacher.studies.results import Results
from llf_teacher.suite.experiment import Experiment

COPIED = 6
"""Number of words in a row that an answer has from its prompt if it is a copy."""
MANY = 0.1
"""Share of answers from which on a fault is said to decide what the student lost."""
LESSONS = ("better", "worse", "silent")
"""The kinds of lessons, in the order of `Experiment.arms`."""
_SHOWN = 300  # characters of what was asked and answered
_WORD = re.compile(r"\w+")


@dataclass(frozen=True, kw_only=True)
class LessonAnswers:
    """How many answers failed in the lessons of one teacher."""

    turns: int = 0
    no_action: int = 0
    """Number of answers that were no action."""

    @property
    def share(self) -> float:
        """The share of answers that were no action."""
        return self.no_action / max(1, self.turns)


@dataclass(frozen=True, kw_only=True)
class AnswerSummary:
    """What a student did in the lessons of an experiment, over all its teachers."""

    turns: int = 0
    no_action: int = 0
    """Number of answers that were no action."""
    cut: int = 0
    """Number of answers that were cut at their greatest length."""
    copied: int = 0
    """Number of answers with `COPIED` words in a row from the prompt's own form, without the lesson's words."""
    advised: int = 0
    """With the better teacher, the number of turns after advice of an action."""
    followed: int = 0
    """Number of these turns with an advised action."""
    asked: str = ""
    """The end of what the student was sent in a turn: of the instruction, and the teacher's words."""
    answered: str = ""
    """What it answered."""
    taken: str = ""
    """The action that was read; empty if none was."""
    episode: str = ""
    """The key of a lesson in the store, the one of that turn."""
    transcript: str = ""
    """That lesson, turn by turn."""
    lessons: Mapping[str, LessonAnswers] = field(default_factory=dict)
    """By kind of lesson, `better`, `worse` and `silent`, the answers in the environments and turns that count."""

    @property
    def faults(self) -> list[str]:
        """How many answers failed, by kind, in words; empty if none did."""
        counts = {"no action": self.no_action, "cut at the greatest length": self.cut}
        words = [f"{number} {'was' if number == 1 else 'were'} {what}" for what, number in counts.items() if number]
        return words + [f"{self.copied} copied the prompt"] * bool(self.copied)

    @property
    def failed(self) -> bool:
        """Whether so many answers failed that losses say little about feedback."""
        return max(self.no_action, self.cut, self.copied) > MANY * self.turns

    @property
    def words(self) -> str:
        """The answers, in a sentence."""
        if not self.turns:
            return "There were no answers."
        said = f"Of its {self.turns} answers {', '.join(self.faults)}."
        advice = f" It did what was advised in {self.followed} of {self.advised} turns." if self.advised else ""
        return (said if self.faults else f"All of its {self.turns} answers were actions.") + advice

    @property
    def sample(self) -> str:
        """What was asked and answered in a turn, in a sentence; empty without one."""
        if not self.answered:
            return ""
        taken = f"taken as {self.taken!r}" if self.taken else "which is no action here"
        return f"It was sent {self.asked!r} and answered {self.answered!r}, {taken}."


def answers_of(
    experiment: Experiment,
    student: str,
    rows: Iterable[Mapping[str, Any]],
    seeds: Sequence[int],
    results: Results,
    form: Callable[[str], str],
    places: Collection[str] = (),
) -> AnswerSummary:
    """What a student did in the lessons of an experiment.

    Args:
        experiment: the experiment.
        student: its spec.
        rows: episodes.
        seeds: the seeds of the experiment.
        results: of the store with the turns of these episodes.
        form: gives the text of the prompt's own form in an environment, by id; empty without one.
        places: the environments that count in the score; empty: all.
    """
    better, worse, _ = experiment.arms
    own = rows_of(experiment, student, rows, seeds)
    if not own:
        return AnswerSummary()
    taught = [row for row in own if row["teacher"] == better]
    return AnswerSummary(
        turns=sum(row["turns"] for row in own),
        no_action=sum(row["parse_failures"] for row in own),
        cut=sum(row["truncated"] or 0 for row in own),
        copied=sum(copies(each, form(row["id"])) for row in own for each in _answers(row, results)),
        advised=sum(row["advised"] for row in taught),
        followed=sum(row["followed"] for row in taught),
        lessons={
            kind: _lesson_answers(
                [row for row in own if row["teacher"] == teacher and row["id"] in (places or experiment.ids)],
                experiment.since,
                results,
            )
            for kind, teacher in zip(LESSONS, experiment.arms, strict=True)
        },
        **_lesson(own, worse if experiment.margin is not None else better, results),
    )


def _lesson_answers(rows: Sequence[Mapping[str, Any]], since: int, results: Results) -> LessonAnswers:
    """The answers in episodes, without the opening and the first turns, whose regret does not count."""
    failing = (row["key"] for row in rows if row["parse_failures"])
    return LessonAnswers(
        turns=sum(max(0, row["turns"] - since) for row in rows),
        no_action=sum(turn["parse_failure"] is not None for key in failing for turn in results.turns(key)[1 + since :]),
    )


def rows_of(
    experiment: Experiment, student: str, rows: Iterable[Mapping[str, Any]], seeds: Sequence[int]
) -> list[Mapping[str, Any]]:
    """The rows of a student's episodes in the lessons that an experiment compares; arguments as in `answers_of`."""
    asked = {*seeds[: experiment.seeds]}
    return [
        row
        for row in rows
        if (row["student"], row["worlds"]) == (student, experiment.lessons)
        and row["id"] in experiment.ids
        and row["teacher"] in experiment.arms
        and row["seed"] in asked
    ]


def first_prompt(id: str, student: LLM, **options: Any) -> str:
    """The text that a model gets in an environment before any feedback: the prompt's form, and the instruction."""
    env = make(id, teacher="silent", text=True, **options)
    talk = student.conversation(env, np.random.default_rng(0))
    observation, _ = env.reset(seed=0)
    text = "\n".join(map(text_of, talk.ask(observation)))
    env.close()
    return text


def copies(answer: str, form: str) -> bool:
    """Whether an answer has `COPIED` words in a row from a prompt's form."""
    said, there = (_WORD.findall(text.lower()) for text in (answer, form))
    runs = {tuple(there[i : i + COPIED]) for i in range(len(there) - COPIED + 1)}
    return any(tuple(said[i : i + COPIED]) in runs for i in range(len(said) - COPIED + 1))


def _answers(row: Mapping[str, Any], results: Results) -> list[str]:
    """The answers of a model in an episode."""
    if not row["answers"]:
        return []
    return [turn["answer"] for turn in results.turns(row["key"]) if turn["answer"] and turn["finish"] != LENGTH]


def _lesson(rows: Sequence[Mapping[str, Any]], teacher: str, results: Results) -> dict[str, str]:
    """The lesson to read: the one with most answers that are no action, else the first with this teacher."""
    row = max(rows, key=lambda row: (row["parse_failures"], row["teacher"] == teacher))
    turns = results.turns(row["key"])
    i = next((i for i, turn in enumerate(turns) if turn["parse_failure"] is not None), min(1, len(turns) - 1))
    turn, before = turns[i], turns[i - 1]
    asked = " ".join(filter(None, (turns[0]["instruction"], before["observation"], before["feedback"])))
    said = turn["answer"] or turn["parse_failure"] or _action(turn)
    return {
        "asked": escape_control_chars(f"... {asked[-_SHOWN:]}" if len(asked) > _SHOWN else asked),
        "answered": escape_control_chars(said[:_SHOWN]),
        "taken": escape_control_chars(_action(turn)[:_SHOWN]),
        "episode": row["key"],
        "transcript": escape_control_chars(results.transcript(row["key"])),
    }


def _action(turn: Mapping[str, Any]) -> str:
    """The action of a turn in words; empty without one."""
    return f"{turn['action_words'] or ('' if turn['action'] is None else turn['action'])}"
