"""What teachers said, over all families and students."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

from llf_teacher.students.student import TAUGHT
from llf_teacher.studies.definition.design import main_types
from llf_teacher.studies.report.columns import CHECKED, Sums
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.parts.part import Part
from llf_teacher.studies.report.section import added, reads, share
from teachers.atoms import KINDS, Label


class Account(NamedTuple):
    """Counts of what a teacher said, over all episodes under one instruction type and feedback type."""

    teacher: str
    per_turn: dict[str, float]
    """Claims per turn of the student, by kind, those of the opening included."""
    labels: dict[str, float]
    """Share of the claims by label; empty without claims."""
    unchecked: float | None
    """Share of the sentences of feedback without a claim; None if nothing was said."""
    changes: int
    """Sentences in which a rewriting voice changed numbers or names."""
    uptake: float | None
    """Share of the turns after advice in which a student that teachers can reach took an advised action; None without
    advice.
    """
    words: float
    """Words of feedback per turn of the student."""
    parse_failures: int
    """Number of answers that were no action."""
    turns: int


def accounts(data: Data, instruction_type: str, feedback_type: str) -> Iterator[Account]:
    """The account of each teacher; teachers without an episode are left out."""
    for teacher in data.study.teachers:
        mine = {
            setting: each
            for setting, each in data.sums.items()
            if (setting.teacher, setting.instruction_type, setting.feedback_type, setting.lessons)
            == (teacher, instruction_type, feedback_type, 0)
        }
        if mine:
            reached = [each for setting, each in mine.items() if reads(setting.student) in TAUGHT]
            yield _account(teacher, list(mine.values()), share(reached, "followed", "advised"))


def _account(teacher: str, mine: Sequence[Sums], uptake: float | None) -> Account:
    turns = added(mine, "turns")
    claims = sum(added(mine, label) for label in CHECKED)
    return Account(
        teacher=teacher,
        per_turn={kind: added(mine, f"said_{kind}") / turns for kind in KINDS},
        labels={label: added(mine, label) / claims for label in CHECKED} if claims else {},
        unchecked=added(mine, "unchecked") / sentences if (sentences := claims + added(mine, "unchecked")) else None,
        changes=int(added(mine, "changes")),
        uptake=uptake,
        words=added(mine, "words") / turns,
        parse_failures=int(added(mine, "parse_failures")),
        turns=int(turns),
    )


def _values(data: Data) -> Mapping[str, Any]:
    types = product(data.study.instruction_types, main_types(data.study.feedback_types))
    found = {pair: list(accounts(data, *pair)) for pair in types}
    return {
        "accounts": {pair: rows for pair, rows in found.items() if rows},
        "kinds": KINDS,
        "labels": [
            label
            for label in CHECKED
            if label is not Label.HEDGED or any(row.labels.get(label) for rows in found.values() for row in rows)
        ],
    }


PART = Part("accounting", _values, "What was said")
