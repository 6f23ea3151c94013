"""A turn happens in one place: whatever plays a lesson plays it through a `Session`."""

import sys

import gymnasium
import numpy as np
import pytest
from playing import Fixed

import llf_teacher
from llf_teacher import compat
from llf_teacher.compat.agent_utils import rollout as llfbench_rollout
from llf_teacher.episodes.live import WATCHER, LiveLesson
from llf_teacher.integrations.dialogue import Dialogue
from llf_teacher.integrations.trl import FeedbackEnvironment
from llf_teacher.registry import PREFIX, entry
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies import Study, run
from llf_teacher.studies.execution.runner import RunOptions
from llf_teacher.tools import golden
from llf_teacher.tools.audit import audit
from llf_teacher.tools.benchmark.measuring import Writer
from llf_teacher.tools.film import film
from llf_teacher.tools.pages.gallery import _episode as reply
from llf_teacher.tools.pictures import sample
from llf_teacher.web.lesson import PlannedLesson, frames
from llf_teacher.web.plan import read_plan
from pz_envs.parallel_seats import ParallelSeats
from pz_envs.seats import STUDENT, TEACHER
from pz_envs.settings import Settings
from teachers import session, teacher_turn
from teachers.teacher import Teacher
from teachers.testing import Pupil

ID = "llf-gridworld-v0"
FAMILY = entry(ID).family
WORLD = type(FAMILY.make_world())
HOMES = {session.__file__, teacher_turn.__file__}
"""The only modules that let a teacher judge and speak; only the first steps a world."""


def seats(**settings):
    env = FAMILY.raw_env(max_cycles=3, **settings)
    env.reset(seed=1)
    for agent in env.agent_iter():
        _, _, terminated, truncated, _ = env.last()
        space = env.action_space(agent)
        space.seed(1)
        env.step(None if terminated or truncated else space.sample())


def gym(env):
    env.reset(seed=1)
    env.action_space.seed(1)
    for _ in range(3):
        *_, terminated, truncated, _ = env.step(env.action_space.sample())
        if np.any(terminated) or np.any(truncated):
            break


def partners():
    env = FAMILY.raw_env(speech="kinds", max_cycles=3)
    parallel = ParallelSeats(env, {STUDENT: parse_student("obedient").seat(FAMILY, env.session.world)})
    parallel.reset(seed=1)
    while parallel.agents:
        parallel.step({TEACHER: 31})


def studies(path, **settings):
    study = Study(ids=(ID,), teachers=("oracle",), students=("obedient",), seeds=(1,), max_turns=3, **settings)
    run(study, path, options=RunOptions("here"))


def live(people, **settings):
    student = None if STUDENT in people else parse_student("obedient")
    settings = Settings(text=student is None, max_turns=3, render_mode="ansi", **settings)
    lesson = LiveLesson(entry(ID), settings, 1, frozenset(people), student)
    saying = {"kinds": 31, "claims": [0], "message": "Go."}[settings.speech]
    moves = {STUDENT: "north", TEACHER: saying, WATCHER: None}
    lesson.move(lesson.to_move, moves[lesson.to_move])
    lesson.undo(lesson.moves[-1][0])
    while not lesson.over:
        lesson.move(lesson.to_move, moves[lesson.to_move])


def page():
    lesson = PlannedLesson(read_plan({"id": ID, "seat": "watch", "seed": 1, "max_turns": 3}))
    while not lesson.over:
        lesson.move(WATCHER, None)
    frames(lesson.plan, lesson.inputs)


def dialogue():
    talk = Dialogue(ID, 1, max_turns=3)
    while not talk.over:
        talk.answer("north")
        talk.speak("Go on.")


def trl():
    env = FeedbackEnvironment(ID, max_turns=3)
    env.reset(seed=1)
    env.act("north")
    env.get_reward()


class Agent:
    """As LLF-Bench has them."""

    def reset(self, docstring):
        """Begin."""

    def act(self, observation, feedback):
        """The action."""
        return 0


