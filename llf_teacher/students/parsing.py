"""Students and traits by their spec strings, and students by what can be learned."""

from dataclasses import asdict

from llf_teacher.students import builtin, traits
from llf_teacher.students.agents import make_agent
from llf_teacher.students.chat import CHAT, make_chat_student
from llf_teacher.students.student import Student
from llf_teacher.students.trait import Trait, Traited
from pz_envs.learning import Learning
from teachers.spec import Registry, SpecCall, bad_spec, parse_calls

STUDENTS = Registry[Student]("student", Student, builtin)  # type: ignore[type-abstract]  # it never makes a `Student`
"""Every student by its name."""


TRAITS = Registry("trait", Trait, traits)
"""Every trait by its name."""


def parse_student(spec: str | Student) -> Student:
    """The student that a spec string describes.

    `package.module:factory` is an agent of the user's own, `chat:package.module:function` a function that answers
    prompts; these import the module. Traits follow, as in `obedient | stubborn(p=0.3) | mishears`; users' own traits
    are `package.module:Class`.

    Raises:
        ValueError: bad syntax, an unknown name, module or parameter, or a trait without an effect on this student.
    """
    if isinstance(spec, Student):
        return spec
    expected = f"`package.module:factory`, `{CHAT}:package.module:function`, or {STUDENTS.expected}"
    first, *others = parse_calls("student", spec, expected, prefixes=2)
    if (len(first.prefix) > 1 and first.prefix[0] != CHAT) or any(len(call.prefix) > 1 for call in others):
        raise bad_spec("student", spec, expected)
    student = _student(first)
    return Traited(student, tuple(map(TRAITS.make, others))) if others else student


def _student(call: SpecCall) -> Student:
    if not call.prefix:
        return STUDENTS.make(call)
    return make_chat_student(call) if call.prefix[0] == CHAT else make_agent(call)


def student_for(learning: Learning) -> Student:
    """The student that learns from rewards alone with these settings.

    Raises:
        ValueError: no student does.
    """
    for name in STUDENTS.names:
        cls = STUDENTS[name]
        if cls.suits is type(learning):
            return cls(**asdict(learning))
    raise ValueError(f"no student learns from {learning!r}; `suits` of a student names what it learns from")
