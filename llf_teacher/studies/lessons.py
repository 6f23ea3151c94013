"""Lessons before a test: what a student who remembers has gone through when a study's episode begins."""

from llf_teacher.gym import make
from llf_teacher.students.student import Policy, Student
from llf_teacher.studies.design import SAME
from llf_teacher.studies.options import read_options
from llf_teacher.studies.own import arguments_of, parse_teacher
from llf_teacher.studies.study import EpisodeSpec
from pz_envs.seats import STUDENT, entitled


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
