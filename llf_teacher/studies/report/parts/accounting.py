"""What teachers said in each family, over all students."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

from llf_teacher.episodes.record import READINGS
from llf_teacher.registry import entry
from llf_teacher.students.student import TAUGHT
from llf_teacher.studies.definition.design import main_types
from llf_teacher.studies.report.columns import CHECKED, Sums, columns
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.parts.part import Part
from llf_teacher.studies.report.section import added, reads, share
from llf_teacher.theme.turns import claim_code
from teachers.atoms import KINDS, Label


class OwnWords(NamedTuple):
    """The readings of a teacher's sentences in its own words."""

    sentences: int
    """Number of all sentences."""
    read: float
    """Share of the sentences that were read and whose claim was checked."""
    exact: int
    """Number of sentences that are word for word a phrase."""
    false: int
    """Number of these that are false."""
    model: int
    """Number of sentences read by a model."""
    model_false: int
    """Number of these that are false."""


class ModelAnswers(NamedTuple):
    """The answers of a model in the teacher's seat."""

    answers: int
    cut: int
    """Number of answers that were cut at the greatest length."""
    empty: int
    """Number of answers that say nothing."""
    repeats: int
    """Number of answers that repeat what the student sees."""
    unbuilt: int
    """Number of claims that could not be made."""
    withheld: int
    """Number of false claims that a filter kept back."""
    seconds: float
    """Time of an answer."""


class FalseSentence(NamedTuple):
    """A false sentence, as read."""

    id: str
    seed: int
    turn: int
    text: str
    code: str
    """Its claim."""


class Account(NamedTuple):
    """Counts of a teacher's claims and words, over all episodes of a family under one instruction and feedback type."""

    family: str
    teacher: str
    per_turn: dict[str, float]
    """Claims per turn of the student, by kind, also at the opening."""
    labels: dict[str, float]
    """Share of the claims by label; empty without claims."""
    unchecked: float | None
    """Sentences of feedback without a claim, as a share of these and the claims; None if nothing was said."""
    changes: int
    """Sentences in which a rewriting voice changed numbers or names."""
    uptake: float | None
    """Share of the turns after advice with an advised action, for students that teachers can reach; None without
    advice.
    """
    words: float
    """Words of feedback per turn of the student."""
    parse_failures: int
    """Number of answers that were not actions."""
    turns: int
    own: OwnWords | None
    """None if it said nothing in its own words, or nothing was read."""
    model: ModelAnswers | None
    """None if it is no model."""


def accounts(data: Data, instruction_type: str, feedback_type: str) -> Iterator[Account]:
    """The account of each teacher in each family; teachers without an episode there are left out."""
    for family, teacher in product(data.units, data.study.teachers):
        mine = {
            setting: each
            for setting, each in data.sums.items()
            if (setting.teacher, setting.instruction_type, setting.feedback_type, setting.lessons)
            == (teacher, instruction_type, feedback_type, 0)
            and entry(setting.id).family.name == family
        }
        if mine:
            reached = [each for setting, each in mine.items() if reads(setting.student) in TAUGHT]
            yield _account(family, teacher, list(mine.values()), share(reached, "followed", "advised"))


def _account(family: str, teacher: str, mine: Sequence[Sums], uptake: float | None) -> Account:
    turns = added(mine, "turns")
    claims = sum(added(mine, label) for label in CHECKED)
    return Account(
        family=family,
        teacher=teacher,
        per_turn={kind: added(mine, f"said_{kind}") / turns for kind in KINDS},
        labels={label: added(mine, label) / claims for label in CHECKED} if claims else {},
        unchecked=added(mine, "unchecked") / sentences if (sentences := claims + added(mine, "unchecked")) else None,
        changes=int(added(mine, "changes")),
        uptake=uptake,
        words=added(mine, "words") / turns,
        parse_failures=int(added(mine, "parse_failures")),
        turns=int(turns),
        own=_own_words({name: int(added(mine, name)) for name in READINGS}),
        model=_model_answers(mine),
    )


def _model_answers(mine: Sequence[Sums]) -> ModelAnswers | None:
    """The answers of a model in the teacher's seat; None without one."""
    answers = int(added(mine, "teacher_answers"))
    if not answers:
        return None
    names = ("teacher_cut", "teacher_empty", "teacher_repeats", "unbuilt", "withheld")
    cut, empty, repeats, unbuilt, withheld = (int(added(mine, name)) for name in names)
    seconds = added(mine, "teacher_seconds") / answers
    return ModelAnswers(answers, cut, empty, repeats, unbuilt, withheld, seconds)


def _own_words(sums: Mapping[str, int]) -> OwnWords | None:
    """What was read, by the sums of `READINGS`; None if there was nothing to read."""
    read = sums["read_exact"] + sums["read_model"]
    if not (sentences := read + sums["unread"]):
        return None
    counts = (sums[name] for name in ("read_exact", "read_false", "read_model", "model_false"))
    return OwnWords(sentences, read / sentences, *counts)


def _examples(data: Data) -> dict[tuple[str, str, str, str], FalseSentence]:
    """By family, teacher, instruction type and feedback type the first false sentence."""
    examples: dict[tuple[str, str, str, str], FalseSentence] = {}
    with columns(data.store, data.planned) as there:
        for setting, seed, key in there.read_false():
            family = entry(setting.id).family.name
            place = family, setting.teacher, setting.instruction_type, setting.feedback_type
            if setting.lessons or place in examples:
                continue
            turn, each = next(
                (row["turn"], each)
                for row in data.store.turns(key)
                for each in row["readings"] or ()
                if each["holds"] is False
            )
            code = claim_code(each, family)
            examples[place] = FalseSentence(setting.id, seed, turn, each["text"], code)
    return examples


def _values(data: Data) -> Mapping[str, Any]:
    types = product(data.study.instruction_types, main_types(data.study.feedback_types))
    found = {pair: list(accounts(data, *pair)) for pair in types}
    return {
        "examples": _examples(data),
        "accounts": {pair: rows for pair, rows in found.items() if rows},
        "kinds": KINDS,
        "labels": [
            label
            for label in CHECKED
            if label is not Label.HEDGED or any(row.labels.get(label) for rows in found.values() for row in rows)
        ],
    }


PART = Part("accounting", _values, "What was said")
