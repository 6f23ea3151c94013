"""Declarations of a study beside its lists: a baseline, an ablation, interim analyses, lessons before a test."""

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from llf_teacher.registry import entry, supported_types
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies.definition.custom_specs import student_spec, teacher_spec
from teachers.atoms import KINDS
from teachers.feedback import NONE, format_kinds
from teachers.spec import is_count, unknown

BASELINE = "silent"
"""The default teacher for comparisons."""
SUBSETS = tuple(
    format_kinds(chosen) for size in range(len(KINDS) + 1) for chosen in itertools.combinations(KINDS, size)
)
"""Every subset of the kinds as a feedback type, the smaller ones first."""


def main_types(feedback_types: Sequence[str]) -> tuple[str, ...]:
    """The feedback types with their own sections: all types, but of an ablation's subsets only that of all kinds."""
    ablated = SUBSETS[:-1] if set(SUBSETS) <= {*feedback_types} else ()
    return tuple(each for each in feedback_types if each not in ablated)


SPENDING = ("obrien_fleming", "pocock")
"""Alpha-spending functions of a sequential design; see `llf_teacher.studies.analysis.sequential`."""
TESTER, TEST_TYPE = "silent", NONE
"""Teacher and feedback type of a test."""
MOST_LESSONS = 1_000_000
SAME, NEXT = "same", "next"
WORLDS = (SAME, NEXT)
"""Worlds of the lessons: the seed's world from the same start each time, which is the world of the test if the
environments are the same; or the worlds of later seeds, a different one for each lesson.
"""


class Transfer(NamedTuple):
    """Lessons before a test: the table `transfer` of a study."""

    lessons: tuple[int, ...]
    """Numbers of episodes before the test, each at least 1."""
    students: tuple[str, ...]
    """The taught and tested students; by default the study's students that remember."""
    teachers: tuple[str, ...]
    """The teachers of the lessons; by default the study's."""
    feedback_types: tuple[str, ...]
    """The feedback types of the lessons; by default the study's."""
    taught: tuple[str, ...] = ()
    """Ids of the environments of the lessons, each for tests in its own family; empty: the environment of the test."""
    worlds: tuple[str, ...] = (SAME,)
    """Some of `WORLDS`."""


def check_transfer(table: Any, study: Any, problems: list[str]) -> dict[str, Any]:
    """The table in canonical form.

    Args:
        table: as in the study's file; empty: no tests.
        study: the study, with its other fields in canonical form.
        problems: the list to which problems are added.
    """
    if not table:
        return {}
    if not isinstance(table, Mapping) or "lessons" not in table:
        problems.append(f"transfer must be a table with `lessons`, as in {{lessons = [5, 20]}}, got {table!r}")
        return {}
    wrong = [f"transfer: {unknown('key', name, Transfer._fields)}" for name in table if name not in Transfer._fields]
    lists = {name: _list(name, value, wrong) for name, value in table.items()}
    if not all(is_count(each, MOST_LESSONS) for each in lists["lessons"]):
        wrong.append(f"transfer: lessons must be integers from 1 to {MOST_LESSONS}, got {table['lessons']!r}")
    wrong += [f"transfer: {unknown('worlds', each, WORLDS)}" for each in lists.get("worlds", ()) if each not in WORLDS]
    checks: dict[str, Callable[[Any], str]] = {
        "taught": lambda id: entry(id).id,
        "students": student_spec,
        "teachers": teacher_spec,
        "feedback_types": format_kinds,
    }
    for name, check in checks.items():
        for i, value in enumerate(lists.get(name, ())):
            try:
                lists[name][i] = check(value)
            except ValueError as error:
                wrong.append(f"transfer: {name}: {error}")
    problems += wrong
    if wrong:
        return {}
    remember = [student for student in study.students if parse_student(student).remembers]
    students, teachers = lists.get("students", remember), lists.get("teachers", study.teachers)
    forget = [student for student in students if not parse_student(student).remembers]
    if forget or not students:
        problems.append(
            f"transfer: students must remember earlier episodes, got {', '.join(forget) or 'none that does'}; allowed: "
            "obedient, text_only and learners with forget=False, and agents of your own"
        )
    taught = lists.get("taught", [])
    families = {entry(id).family.name for id in study.ids}
    if unknown_names := [id for id in taught if entry(id).family.name not in families]:
        problems.append(f"transfer: taught: the study has no id of the family of {', '.join(unknown_names)}")
    for id in taught:
        able = supported_types(id, **study.world_options(id))[0]
        if lacking := [type_ for type_ in study.instruction_types if type_ not in able]:
            problems.append(f"transfer: taught: {id} cannot have the instruction types {', '.join(lacking)}")
    types = lists.get("feedback_types", study.feedback_types)
    found = Transfer(
        lessons=_once(lists["lessons"]),
        students=_once(students),
        teachers=_once(teachers),
        feedback_types=_once(types),
        taught=_once(taught),
        worlds=_once(lists.get("worlds", [SAME])),
    )
    return found._asdict()


def _once(values: Sequence[Any]) -> tuple[Any, ...]:
    return tuple(dict.fromkeys(values))


def _list(name: str, value: Any, problems: list[str]) -> list[Any]:
    if not isinstance(value, Sequence) or isinstance(value, str | bytes) or (not value and name != "taught"):
        problems.append(f"transfer: {name} must be a non-empty list, got {value!r}")
        return []
    return list(value)


class InterimAnalyses(NamedTuple):
    """The interim analyses of a sequential design."""

    at: tuple[int, ...]
    """Numbers of seeds, ascending; the last is the study's number."""
    spending: str = "obrien_fleming"
    """One of `SPENDING`."""
    stop: bool = False
    """Whether the study ends as soon as every primary comparison is significant."""

    def last(self, seeds: int) -> int | None:
        """The last analysis, counted from 0, that needs at most these seeds; None before the first."""
        return max((i for i, needed in enumerate(self.at) if needed <= seeds), default=None)


def check_interim_analyses(table: Any, seeds: int, problems: list[str]) -> InterimAnalyses | None:
    """The design in a study's table `interim_analyses`.

    Args:
        table: has `at`, and may have `spending` and `stop`; empty: no design.
        seeds: the study's number of seeds.
        problems: the list to which problems are added.
    """
    if not table:
        return None
    if not isinstance(table, Mapping) or "at" not in table:
        problems.append(f"interim_analyses must be a table with `at`, as in {{at = [10, 20, 40]}}, got {table!r}")
        return None
    problems += [
        f"interim_analyses: {unknown('key', name, InterimAnalyses._fields)}"
        for name in table
        if name not in InterimAnalyses._fields
    ]
    at, spending, stop = table["at"], table.get("spending", "obrien_fleming"), table.get("stop", False)
    if not isinstance(stop, bool):
        problems.append(f"interim_analyses: stop must be true or false, got {stop!r}")
    if spending not in SPENDING:
        problems.append(f"interim_analyses: {unknown('spending', spending, SPENDING)}")
    counts = isinstance(at, Sequence) and not isinstance(at, str) and len(at) > 0 and all(map(is_count, at))
    if not counts or list(at) != sorted(set(at)) or at[-1] != seeds:
        problems.append(
            f"interim_analyses: at must be ascending numbers of seeds, the last one the study's {seeds}, got {at!r}; "
            f"for example {sorted({max(1, seeds // 2), seeds})}"
        )
        return None
    return InterimAnalyses(tuple(at), spending, stop)
