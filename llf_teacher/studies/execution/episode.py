"""Playing one episode of a study, and the lessons before it if it is a test.

Episodes of one setting share their environment and its recorder, since making these takes as long as a short episode.
Each episode has a new student, and a new teacher if that is not a personality.
"""

import contextlib
import threading
from collections.abc import Callable, Iterator
from typing import NamedTuple

from llf_teacher.episodes.loop import play_remaining_turns, play_turns
from llf_teacher.episodes.record import EpisodeSpec, Record
from llf_teacher.episodes.recorder import Recorder
from llf_teacher.gym import StudentEnv
from llf_teacher.speakers.parsing import NOBODY, arguments_of, parse_teacher, speaks_freely
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.student import Policy, Student
from llf_teacher.studies.definition.design import SAME, TEST_TYPE, TESTER
from llf_teacher.studies.definition.options import read_options
from teachers.personality import Personality, PersonalityError


class _Lesson(NamedTuple):
    """The shared objects of a setting's episodes."""

    setting: tuple[object, ...]
    env: StudentEnv
    recorder: Recorder
    own_words: bool
    """Whether the teacher may speak in its own words."""


class _Idle(threading.local):
    """The last completed lessons of a thread, for reuse; lessons in progress are not included."""

    def __init__(self) -> None:
        self.lessons: list[_Lesson] = []

    def take(self, setting: tuple[object, ...]) -> _Lesson | None:
        """Remove and return the lesson of a setting; None without one."""
        for i, lesson in enumerate(self.lessons):
            if lesson.setting == setting:
                return self.lessons.pop(i)
        return None


_idle = _Idle()
_KEPT = 2  # for a test and the lessons before it


def close_lessons() -> None:
    """Close the shared objects of this thread's episodes."""
    while _idle.lessons:
        _idle.lessons.pop().env.close()


@contextlib.contextmanager
def _lesson(spec: EpisodeSpec, player: Student, id: str, teacher: str, feedback_type: str) -> Iterator[_Lesson]:
    """The lesson of an episode's setting; after an error it is not used again."""
    taught = parse_teacher(teacher)
    setting = id, taught, spec.instruction_type, feedback_type, spec.max_turns, player.text, spec.options
    lesson = _idle.take(setting)
    if lesson is None:
        env = StudentEnv(
            id,
            **arguments_of(taught, feedback_type),
            instruction_type=spec.instruction_type,
            feedback_type=feedback_type,
            max_turns=spec.max_turns,
            text=player.text,
            **read_options(spec.options, id, player.text),
        )
        lesson = _Lesson(setting, env, Recorder(env.family.name, env.student_view, env.teacher), speaks_freely(taught))
    yield lesson
    lesson.recorder.forget()
    if not isinstance(taught, Personality):
        lesson.env.close()
        return
    _idle.lessons.append(lesson)
    if len(_idle.lessons) > _KEPT:
        _idle.lessons.pop(0).env.close()


def play(spec: EpisodeSpec, begins: Callable[[int], object] | None = None) -> Record:
    """Play an episode of a study and record it; the lessons before a test are played and not recorded.

    Args:
        spec: the episode.
        begins: called with the number of each turn when it begins.
    """
    player = parse_student(spec.student)
    teacher, feedback_type = (TESTER, TEST_TYPE) if spec.lessons else (spec.teacher, spec.feedback_type)
    with _lesson(spec, player, spec.id, teacher, feedback_type) as (_, env, recorder, free):
        student = player.seat(env.family, env.session.world)
        recorder.measure(env.family, spec.seed, spec.draws)
        recorder.read(env.family, spec.reader if free else NOBODY)
        if spec.lessons:
            attend(spec, player, student)
        for turn in play_turns(env, student, spec.seed, sample=spec.sample):
            recorder.note(**(student.record() if turn.moment.turn else {}))
            if begins:
                begins(turn.moment.turn + 1)
        return Record(spec, recorder.episode(student.reads), tuple(recorder.rows))


def rehearse(spec: EpisodeSpec) -> None:
    """Let the teacher of an episode speak in two turns of a random student, to see whether what it says has the form.

    Other errors of its code are left to the episodes, which fail and have them in the store.

    Raises:
        ValueError: it says what are no claims.
    """
    short = spec._replace(student="random", max_turns=min(spec.max_turns, 2), draws=0, reader=NOBODY)
    try:
        play(short._replace(lessons=0, taught="", worlds=""))
    except PersonalityError as error:
        raise ValueError(f"teacher {spec.teacher!r}: {error}") from None
    except (Exception, SystemExit):  # noqa: S110  # users' own code may raise anything
        pass


def attend(spec: EpisodeSpec, player: Student, policy: Policy[Student]) -> None:
    """Play the lessons before a test with the student's policy.

    The seed's streams continue from lesson to lesson; the test has their first episode. Lessons end like episodes of
    studies, each with a call of the policy's `finish`.
    """
    with _lesson(spec, player, spec.taught, spec.teacher, spec.feedback_type) as (_, env, *_):
        env.reset(seed=spec.seed)
        session, view = env.session, env.student_view
        opening = session.moment
        for _ in range(spec.lessons):
            env.reset()
            if spec.worlds == SAME:
                env.resume_from(opening)
            policy.reset(session.seeds.stream("student"))
            for _ in play_remaining_turns(env, policy):
                pass
            policy.finish(view.observe(), view.info_for(policy), session.terminated)
