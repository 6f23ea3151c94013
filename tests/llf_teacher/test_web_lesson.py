"""Lessons with people in the seats are those of studies, and can be taken back."""

import numpy as np
import pytest

import llf_teacher
from llf_teacher.episodes.live import WATCHER
from llf_teacher.people import PersonLearning, PersonTeaching
from llf_teacher.studies import Study, load
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.store import Store
from llf_teacher.web.lesson import PlannedLesson, frames
from llf_teacher.web.plan import read_plan, students
from pz_envs.frames import EpisodeRenderer
from pz_envs.seats import STUDENT, TEACHER
from teachers.atoms import Label

GRID = "llf-gridworld-v0"
IDS = [
    GRID,
    "llf-bandits-BanditTenArmedGaussian-v0",
    "llf-optimization-Booth-v0",
    *(pytest.param(id, marks=pytest.mark.full) for id in ("llf-poem-Haiku-v0", "llf-alfworld-v0", "llf-parking-v0")),
]


def lesson(id=GRID, **choices):
    return PlannedLesson(read_plan({"id": id, "seed": 7, "max_turns": 6, **choices}))


def to_the_end(live, who, what=None):
    while not live.over:
        live.move(who, what)
    return live


@pytest.mark.parametrize("teacher", ["oracle", "mistake(eps=0.5) | delayed(turns=1)"])
@pytest.mark.parametrize("id", IDS)
def test_who_watches_sees_the_episode_of_a_study(id, teacher):
    live = to_the_end(lesson(id, seat="watch", teacher=teacher), WATCHER)
    assert live.record() == play(live.plan.spec())


@pytest.mark.parametrize("id", [*IDS[:2], "llf-poem-Haiku-v0"])
def test_who_sees_how_much_is_said_sees_the_episode_of_a_study_that_measures_it(id):
    live = to_the_end(lesson(id, seat="watch", bits=True, max_turns=2), WATCHER)
    spec = live.plan.spec()
    assert spec.draws == 256
    assert live.record() == play(spec)
    assert live.unmeasured == live.record().episode.why
    assert ("no posterior" in live.unmeasured) == ("poem" in id)


def test_claims_to_choose_from_are_weighed_as_they_are_heard():
    live = lesson(IDS[1], seat="teacher", bits=True)
    for _ in range(2):
        listed = live.listed()
        first, *_ = live.weigh(listed)
        assert live.weigh(listed)[0].worlds == 256  # it is not heard by that
        live.move(TEACHER, [0])
        heard = live.rows[-1].atoms[-1]["information"]
        assert (heard["worlds"], heard["held"]) == (first.worlds, first.held)
    live.undo(TEACHER)
    assert live.weigh(live.listed())[0].worlds == 256
    assert lesson(IDS[1], seat="teacher").weigh(listed) == []


@pytest.mark.parametrize("id", IDS)
def test_a_student_hears_what_an_agent_would(id):
    live, env = lesson(id, seat="student"), llf_teacher.make(id, text=True, max_turns=6)
    observation, _ = env.reset(seed=7)
    assert (live.rows[0].instruction, live.rows[0].feedback) == (observation["instruction"], observation["feedback"])
    for text in ("north", "no action at all", "0"):
        if not live.over:
            live.move(STUDENT, text)
            observation, reward, *_ = env.step(text)
            row = live.rows[-1]
            assert (row.observation, row.feedback) == (observation["observation"], observation["feedback"])
            assert row.reward == reward
    env.close()


def test_a_personality_may_speak_for_a_person():
    """Word for word as it does alone, where the person speaks; the same claims, where it chooses."""
    spec = lesson(seat="watch").plan.spec()
    alone = play(spec).turns
    words = to_the_end(lesson(seat="teacher", speech="own words"), TEACHER)
    assert tuple(words.rows) == alone
    chosen = to_the_end(lesson(seat="teacher", teacher="mistake(eps=0.5)"), TEACHER)
    other = play(spec._replace(teacher="mistake(eps=0.5)")).turns
    assert [row.atoms.count('"claim"') for row in chosen.rows] == [row.atoms.count('"claim"') for row in other]


