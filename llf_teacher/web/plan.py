"""What a lesson is to be, as somebody chose it on the page."""

import secrets
from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

from llf_teacher.episodes.live import WATCHER
from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.people import PersonTeaching
from llf_teacher.students.parsing import STUDENTS
from llf_teacher.students.student import Policy
from llf_teacher.studies import Study
from llf_teacher.studies.definition.custom_specs import teacher_spec
from pz_envs.seats import STUDENT, TEACHER
from teachers.personality import parse_personality
from teachers.session import is_count
from teachers.spec import parse_call, unknown

SEATS = {"student": STUDENT, "teacher": TEACHER, "watch": WATCHER}
"""Where one can sit, by the words of the page."""
SPEECHES = {"claims": "claims", "own words": "message"}
"""How a person teaches, by the words of the page."""
MOST_TURNS, LONGEST_SPEC = 200, 300


class Plan(NamedTuple):
    """What a lesson is to be."""

    id: str
    seat: str
    """Of whoever makes it: `STUDENT`, `TEACHER` or `WATCHER`."""
    two: bool
    """Whether another person sits in the other seat."""
    teacher: str
    """The personality that teaches, or that says what a person in its seat can choose from."""
    student: str
    speech: str
    """How a person teaches, of `SPEECHES`."""
    instruction_type: str
    feedback_type: str
    max_turns: int
    seed: int

    @property
    def people(self) -> frozenset[str]:
        """The seats in which people sit."""
        if self.seat == WATCHER:
            return frozenset()
        return frozenset((STUDENT, TEACHER) if self.two else (self.seat,))

    def spec(self, codes: Mapping[str, str]) -> EpisodeSpec:
        """The episode as a study names it; `codes` are those of the people, by their seats.

        Raises:
            ValueError: one error that lists all that is not allowed.
        """
        teacher: Any = self.teacher
        student = self.student
        if TEACHER in self.people:
            teacher = teacher_spec(PersonTeaching(codes.get(TEACHER, ""), self.speech, self.teacher))
        if STUDENT in self.people:
            code = codes.get(STUDENT, "")
            student = "llf_teacher.people:PersonLearning" + (f"(code={code!r})" if code else "")
        study = Study(
            ids=(self.id,),
            teachers=(teacher,),
            students=(student,),
            instruction_types=(self.instruction_type,),
            feedback_types=(self.feedback_type,),
            seeds=(self.seed,),
            max_turns=self.max_turns,
        )
        return next(study.episodes())


@cache
def students() -> tuple[str, ...]:
    """The students that the page offers: those of the shelf, less those that ask a model, which may cost money."""
    return tuple(name for name in STUDENTS.names if getattr(STUDENTS[name], "policy", Policy).record is Policy.record)


def read_plan(given: Mapping[str, Any]) -> Plan:
    """What was chosen, checked. Nothing is looked for but what is on the shelves: no text makes a module be imported.

    Raises:
        ValueError: something is missing or not allowed; the message says what to choose from.
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
    if type(given.get("two", False)) is not bool:
        raise ValueError(f"two must be true or false, got {given['two']!r:.60}")
    plan = Plan(
        texts["id"],
        SEATS[texts["seat"]],
        given.get("two", False),
        str(parse_personality(texts["teacher"])),
        _student(texts["student"]),
        SPEECHES[texts["speech"]],
        texts["instruction_type"],
        texts["feedback_type"],
        _number("max_turns", given.get("max_turns"), 1, MOST_TURNS) or 0,
        secrets.randbelow(2**31) if given.get("seed") is None else _number("seed", given["seed"], 0, 2**63 - 1) or 0,
    )
    if not plan.max_turns:
        from llf_teacher.registry import entry

        plan = plan._replace(max_turns=entry(plan.id).family.max_turns)
    spec = plan.spec({})
    return plan._replace(id=spec.id, feedback_type=spec.feedback_type)


_FIELDS = {
    "id": "",
    "seat": "student",
    "two": False,
    "teacher": "oracle",
    "student": "obedient",
    "speech": "claims",
    "instruction_type": "b",
    "feedback_type": "a",
    "max_turns": None,
    "seed": None,
}
"""What can be chosen, with what holds where nothing is."""


def _student(spec: str) -> str:
    call = parse_call("student", spec, STUDENTS.expected)
    if call.name not in students():
        raise ValueError(unknown("student of this page", call.name, students()))
    return str(STUDENTS.make(call))


def _number(name: str, value: Any, low: int, high: int) -> int | None:
    if value is None:
        return None
    if not is_count(value, high) and not (low == 0 and value == 0 and type(value) is int):
        raise ValueError(f"{name} must be a whole number from {low} to {high}, got {value!r:.60}")
    return int(value)
