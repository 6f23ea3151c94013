"""Playing one episode of a study, and the lessons before it if it is a test."""

from collections.abc import Callable

from llf_teacher.episodes.record import EpisodeSpec, Record, summary
from llf_teacher.episodes.scenes import scenes, turn_row
from llf_teacher.gym import make
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.student import Policy, Student
from llf_teacher.studies.definition.custom_specs import arguments_of, parse_teacher
from llf_teacher.studies.definition.design import SAME, TEST_TYPE, TESTER
from llf_teacher.studies.definition.options import read_options
from pz_envs.seats import STUDENT, entitled


def play(spec: EpisodeSpec, begins: Callable[[int], object] | None = None) -> Record:
    """Play an episode of a study, and account for it; the lessons before a test are played and not recorded.

    Args:
        spec: the episode.
        begins: is called with the number of each turn that begins.
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
    student = player.seat(env.family, env.aec.world)
    if spec.lessons:
        attend(spec, player, student)
    rows = []
    for scene in scenes(env, student, spec.seed, sample=spec.sample):
        turn = scene.moment.turn
        said = student.record() if turn else {}
        rows.append(turn_row(env.aec, env.family.name, scene, env.teacher)._replace(**said))
        if begins:
            begins(turn + 1)
    env.close()
    return Record(spec, summary(env.family.name, student.reads, rows), tuple(rows))


def attend(spec: EpisodeSpec, player: Student, policy: Policy[Student]) -> None:
    """Have the student's policy go through the lessons of an episode.

    The seed's streams go on from lesson to lesson, the test being their first episode. Lessons end as episodes of
    studies do; the policy is told by `finish`.
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
    aec, opening = env.aec, env.aec.moment
    for _ in range(spec.lessons):
        env.reset()
        if spec.worlds == SAME:
            env.take_up(opening)
        policy.reset(aec.seeds.stream("student"))
        terminated = done = False
        while not done:
            action = policy.act(aec.observe(STUDENT), entitled(policy, aec))
            _, _, terminated, _, _ = env.step(action)
            done = env.family.is_over(aec.moment)
        policy.finish(aec.observe(STUDENT), entitled(policy, aec), terminated)
    env.close()
