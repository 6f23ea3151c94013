"""Checks for your own teachers, students and traits: `check_student(id, "mine")`, `check_trait(id, "mine")`.

Each check takes an environment and a student or a trait, and raises an AssertionError that describes the problem.
"""

import copy
import dataclasses
import pickle
import random
import sys
from collections.abc import Callable, Iterator
from itertools import islice
from typing import Any

import numpy as np

from llf_teacher.gym import StudentEnv
from llf_teacher.students.builtin.obedient import Obedient
from llf_teacher.students.builtin.text_only import TextOnly
from llf_teacher.students.parsing import STUDENTS, TRAITS, parse_student
from llf_teacher.students.student import READS, Policy, Student
from llf_teacher.students.trait import Trait
from llf_teacher.tools.audit import audit
from pz_envs.subject import Subject
from teachers.seeds import Seeds
from worlds.testing import plain, require

_TURNS = 20  # greatest number of turns of an episode
_SEEDS = range(3)


def check_teacher(id: str | Subject, teacher: Any, **settings: Any) -> None:
    """A teacher keeps its promises: an honest one says nothing false, and none leaks.

    Args:
        id, teacher, settings: as `llf_teacher.tools.audit.audit` takes them.

    Raises:
        AssertionError: it does not; the message has its words, and where it said them.
    """
    found = audit(id, teacher, **settings)
    require(found.turns > 0 and found.checked > 0, f"{found.teacher} made no claim in {found.id}: nothing to check")
    examples = "".join(f"\n  {example}" for example in found.examples)
    hedges = f"\n  its hedges are overconfident, p = {found.hedges.p_value:.2g}" if found.overconfident else ""
    require(not found.caught, f"{found.teacher} was caught in {found.id}:{examples}{hedges}")


def check_student(id: str | Subject, student: str | Student) -> None:
    """Run every check of a student.

    Args:
        id: an id of `llf_teacher.ids()`, or a `Lesson`, in which it can play.
        student: a student, or its spec.
    """
    for check in STUDENT_CHECKS:
        check(parse_student(student), id)


def check_value(student: Student, id: str | Subject) -> None:
    """It is a frozen value with defaults, which pickles, and whose spec string gives it back."""
    cls = type(student)
    own = dataclasses.is_dataclass(cls) and "__dataclass_fields__" in vars(cls)
    require(own, f"{cls.__name__} needs the decorator @dataclass(frozen=True)")
    require(cls.__doc__, f"{cls.__name__} needs a docstring of its own")
    require(student.reads in READS, f"{cls.__name__}.reads is {student.reads!r}; allowed: {', '.join(READS)}")
    same = pickle.loads(pickle.dumps(student))  # noqa: S301  # its own
    require(same == student and hash(same) == hash(student), f"{student} is another student after pickling")
    if student.name in STUDENTS.names:
        again = parse_student(str(student))
        require(cls() is not None and again == student, f"the spec {student} gives {again!r}, not {student!r}")
        definition = (sys.modules[cls.__module__].__doc__ or "").partition("\n")[0].partition(": ")[2]
        require(definition, f"the module of {cls.__name__} must begin with a docstring such as 'name: what it does.'")


def check_answers(student: Student, id: str | Subject) -> None:
    """Each action is legal; in text mode it is a string."""
    for seed in _SEEDS:
        env, policy = _seat(student, id)
        for action in _play(env, policy, seed):
            allowed = "a string" if student.text else env.session.world.action_syntax
            require(_is_legal(env, action), f"{student} answered {action!r}; allowed: {allowed}")


def check_silence(student: Student, id: str | Subject) -> None:
    """It also plays with a silent teacher, and its actions are legal."""
    env, policy = _seat(student, id, teacher="silent", feedback_type="n")
    for seed in _SEEDS:
        for action in _play(env, policy, seed):
            require(_is_legal(env, action), f"{student} answered {action!r} to a silent teacher")


def check_draws(student: Student, id: str | Subject) -> None:
    """The same seeds give the same actions, and no global random generator is used or seeded."""
    before = random.getstate(), plain(np.random.get_state())  # noqa: NPY002
    first, again = ([plain([*_play(*_seat(student, id), seed)]) for seed in _SEEDS] for _ in range(2))
    require(first == again, f"with the same seed {student} acts differently; draw from the `rng` that `reset` gets")
    after = random.getstate(), plain(np.random.get_state())  # noqa: NPY002
    require(before == after, f"{student} uses a global random generator; draw from the `rng` that `reset` gets")


def check_reset(student: Student, id: str | Subject) -> None:
    """After `reset` it acts like a new one, unless it says by `remembers` that it learns over episodes."""
    env, used = _seat(student, id)
    for seed in (*_SEEDS, *_SEEDS):
        expected = plain([*_play(*_seat(student, id), seed)])
        require(
            plain([*_play(env, used, seed)]) == expected or student.remembers,
            f"after {student} has played an episode it acts differently; set up its memory in `begin`, or have "
            "`remembers = True`",
        )


def check_acting_changes_nothing(student: Student, id: str | Subject) -> None:
    """Acting changes neither observation nor info nor the world."""
    env, policy = _seat(student, id)

    def act(observation: dict[str, Any], info: dict[str, Any]) -> Any:
        before = plain((observation, info, env.session.world.save()))
        action = policy.act(observation, info)
        same = plain((observation, info, env.session.world.save())) == before
        require(same, f"{student} changed its observation, its info or the world; copy what it keeps")
        return action

    for seed in _SEEDS:
        list(_play(env, policy, seed, act))