def test_a_teacher_chooses_among_claims():
    live = lesson(seat="teacher")
    kinds = [claim.kind for claim in live.listed()]
    assert kinds == ["fp", "fn"]
    live.move(TEACHER, (1,))
    assert [atom.kind for atom in live.session.feedback.atoms] == ["fn"]
    with pytest.raises(ValueError, match="there is no claim 9; there are"):
        live.move(TEACHER, (0, 9))
    with pytest.raises(ValueError, match="chooses among claims; give their numbers"):
        live.move(TEACHER, "west")
    assert (live.session.moment.turn, len(live.rows)) == (1, 1)  # the student has acted, and nothing was said of it yet
    live.move(TEACHER, ())
    assert live.rows[-1].feedback == ""


def test_own_words_are_heard_and_not_counted_as_true():
    live = lesson(seat="teacher", speech="own words")
    live.move(TEACHER, "Try <b>west</b>.")
    assert live.rows[0].instruction == "Try <b>west</b>."
    live.move(TEACHER, "Good!")
    assert (live.rows[1].feedback, live.rows[1].atoms) == ("Good!", [])
    assert live.rows[0].atoms == []
    with pytest.raises(ValueError, match="speaks in its own words; give a text"):
        live.move(TEACHER, (0,))


def test_two_people_take_turns():
    live = lesson(seat="student", two=True)
    assert live.to_move == TEACHER
    with pytest.raises(ValueError, match="it is the turn of the other seat"):
        live.move(STUDENT, "west")
    live.move(TEACHER, (0,))
    with pytest.raises(ValueError, match="a seat can take back the last turn only if it is its own"):
        live.undo(STUDENT)
    live.move(STUDENT, "west")
    live.undo(STUDENT)
    assert live.to_move == STUDENT
    assert live.moves == [(TEACHER, (0,))]


@pytest.mark.parametrize(("seat", "who", "turn"), [("student", STUDENT, "west"), ("teacher", TEACHER, None)])
def test_what_is_taken_back_has_not_been(seat, who, turn):
    """Also if the student learns, and the teacher remembers."""
    settings = {"seat": seat, "teacher": "delayed(turns=1)", "student": "q_learning"}
    once, again = lesson(**settings), lesson(**settings)
    with pytest.raises(ValueError, match="there is no turn to take back"):
        again.undo(who)
    for _ in range(2):
        once.move(who, turn)
        again.move(who, turn)
    again.move(who, () if seat == "teacher" else "south")
    again.undo(who)
    assert again.undone == 1
    for live in (once, again):
        live.move(who, turn)
    assert once.rows == again.rows


def test_nothing_is_played_behind_the_end():
    live = to_the_end(lesson(seat="watch"), WATCHER)
    assert live.rows[-1].success or live.session.moment.turn == 6
    with pytest.raises(ValueError, match="the episode is over; begin a new one"):
        live.move(WATCHER, None)
    other = lesson(seat="watch")
    for ask in (other.check_over, other.record):
        with pytest.raises(ValueError, match="is not over; play it to its end first"):
            ask()


def test_a_students_picture_is_that_of_an_agent_until_the_end():
    live = lesson(seat="student")
    env = llf_teacher.make(GRID, text=True, max_turns=6, render_mode="rgb_array")
    env.reset(seed=7)
    for text in ("west", "north"):
        assert np.array_equal(live.renderer(STUDENT).frame(live.view.description()), env.render())
        live.move(STUDENT, text)
        env.step(text)
    assert not np.array_equal(live.renderer(TEACHER).frame(live.view.description()), env.render())
    assert {spoken.verdict for spoken in live.renderer(STUDENT).sentences} == {Label.UNCHECKED}
    assert live.renderer(TEACHER) is live.renderer(to_the_end(live, STUDENT, "west") and STUDENT)


