"""A lesson with people in its seats: a turn that is taken back has not been."""

import itertools

import numpy as np
import pytest

from llf_teacher.episodes.live import LiveLesson
from llf_teacher.registry import entries, entry
from llf_teacher.students.parsing import parse_student
from pz_envs.family import all_families
from pz_envs.seats import STUDENT, TEACHER
from pz_envs.settings import Settings

GRID, BOOTH = "llf-gridworld-v0", "llf-optimization-Booth-v0"
FAST = [family.name for family in all_families() if not family.slow]
IDS = {each.family.name: id for id, each in reversed(entries().items()) if each.family.name in FAST}


def lesson(people, id=GRID, student=None, **settings):
    settings = Settings(**{"text": False, "max_turns": 6, "render_mode": "ansi", **settings})
    return LiveLesson(entry(id), settings, 8, frozenset(people), student and parse_student(student))


@pytest.mark.parametrize("id", IDS.values())
@pytest.mark.parametrize("teacher", ["oracle", "mistake(eps=0.5) | delayed(turns=1)", "misaligned"])
def test_a_turn_that_is_taken_back_has_not_been(id, teacher):
    def fresh():
        return lesson({STUDENT}, id, teacher=teacher)

    def played(live, actions):
        for action in actions:
            live.move(STUDENT, action)
        return live

    rng = np.random.default_rng(0)
    one = fresh()
    actions = [one.session.world.sample_action(rng) for _ in range(4)]
    first = []  # as long as the episode lasts
    for action in actions[:2]:
        if not played(fresh(), [*first, action]).over:
            first.append(action)
    kept = repr(played(one, first).session.turn)
    one.move(STUDENT, actions[2])
    one.undo(STUDENT)
    assert repr(one.session.turn) == kept
    one.move(STUDENT, actions[3])
    assert one.rows == played(fresh(), [*first, actions[3]]).rows


@pytest.mark.parametrize(("speech", "words"), [("message", "Well done."), ("kinds", 31), ("claims", (0,))])
def test_what_teachers_said_is_taken_back_with_what_came_after(speech, words):
    """What the teacher was asked for is asked again, though the words of a suggestion are drawn anew for kinds."""
    live = lesson({STUDENT, TEACHER}, speech=speech)
    live.move(TEACHER, None if speech != "kinds" else 31)
    live.move(STUDENT, 1)
    suggested, sentences = str(live.suggestion()), live.sentences()
    live.move(TEACHER, words)
    heard = live.rows[-1]
    live.move(STUDENT, 2)
    live.suggestion()
    live.undo(STUDENT)
    assert (live.session.moment.turn, live.session.heard, live.rows[-1]) == (1, True, heard)
    assert repr(live.session.feedback) == repr(heard.feedback)
    live.undo(TEACHER)
    assert (live.session.moment.turn, live.session.heard, len(live.rows)) == (1, False, 1)
    assert (str(live.suggestion()), live.sentences()) == (suggested, sentences)
    live.move(TEACHER, words)
    assert live.rows[-1] == heard
    for seat in (TEACHER, STUDENT, TEACHER):
        live.undo(seat)
    assert (live.session.moment.turn, live.session.heard, live.rows) == (0, False, [])
    with pytest.raises(ValueError, match="there is no turn to take back"):
        live.undo(TEACHER)


@pytest.mark.parametrize("action", [9, "north", None])
def test_what_is_no_action_changes_nothing(action):
    live = lesson({STUDENT})
    before = repr(live.session.turn)
    with pytest.raises(ValueError, match="not in the action space"):
        live.move(STUDENT, action)
    assert repr(live.session.turn) == before
    with pytest.raises(ValueError, match="there is no turn to take back"):
        live.undo(STUDENT)


def test_an_action_whose_world_fails_was_not_and_arrays_are_kept_as_they_were(monkeypatch):
    live = lesson({STUDENT}, BOOTH)
    action, records = np.array([0.5, 0.5], np.float32), []
    for step in (0.1, 0.2):
        action += np.float32(step)
        live.move(STUDENT, action)
        records.append(repr(live.session.turn))

    def fail(action):
        raise RuntimeError("the simulator")

    with monkeypatch.context() as patch:
        patch.setattr(live.session.world, "advance", fail)
        with pytest.raises(RuntimeError, match="the simulator"):
            live.move(STUDENT, action)
    live.undo(STUDENT)
    assert repr(live.session.turn) == records[0]
    assert len(live.rows) == 2


class Restless:
    """A student that never does the same again, as a model may."""

    def __init__(self):
        self._actions = itertools.count()
        self.lived = []

    def reset(self, rng):
        self.lived = []

    def act(self, observation, info):
        self.lived.append(observation["feedback"])
        return next(self._actions) % 4

    def record(self):
        return {}


def test_a_student_lives_through_what_it_did_again(monkeypatch):
    """Its actions are those that it took, also if it would take others now."""
    live = lesson({TEACHER}, student="obedient", speech="claims")
    live._policy = policy = Restless()
    for _ in range(3):
        live.move(TEACHER, None)
    rows, lived = live.rows[:], policy.lived[:]
    live.undo(TEACHER)
    assert live.rows == rows[:2]
    assert policy.lived == lived[:2]
    assert live.session.moment.action == 1  # of the second turn, of which nothing was said yet


def test_an_answer_that_is_taken_back_leaves_the_turn_that_was_heard():
    def asked():
        live = lesson({STUDENT, TEACHER}, text=True, ask_cost=0.05, speech="claims")
        live.move(TEACHER, None)
        live.move(STUDENT, "ask")
        return live

    live = asked()
    live.move(TEACHER, None)
    live.undo(TEACHER)
    assert live.rows == asked().rows != []


def test_what_claims_say_is_measured_as_if_nothing_had_been_taken_back():
    def played(actions):
        settings = Settings(teacher="oracle", text=False, render_mode="ansi", max_turns=6)
        live = LiveLesson(
            entry("llf-bandits-BanditTenArmedRandomFixed-v0"), settings, 3, frozenset({STUDENT}), None, 64
        )
        for action in actions:
            live.move(STUDENT, action)
        return live

    live = played([2, 8, 3])
    for _ in range(2):
        live.undo(STUDENT)
    for action in (5, 5):
        live.move(STUDENT, action)
    assert live.rows == played([2, 5, 5]).rows
    assert any("information" in atom for row in live.rows for atom in row.atoms)
