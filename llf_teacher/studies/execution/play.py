"""Playing one episode of a study, and the lessons before it if it is a test."""

from collections.abc import Callable

from llf_teacher.episodes.loop import play_remaining_turns, play_turns
from llf_teacher.episodes.record import EpisodeSpec, Record
from llf_teacher.episodes.recorder import Recorder
from llf_teacher.gym import make
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.student import Policy, Student
from llf_teacher.studies.definition.custom_specs import arguments_of, parse_teacher
from llf_teacher.studies.definition.design import SAME, TEST_TYPE, TESTER
from llf_teacher.studies.definition.options import read_options


def play(spec: EpisodeSpec, begins: Callable[[int], object] | None = None) -> Record:
    """Play an episode of a study and record it; the lessons before a test are played and not recorded.

    Args:
        spec: the episode.
        begins: called with the number of each turn when it begins.
    """
    player = parse_student(spec.student)
    teacher, feedback_type = (TESTER, TEST_TYPE) if spec.lessons else (spec.teacher, spec.feedback_type)
    env = make(
        spec.id,
        **arguments_of(parse_teacher(teacher), feedback_type),
        instruction_type=spec.instruction_type,
        feedback_type=feedback_type,
        max_turns=spec.max_turns,
        text=player.text,
        **read_options(spec.options, spec.id, player.text),
    )
    student = player.seat(env.family, env.session.world)
    if spec.lessons:
        attend(spec, player, student)
    recorder = Recorder(env.family.name, env.student_view, env.teacher)
    for turn in play_turns(env, student, spec.seed, sample=spec.sample):
        recorder.note(**(student.record() if turn.moment.turn else {}))
        if begins:
            begins(turn.moment.turn + 1)
    env.close()
    return Record(spec, recorder.episode(student.reads), tuple(recorder.rows))


def attend(spec: EpisodeSpec, player: Student, policy: Policy[Student]) -> None:
    """Play the lessons before a test with the student's policy.

    The seed's streams continue from lesson to lesson; the test has their first episode. Lessons end as episodes of
    studies do, each with a call of the policy's `finish`.
    """
    env = make(
        spec.taught,
        **arguments_of(parse_teacher(spec.teacher), spec.feedback_type),
        instruction_type=spec.instruction_type,
        feedback_type=spec.feedback_type,
        max_turns=spec.max_turns,
        text=player.text,
        **read_options(spec.options, spec.taught, player.text),
    )
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
    env.close()
