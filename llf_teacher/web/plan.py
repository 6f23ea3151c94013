"""The plan of a lesson: the choices of the page's form, checked."""

import secrets
from collections.abc import Collection, Mapping
from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

from llf_teacher.episodes.live import WATCHER
from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.people import PersonTeaching
from llf_teacher.registry import entry
from llf_teacher.students.parsing import STUDENTS, parse_student
from llf_teacher.students.student import Policy
from llf_teacher.studies import Study
from llf_teacher.studies.definition.custom_specs import teacher_spec
from pz_envs.seats import STUDENT, TEACHER
from pz_envs.settings import Settings
from pz_envs.subject import GYM
from teachers.personality import parse_personality
from teachers.spec import is_count, parse_calls, paths_in, unknown

SEATS = {"student": STUDENT, "teacher": TEACHER, "watch": WATCHER}
"""The seats by the words of the page."""
SPEECHES = {"claims": "claims", "own words": "message"}
"""The forms of a person's teaching by the words of the page."""
MOST_TURNS, LONGEST_SPEC = 200, 300


class Plan(NamedTuple):
    """The plan of a lesson."""

    id: str
    seat: str
    """The seat of the lesson's maker: `STUDENT`, `TEACHER` or `WATCHER`."""
    two: bool
    """Whether a person has the other seat, too."""
    student: str
    """The student's spec, if no person has its seat."""
    settings: Settings
    """The chosen settings: `teacher` is a personality's spec, also if a person chooses among its claims or sees its
    suggestions; `speech` is the form of a person's speech in the teacher's seat.
    """
    seed: int
    bits: bool = False
    """Whether the page shows the information of each sentence, except to the student."""

    @property
    def options(self) -> dict[str, Any]:
        """Options of the world that measuring needs, beside the id's."""
        return dict(entry(self.id).family.posterior_needs) if self.bits else {}

    @property
    def people(self) -> frozenset[str]:
        """The seats of people."""
        if self.seat == WATCHER:
            return frozenset()
        return frozenset((STUDENT, TEACHER) if self.two else (self.seat,))

    def spec(self) -> EpisodeSpec:
        """The spec of the episode in a study.

        Raises:
            ValueError: one error that lists everything that is not allowed.
        """
        settings, student = self.settings, self.student
        teacher: Any = settings.teacher
        if TEACHER in self.people:
            teacher = teacher_spec(PersonTeaching(settings.speech, teacher))
        if STUDENT in self.people:
            student = "llf_teacher.people:PersonLearning"
        study = Study(
            ids=(self.id,),
            teachers=(teacher,),
            students=(student,),
            instruction_types=(settings.instruction_type,),
            feedback_types=(f"{settings.feedback_type}",),
            seeds=(self.seed,),
            max_turns=settings.max_turns,
            options={self.id: self.options} if self.options else {},
            bits=self.bits,
        )
        return next(study.episodes())


@cache
def students() -> tuple[str, ...]:
    """The students that the page offers: the built-in ones, without those that call a model, which may cost money."""
    return tuple(name for name in STUDENTS.names if getattr(STUDENTS[name], "policy", Policy).record is Policy.record)


def read_plan(given: Mapping[str, Any], ids: Collection[str] = (), own: Collection[str] = ()) -> Plan:
    """The plan of the form's values. No value can import a module that was not offered when the server began.

    Args:
        given: the values.
        ids: the offered environments of Gymnasium's registry.
        own: the offered teachers and students of the user's own, as `module:name`.

    Raises:
        ValueError: a value is missing or not allowed; the message lists what is.
    """
    if unknown_names := [name for name in given if name not in _FIELDS]:
        raise ValueError(unknown("choice", unknown_names[0], _FIELDS))
    texts = {name: given.get(name, default) for name, default in _FIELDS.items() if isinstance(default, str)}
    for name, text in texts.items():
        if not isinstance(text, str) or len(text) > LONGEST_SPEC:
            raise ValueError(f"{name} must be a text of at most {LONGEST_SPEC} characters, got {text!r:.60}")
    for name, allowed in (("seat", SEATS), ("speech", SPEECHES)):
        if texts[name] not in allowed:
            raise ValueError(unknown(name, texts[name], allowed))
    if texts["id"].startswith(GYM) and texts["id"] not in ids:
        raise ValueError(unknown("environment of this page", texts["id"], ids))
    for name in ("two", "bits"):
        if type(given.get(name, False)) is not bool:
            raise ValueError(f"{name} must be true or false, got {given[name]!r:.60}")
    if given.get("bits") and texts["seat"] == "student":
        raise ValueError("a student cannot see how much is said; take the teacher's seat, or watch")
    plan = Plan(
        texts["id"],
        SEATS[texts["seat"]],
        given.get("two", False),
        _student(texts["student"], own),
        Settings(
            teacher=_teacher(texts["teacher"], own),
            instruction_type=texts["instruction_type"],
            feedback_type=texts["feedback_type"],
            speech=SPEECHES[texts["speech"]],
            max_turns=_number("max_turns", given.get("max_turns"), 1, MOST_TURNS),
        ),
        secrets.randbelow(2**31) if given.get("seed") is None else _number("seed", given["seed"], 0, 2**63 - 1) or 0,
        given.get("bits", False),
    )
    if plan.settings.max_turns is None:
        max_turns = entry(plan.id).family.max_turns
        plan = plan._replace(settings=replace(plan.settings, max_turns=max_turns))
    spec = plan.spec()
    return plan._replace(id=spec.id, settings=replace(plan.settings, feedback_type=spec.feedback_type))


_FIELDS = {
    "id": "",
    "seat": "student",
    "two": False,
    "bits": False,
    "teacher": Settings.teacher,
    "student": "obedient",
    "speech": "claims",
    "instruction_type": Settings.instruction_type,
    "feedback_type": Settings.feedback_type,
    "max_turns": None,
    "seed": None,
}
"""The fields of the form with their defaults."""


def _teacher(spec: str, own: Collection[str]) -> str:
    _check_offered("teacher", spec, own)
    return str(parse_personality(spec))


def _student(spec: str, own: Collection[str]) -> str:
    _check_offered("student", spec, own)
    first, *_ = parse_calls("student", spec, STUDENTS.expected, prefixes=2)
    if not first.prefix and first.name not in students():
        raise ValueError(unknown("student of this page", first.name, students()))
    return str(parse_student(spec))


def _check_offered(what: str, spec: str, own: Collection[str]) -> None:
    """Check that the user's own classes in a spec, which are imported, were offered when the server began.

    Raises:
        ValueError: some were not.
    """
    for path in paths_in(spec) if ":" in spec else ():
        if path not in own:
            raise ValueError(f"{unknown(f'{what} of this page', path, own)}; `llf serve --{what} {path}` offers it")


def _number(name: str, value: Any, low: int, high: int) -> int | None:
    if value is None:
        return None
    if not is_count(value, high) and not (low == 0 and value == 0 and type(value) is int):
        raise ValueError(f"{name} must be a whole number from {low} to {high}, got {value!r:.60}")
    return int(value)