def check_copies(student: Student, id: str | Subject) -> None:
    """A copy of the policy within an episode, by `deepcopy`, continues like the original."""
    env, policy = _seat(student, id)
    twins: list[Policy[Any]] = []

    def act(observation: dict[str, Any], info: dict[str, Any]) -> Any:
        turn = env.session.moment.turn
        twins[:] = [copy.deepcopy(policy)] if turn == 2 else twins if turn else []
        action = policy.act(observation, info)
        same = all(plain(twin.act(observation, info)) == plain(action) for twin in twins)
        require(same, f"a copy of the policy of {student} does not continue like the original")
        return action

    for seed in _SEEDS:
        list(_play(env, policy, seed, act))


def _seat(student: Student, id: str | Subject, **settings: Any) -> tuple[StudentEnv, Policy[Any]]:
    """An environment with a policy for it."""
    env = StudentEnv(id, text=student.text, **settings)
    return env, student.seat(env.family, env.session.world)


def _play(
    env: StudentEnv, policy: Policy[Any], seed: int, act: Callable[[Any, Any], Any] | None = None
) -> Iterator[Any]:
    """The actions of a policy in an episode, up to the first illegal one; the policy sees the episode's end."""
    policy.reset(Seeds(seed).stream("student"))
    env.reset(seed=seed)
    view, session = env.student_view, env.session
    for _ in islice(iter(lambda: session.done, True), _TURNS):
        action = (act or policy.act)(view.observe(), view.info_for(policy))
        yield action
        if not _is_legal(env, action):
            return
        env.step(action)
    policy.finish(view.observe(), view.info_for(policy), session.terminated)


def _is_legal(env: StudentEnv, action: Any) -> bool:
    if env.student_view.text:
        return isinstance(action, str)
    try:
        env.session.world.legal(action)
    except ValueError:
        return False
    return True


STUDENT_CHECKS: tuple[Callable[[Student, str | Subject], None], ...] = (
    check_value,
    check_answers,
    check_silence,
    check_draws,
    check_reset,
    check_acting_changes_nothing,
    check_copies,
)
"""Every check of a student."""


def check_trait(id: str | Subject, trait: str | Trait) -> None:
    """Run every check of a trait.

    Args:
        id: an id of `llf_teacher.ids()`, or a `Lesson`, in which `obedient` and `text_only` act alike.
        trait: a trait, or its spec, such as `stubborn(p=0.3)`.
    """
    if isinstance(trait, str):
        (trait,) = TRAITS.parse(trait)
    for check in TRAIT_CHECKS:
        check(trait, id)


def check_trait_value(trait: Trait, id: str | Subject) -> None:
    """It is a frozen value with defaults that names its strength, and the student's spec string gives it back."""
    cls = type(trait)
    own = dataclasses.is_dataclass(cls) and "__dataclass_fields__" in vars(cls)
    require(own, f"{cls.__name__} needs the decorator @dataclass(frozen=True)")
    require(cls.__doc__, f"{cls.__name__} needs a docstring of its own")
    names = [field.name for field in dataclasses.fields(trait)]
    strength = getattr(cls, "strength", None)
    require(strength in names, f"{cls.__name__}.strength is {strength!r}; allowed: one of its fields {names}")
    student = Obedient() | trait
    require(pickle.loads(pickle.dumps(student)) == student, f"{trait} is another trait after pickling")  # noqa: S301
    if trait.name in TRAITS.names:
        require(parse_student(str(student)) == student, f"the spec {student} gives {parse_student(str(student))!r}")
        definition = (sys.modules[cls.__module__].__doc__ or "").partition("\n")[0].partition(": ")[2]
        require(definition, f"the module of {cls.__name__} must begin with a docstring such as 'name: what it does.'")


def check_trait_absent(trait: Trait, id: str | Subject) -> None:
    """At the strength `absent` the student acts as without it."""
    none = dataclasses.replace(trait, **{trait.strength: trait.absent})
    for student in (Obedient(), TextOnly()):
        for seed in _SEEDS:
            bare, traited = ([*_play(*_seat(each, id), seed)] for each in (student, student | none))
            require(plain(bare) == plain(traited), f"{student | none} acts otherwise than {student}")


def check_trait_agrees(trait: Trait, id: str | Subject) -> None:
    """A student that reads text acts with it as one that reads atoms does."""
    for settings in ({"feedback_type": "fp"}, {"instruction_type": "c", "feedback_type": "n", "teacher": "silent"}):
        for seed in _SEEDS:
            atoms, text = ([*_play(*_seat(each | trait, id, **settings), seed)] for each in (Obedient(), TextOnly()))
            require(
                plain(atoms) == plain(text),
                f"with {trait} text_only acts otherwise than obedient; `hear` must return a claim whose words say all",
            )


def check_trait_student(trait: Trait, id: str | Subject) -> None:
    """A student with it passes the checks of students."""
    for check in STUDENT_CHECKS:
        check(Obedient() | trait, id)


TRAIT_CHECKS: tuple[Callable[[Trait, str | Subject], None], ...] = (
    check_trait_value,
    check_trait_absent,
    check_trait_agrees,
    check_trait_student,
)
"""Every check of a trait."""