def kit():
    pupil = Pupil(FAMILY.make_world, FAMILY.make_teacher, max_turns=3, turns=6)
    list(pupil.said({}, habit="garbling"))
    pupil.taught("delayed", 6)


DOORS = {
    **{
        f"tutoring {speech}": lambda _, speech=speech: seats(speech=speech) for speech in ("message", "kinds", "claims")
    },
    "asking": lambda _: seats(speech="kinds", ask_cost=0.1),
    "classroom": lambda _: seats(seating="classroom", students=2),
    "panel": lambda _: seats(seating="panel"),
    "lifetime": lambda _: seats(speech="kinds", episodes=2),
    "partners": lambda _: partners(),
    "make": lambda _: gym(llf_teacher.make(ID, text=False)),
    "policy": lambda _: gym(llf_teacher.make(ID, teacher=Fixed(""))),
    "vector": lambda _: gym(gymnasium.make_vec(ID, 2, vectorization_mode="sync")),
    "teach": lambda _: gym(llf_teacher.teach(gymnasium.make("FrozenLake-v1"))),
    "TeacherEnv": lambda _: gym(llf_teacher.TeacherEnv(ID, episodes=2, student="q_learning(forget=False)")),
    "rollout": lambda _: llf_teacher.rollout(lambda prompts: ["north"] * len(prompts), ID, 2, max_turns=3),
    "study": lambda path: studies(path / "study.sqlite"),
    "live student": lambda _: live({STUDENT}),
    "live teacher": lambda _: live({TEACHER}, speech="kinds"),
    "live people": lambda _: live({STUDENT, TEACHER}, speech="claims"),
    "live watched": lambda _: live(set()),
    "page": lambda _: page(),
    "dialogue": lambda _: dialogue(),
    "trl": lambda _: trl(),
    "compat": lambda _: llfbench_rollout(Agent(), compat.make(ID), horizon=3, seed=1),
    "film": lambda _: film(ID, student="obedient", seed=1, max_turns=3),
    "golden": lambda _: golden.transcript(ID, turns=3),
    "picture": lambda _: sample(ID.removeprefix(PREFIX)),
    "gallery": lambda _: list(reply(FAMILY, "oracle", 1)),
    "audit": lambda _: audit(ID, turns=6),
    "benchmark": lambda _: Writer(ID, "random").episode(3),
    "kit": lambda _: kit(),
}
"""Everything that plays lessons."""


def callers():
    frame = sys._getframe(2)
    while frame is not None:
        yield frame.f_code.co_filename
        frame = frame.f_back


@pytest.mark.parametrize("door", DOORS)
def test_a_turn_is_played_by_a_session(door, monkeypatch, tmp_path):
    """Each step of a taught world, and all that a teacher judges or says; scratch worlds are for experiments."""
    scratch, seen = {}, {"advance": 0, "teacher": 0}
    worlds = {WORLD}
    if door == "teach":
        from worlds.wrapped.gym_world import GymWorld

        worlds.add(GymWorld)

    def watched(cls, name, what):
        original = getattr(cls, name)

        def wrapper(self, *args, **settings):
            if id(self) not in scratch:
                seen[what] += 1
                homes = HOMES if what == "teacher" else {session.__file__}
                assert homes & {*callers()}, f"{cls.__name__}.{name} is called outside of a session"
            return original(self, *args, **settings)

        monkeypatch.setattr(cls, name, wrapper)

    for cls in worlds:
        original = cls.scratch

        def remembered(self, original=original):
            made = original(self)
            scratch[id(made)] = made  # which is kept, so that its id stays its own
            return made

        monkeypatch.setattr(cls, "scratch", remembered)
        watched(cls, "advance", "advance")
    for name in ("begin", "notice", "judge", "answer"):
        watched(Teacher, name, "teacher")
    DOORS[door](tmp_path)
    assert seen["teacher"] > 2
    assert seen["advance"]