def test_a_film_has_a_frame_of_each_turn():
    live = to_the_end(lesson(seat="teacher", max_turns=2), TEACHER)
    light, dark = frames(live.plan, live.inputs), frames(live.plan, live.inputs, "dark")
    assert len(light) == len(dark) == 3
    assert light[0].mean() > 2 * dark[0].mean()
    assert isinstance(live.view.renderer, EpisodeRenderer)


def test_people_are_in_studies(tmp_path):
    """Their episodes are in tables and reports as all others are; nobody else can play them."""
    teachers = [PersonTeaching(), "oracle"]
    people = Study(ids=[GRID], teachers=teachers, students=["llf_teacher.people:PersonLearning"], seeds=1)
    path = tmp_path / "people.db"
    with Store(path) as store:
        for seat in ("student", "teacher"):
            two = seat == "teacher"
            live = lesson(seat=seat, two=two, seed=0, max_turns=20)
            while not live.over:
                live.move(live.to_move, "west" if live.to_move == STUDENT else None)
            spec = live.plan.spec()
            assert spec in people.episodes()
            store.add(live.record())
    found = load(path)
    assert {row["student"] for row in found.rows()} == {str(people.students[0])}
    assert "llf_teacher.people:PersonTeaching" in found.report(people).html
    with pytest.raises(ValueError, match="is a person, whom no program can play"):
        play(spec)
    with pytest.raises(ValueError, match="the student is a person"):
        PersonLearning().act({}, {})
    with pytest.raises(ValueError, match="speech 'loud' is unknown; allowed: message, kinds, claims"):
        PersonTeaching(speech="loud")


@pytest.mark.parametrize(
    ("choices", "message"),
    [
        ({"id": "llf-gridword-v0"}, "llf-gridworld-v0"),
        ({"seat": "throne"}, "unknown seat 'throne'; allowed: student, teacher, watch"),
        ({"speech": "loud"}, "speech"),
        ({"two": "yes"}, "two must be true or false, got 'yes'"),
        ({"teacher": "os:system"}, "unknown teacher of this page 'os:system'; allowed: none; `llf serve --teacher os"),
        ({"teacher": "drifting(to='antigravity:x')"}, "unknown teacher of this page 'antigravity:x'"),
        ({"teacher": "x" * 301}, "teacher must be a text of at most 300 characters"),
        ({"student": "os:system('true')"}, "bad"),
        ({"student": "random | antigravity:x"}, "unknown student of this page 'antigravity:x'"),
        ({"student": "llm(model='m')"}, "student of this page 'llm'"),
        ({"student": "random | random"}, "unknown trait 'random'"),
        ({"max_turns": 201}, "max_turns must be a whole number from 1 to 200, got 201"),
        ({"max_turns": True}, "max_turns must be a whole number"),
        ({"seed": -1}, "seed must be a whole number from 0"),
        ({"seed": 0.5}, "seed must be a whole number from 0"),
        ({"seed": 10**30}, "seed must be a whole number from 0"),
        ({"teacher": ["oracle"]}, "teacher must be a text of at most 300 characters"),
        ({"instruction_type": "z"}, "instruction_types"),
        ({"feedback_type": "zz"}, "feedback_types"),
        ({"colour": "red"}, "unknown choice 'colour'"),
        ({"student": "q_learning", "id": "llf-optimization-Booth-v0", "seat": "watch"}, "needs discrete actions"),
    ],
)
def test_a_bad_choice_is_answered_by_a_sentence(choices, message):
    with pytest.raises(ValueError, match=r"(?s).*" + message.replace("(", r"\(")):
        lesson(**choices)


def test_students_that_may_cost_money_are_not_offered():
    assert "llm" not in students()
    assert {"obedient", "random", "reward_only"} <= set(students())
