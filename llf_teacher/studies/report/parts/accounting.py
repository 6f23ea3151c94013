"""What teachers said, over all families and students."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from types import MappingProxyType
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

Readings = Mapping[tuple[str, str, str], Mapping[int, Sequence[tuple[str, bool]]]]
"""By teacher, instruction type and feedback type, then by seed: what was read without a model, and whether it is
false.
"""


class OwnWords(NamedTuple):
    """What was read of a teacher's sentences in its own words."""

    sentences: int
    """Number of all of them."""
    read: float
    """Share of those that were read and whose claim was checked."""
    alone: int
    """Number of those that were read without a model."""
    false: float
    """Share of these that are false."""
    bounds: tuple[float, float]
    """Its interval, which contains the reader's own error, by `share_false`; that does not hold for a model's."""
    model: int
    """Number of those that a model read."""
    model_false: int
    """Number of these that are false."""


class FalseSentence(NamedTuple):
    """A sentence that was read and is false."""

    id: str
    seed: int
    turn: int
    text: str
    code: str
    """Its claim."""


class Account(NamedTuple):
    """Counts of what a teacher said, over all episodes under one instruction type and feedback type."""

    teacher: str
    per_turn: dict[str, float]
    """Claims per turn of the student, by kind, those of the opening included."""
    labels: dict[str, float]
    """Share of the claims by label; empty without claims."""
    unchecked: float | None
    """Sentences of feedback without a claim, as a share of these and the claims; None if nothing was said."""
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
    own: OwnWords | None
    """None if nothing was said, or read, in its own words."""


def accounts(
    data: Data, instruction_type: str, feedback_type: str, readings: Readings = MappingProxyType({})
) -> Iterator[Account]:
    """The account of each teacher, with what was read of it; teachers without an episode are left out."""
    for teacher in data.study.teachers:
        mine = {
            setting: each
            for setting, each in data.sums.items()
            if (setting.teacher, setting.instruction_type, setting.feedback_type, setting.lessons)
            == (teacher, instruction_type, feedback_type, 0)
        }
        if mine:
            reached = [each for setting, each in mine.items() if reads(setting.student) in TAUGHT]
            read = readings.get((teacher, instruction_type, feedback_type), {})
            yield _account(teacher, list(mine.values()), share(reached, "followed", "advised"), read)


def _account(
    teacher: str, mine: Sequence[Sums], uptake: float | None, read: Mapping[int, Sequence[tuple[str, bool]]]
) -> Account:
    from pz_envs.checking import share_false

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
        own=own_words({name: int(added(mine, name)) for name in READINGS}, share_false(read.values())),
    )


def own_words(sums: Mapping[str, int], bounds: tuple[float, float]) -> OwnWords | None:
    """What was read, by the sums of `READINGS` and the bounds of `share_false`; None if there was nothing to read."""
    alone = sums["read_exact"] + sums["read_near"]
    read = alone + sums["read_model"]
    if not (sentences := read + sums["unread"]):
        return None
    false = sums["read_false"] / alone if alone else 0.0
    model = sums["read_model"], sums["model_false"]
    return OwnWords(sentences, read / sentences, alone, false, bounds, *model)


def _readings(data: Data) -> tuple[Readings, dict[tuple[str, str, str], FalseSentence]]:
    """By teacher, instruction type and feedback type what was read without a model, and the first false sentence."""
    from pz_envs.checking import ALONE

    found: dict[tuple[str, str, str], dict[int, list[tuple[str, bool]]]] = defaultdict(lambda: defaultdict(list))
    examples: dict[tuple[str, str, str], FalseSentence] = {}
    with columns(data.store, data.planned) as there:
        for setting, seed, key in there.read():
            if setting.lessons:
                continue
            place = setting.teacher, setting.instruction_type, setting.feedback_type
            for turn, each in ((row, each) for row in data.store.turns(key) for each in row["readings"] or ()):
                if each["layer"] in ALONE:
                    found[place][seed].append((each["text"], each["holds"] is False))
                if each["holds"] is False and place not in examples:
                    code = claim_code(each, entry(setting.id).family.name)
                    examples[place] = FalseSentence(setting.id, seed, turn["turn"], each["text"], code)
    return found, examples


def _values(data: Data) -> Mapping[str, Any]:
    types = product(data.study.instruction_types, main_types(data.study.feedback_types))
    readings, examples = _readings(data)
    found = {pair: list(accounts(data, *pair, readings)) for pair in types}
    return {
        "examples": examples,
        "accounts": {pair: rows for pair, rows in found.items() if rows},
        "kinds": KINDS,
        "labels": [
            label
            for label in CHECKED
            if label is not Label.HEDGED or any(row.labels.get(label) for rows in found.values() for row in rows)
        ],
    }


PART = Part("accounting", _values, "What was said")
