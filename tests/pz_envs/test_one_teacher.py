"""A seat receives its teacher: there is one of it, and what it would say is offered to whoever sits there."""

import pytest

import llf_teacher
from llf_teacher import compat
from pz_envs.family import all_families
from pz_envs.seats import STUDENT, TEACHER
from teachers.oracle import Oracle
from teachers.teacher import Teacher

ID = "llf-gridworld-v0"
GRID = next(family for family in all_families() if ID.removeprefix("llf-") in family.environments)


@pytest.mark.parametrize(
    "make",
    [
        lambda: llf_teacher.make(ID),
        lambda: llf_teacher.make(ID, teacher="mistake | delayed"),
        lambda: llf_teacher.TeacherEnv(ID, student="random", episodes=2),
        lambda: compat.make(ID),
        lambda: GRID.raw_env(),
        lambda: GRID.raw_env(speech="kinds"),
    ],
    ids=["make", "personality", "TeacherEnv", "compat", "message", "kinds"],
)
def test_nothing_builds_a_second_teacher(make, monkeypatch):
    made = []
    for cls in (Teacher, Oracle):

        def count(self, *args, cls=cls, begin=cls.__init__, **settings):
            made.append(cls)
            begin(self, *args, **settings)

        monkeypatch.setattr(cls, "__init__", count)
    make().reset(seed=1)
    assert made == [Oracle, Teacher]


def test_the_teacher_of_the_seats_is_the_one_that_speaks():
    env = llf_teacher.make(ID, teacher="only(kinds='fp')")
    env.reset(seed=1)
    assert env.teacher is env.session.teacher
    assert env.session.teacher.oracle.importance(env.session.moment.after) > 0


def said_by(seats, seed, turns=6):
    """All that the student hears when the teacher's seat takes every suggestion."""
    seats.reset(seed=seed)
    heard = []
    for turn in range(turns):
        seats.step(seats.infos[TEACHER]["suggestion"])
        told = seats.observe(STUDENT)
        heard.append((str(told["instruction"]), str(told["feedback"])))
        seats.step(turn % 4)
    return heard


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"teacher": "mistake(eps=0.5)", "voice": "warm"},
        {"instruction_type": "p", "feedback_type": "r+fp"},
        {"feedback_type": "m", "paraphrase": 2},
        {"feedback_type": "n"},
        {"teacher": "silent"},
        {"budget": 3},
    ],
    ids=str,
)
def test_suggestions_are_what_the_student_would_hear_from_the_same_settings(settings):
    """They are those of `make` with the same seed."""
    env = llf_teacher.make(ID, **settings)
    observation, _ = env.reset(seed=9)
    heard = [(str(observation["instruction"]), str(observation["feedback"]))]
    for turn in range(5):
        observation = env.step(turn % 4)[0]
        heard.append((heard[0][0], str(observation["feedback"])))
    assert said_by(GRID.raw_env(**settings), 9) == heard


def test_suggestions_in_a_classroom_and_a_panel():
    room = GRID.raw_env(seating="classroom", students=2, speech="message", teacher="only(kinds='fp')")
    room.reset(seed=4)
    first, second = room.infos[TEACHER]["suggestions"]
    assert [atom.kind for atom in (*first.atoms, *second.atoms)] == ["fp", "fp"]
    room.step({"student": 2, "words": second})
    assert room.observe("student_1")["feedback"] == second
    panel = GRID.raw_env(seating="panel", teachers=["only(kinds='fp')", "only(kinds='fn')"], speech="message")
    panel.reset(seed=4)
    for kind, agent in (("fp", "teacher_0"), ("fn", "teacher_1")):
        assert [atom.kind for atom in panel.infos[agent]["suggestion"].atoms] == [kind]
        panel.step(panel.infos[agent]["suggestion"])


def test_a_teacher_that_is_given_brings_its_own_settings():
    world = GRID.make_world()
    teacher = GRID.make_teacher(world, feedback_type="fp")
    env = llf_teacher.make(ID, teacher=teacher)
    env.reset(seed=1)
    assert env.session.teacher is teacher
    with pytest.raises(ValueError, match="feedback_type, voice: a given Teacher has its own"):
        llf_teacher.make(ID, teacher=teacher, feedback_type="r", voice="warm")


def test_a_panel_has_teachers():
    with pytest.raises(
        ValueError, match=r"a panel does not use teacher='silent'; give its teachers as teachers=\[...\]"
    ):
        GRID.raw_env(seating="panel", teacher="silent")


def test_an_unknown_seating():
    with pytest.raises(ValueError, match="unknown seating 'clasroom'; did you mean classroom"):
        GRID.raw_env(seating="clasroom")
