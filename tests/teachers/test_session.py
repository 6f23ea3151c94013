"""A session: what a turn is, in which order, what is recorded of it, and how it is taken back."""

import copy
import pickle
from functools import partial

import numpy as np
import pytest

from pz_envs.family import all_families
from pz_envs.text.actions import read_text
from teachers.atoms import FN, FP, Atom, ParseFailure, Utterance
from teachers.budget import Budget
from teachers.common import Reward, TryAgain
from teachers.session import Session
from worlds.testing import plain

GRID, BANDIT = (next(f for f in all_families() if f.name == name) for name in ("gridworld", "bandits"))
FAMILIES = [family for family in all_families() if not family.slow]


def made(family=GRID, personalities=("oracle",), settings=None, **arguments):
    world = family.make_world(**family.environments[family.showcase[0]])
    teachers = [family.make_teacher(world, each, **(settings or {})) for each in personalities]
    return Session(world, teachers, **{"max_turns": 6, "repeated": family.repeated, **arguments})


def reading(**arguments):
    """A session whose student writes its actions."""
    session = made(**arguments)
    session.read = partial(read_text, world=session.world)
    return session


def played(session, actions):
    """The records of turns."""
    records = []
    for action in actions:
        if session.over:
            break
        session.act(action)
        session.speak()
        records.append(session.turn)
    return records


def test_an_episode_is_opened_spoken_of_and_acted_in():
    session = made(max_turns=20)
    opening = session.open(7)
    assert (opening.turn, opening.before, session.heard, session.done) == (0, None, False, False)
    session.speak()
    first = session.turn
    assert first.instruction == session.instruction != ""
    assert {atom.kind for atom in first.feedback.atoms} <= {"fp", "fn"}
    assert first.atoms == session.info["atoms"]
    while not session.done:
        moment = session.act(session.teacher.oracle.plan(session.moment.after, 1)[0])
        assert not session.heard
        session.speak()
        assert session.turn.moment == moment
        assert session.turn.instruction == ""
    assert session.moment.success
    assert not session.truncated


def test_a_record_does_not_change():
    session = made()
    session.open(1)
    session.speak()
    before = session.turn
    kept = repr(before)
    played(session, [0, 1])
    assert repr(before) == kept
    with pytest.raises(AttributeError):
        before.moment = None


def test_the_horizon_truncates_and_success_terminates_where_that_is_wanted():
    session = made(max_turns=2)
    session.open(3)
    session.speak()
    played(session, [0, 0])
    assert (session.terminated, session.truncated, session.over) == (False, True, True)
    session = made(BANDIT, until_success=True)
    session.open(3)
    session.speak()
    played(session, [session.world.truth.best[0]])
    assert session.moment.success
    assert not session.over, "a task that is repeated is not ended by success"


def test_a_text_that_is_no_action_counts_and_steps_nothing():
    """What is said of it is what was expected, and the same advice again."""
    session = reading(failure_reward=0.0)
    session.open(2)
    session.speak()
    before, advice = plain(session.world.save()), [atom.claim for atom in session.feedback.atoms if atom.kind is FP]
    session.act("whatever")
    session.speak()
    turn = session.turn
    assert plain(session.world.save()) == before
    assert type(turn.moment.action) is type(turn.info["parse_failure"]) is ParseFailure
    assert (turn.moment.turn, turn.moment.before) == (1, None)
    assert turn.atoms[0].kind is None
    assert [atom.claim for atom in turn.atoms if atom.kind is FP] == advice != []
    assert {atom.kind for atom in turn.atoms[1:]} == {FP, FN}


@pytest.mark.parametrize("action", [9, "north", None])
def test_what_is_no_action_changes_nothing(action):
    session = made()
    session.open(2)
    session.speak()
    before = repr(session.turn)
    with pytest.raises(ValueError, match="not in the action space"):
        session.act(action)
    assert repr(session.turn) == before


def test_a_question_is_answered_once_a_turn():
    session = made(ask_cost=0.25)
    session.open(4)
    session.speak()
    session.act(0)
    session.speak()
    assert session.ask() == -0.25
    session.speak()
    assert session.turn.asked
    assert {atom.kind for atom in session.turn.atoms} == {"fp", "fn"}
    assert session.moment.turn == 1
    with pytest.raises(ValueError, match="cannot ask: it has asked in this turn; let it act"):
        session.ask()
    session.act(0)
    assert not session.asked
    with pytest.raises(ValueError, match="cannot ask: there is no ask_cost"):
        made().ask()


def test_a_silent_teacher_answers_nothing():
    session = made(personalities=("silent",), ask_cost=0.25)
    session.open(4)
    session.speak()
    session.ask()
    session.speak()
    assert (session.feedback, session.atoms) == ("", ())


def test_several_teachers_are_heard_when_all_have_spoken():
    session = made(personalities=("only(kinds='fp')", "silent", "only(kinds='hn+hp')"), instructs=True)
    session.open(5)
    for teacher in (2, 0):
        session.say_kinds(31, teacher)
        assert not session.heard
    session.say("Look around.", 1)
    assert session.heard
    assert {atom.speaker for atom in session.feedback.atoms} == {"teacher_0"}
    assert str(session.feedback).endswith("Look around.")
    session.act(0)
    session.speak()
    assert {atom.speaker for atom in session.turn.atoms} <= {"teacher_0", "teacher_2"}


def test_each_teacher_pays_from_its_budget():
    budgets = [Budget(0.5, 1), Budget(0.25)]
    session = made(personalities=("oracle", "oracle"), budgets=budgets, instructs=True)
    session.open(6)
    assert session.say_kinds(np.int64(31), 0) == -0.5
    assert session.say(Utterance.of([Atom(Reward(reward=0.0), "Nothing.", 0)] * 2), 1) == -0.5
    assert [budget.spent for budget in budgets] == [1, 2]
    session.act(0)
    assert session.say_kinds(31, 0) == 0
    session.open(6)
    assert [budget.spent for budget in budgets] == [0, 0]


def test_words_without_atoms_cost_as_much_as_one_and_the_instruction_nothing():
    session = made(budgets=[Budget(0.01, 2)])
    session.open(0)
    assert session.say("Find the treasure, please.") == 0
    assert (session.instruction, session.feedback) == ("Find the treasure, please.", "")
    for said, heard, paid in (("One.", "One.", -0.01), ("", "", 0), ("Two.", "Two.", -0.01), ("Three.", "", 0)):
        session.act(0)
        assert (session.say(said), session.feedback) == (paid, heard)


def test_the_feedback_type_bounds_all_words_but_the_instruction():
    session = made(settings={"feedback_type": "hn"})
    session.open(2)
    session.say("Find the treasure.")
    session.act(0)
    session.say(Utterance.of([Atom(Reward(reward=0.0), "You get nothing.", 1), Atom(TryAgain(), "Try again.", 1)]))
    assert session.feedback == "Try again."
    session.act(0)
    session.say("Plain words are of no kind.")
    assert session.feedback == "Plain words are of no kind."
    mute = made(settings={"feedback_type": "n"})
    mute.open(2)
    mute.say("Find the treasure.")
    assert mute.instruction == "Find the treasure."
    mute.act(0)
    mute.say("Go on.")
    assert mute.feedback == ""


def test_an_episode_is_resumed_where_another_session_was():
    one, other = made(), made()
    one.open(3)
    one.speak()
    played(one, [0, 1])
    other.open(3)
    other.resume_from(one.moment)
    other.speak()
    assert [atom.claim for atom in other.atoms] == [atom.claim for atom in one.atoms]
    assert plain(other.state) == plain(one.state)
    assert [t.moment for t in played(other, [2])] == [t.moment for t in played(one, [2])]


def test_the_next_episode_keeps_what_was_spent():
    session = made(budgets=[Budget(0.1, 9)], instructs=True)
    session.open(3)
    session.say_kinds(31)
    start, spent = session.moment.after, session.teacher_turns[0].budget.spent
    session.act(0)
    session.start_next_episode(start)
    assert session.moment.after == start
    assert session.teacher_turns[0].budget.spent == spent > 0
    assert session.seeds.episode == 1


@pytest.mark.parametrize(
    ("speech", "said", "match"),
    [
        *(("say", each, "must say a string of at most 65536 characters") for each in (3, None, b"Go.", "x" * 70_000)),
        *(("say_kinds", each, "an integer from 0 to 31") for each in (-1, 32, 1.5, "31", None)),
        *(("choose", each, "an integer from 0 to 32") for each in (-1, 33, 0.5, "1", None)),
    ],
)
def test_what_cannot_be_said_changes_nothing(speech, said, match):
    session = made(instructs=True)
    session.open(1)
    with pytest.raises(ValueError, match=match):
        getattr(session, speech)(said)
    assert not session.heard


@pytest.mark.parametrize("copier", [copy.deepcopy, lambda session: pickle.loads(pickle.dumps(session))])
def test_copies_go_on_like_the_original(copier):
    session = made(personalities=("mistake(eps=0.5)",))
    session.open(2)
    session.speak()
    played(session, [0])
    twin = copier(session)
    assert repr(played(twin, [1, 2])) == repr(played(session, [1, 2]))


def test_advice_for_the_first_action_is_feedback():
    session = made(settings={"feedback_type": [FP]})
    session.open(1)
    session.speak()
    assert [atom.kind for atom in session.feedback.atoms] == [FP]
    assert not any(atom.kind for atom in session.instruction.atoms)


@pytest.mark.parametrize("instructs", [False, True])
@pytest.mark.parametrize("speech", ["say_kinds", "choose"])
def test_teachers_may_choose_at_the_opening_however_the_instruction_is_given(speech, instructs):
    session = made(instructs=instructs)
    session.open(1)
    getattr(session, speech)(1)
    assert session.suggest()


def test_own_words_keep_a_personality_up_to_date():
    session = made(personalities=("delayed(turns=1)",), instructs=True, ask_cost=0.1)
    session.open(1)
    session.say("Hello.")
    session.act(0)
    session.say("Hm.")
    session.ask()
    session.speak()
    assert session.turn.asked


def test_each_teacher_speaks_once_a_turn_and_the_student_after_them():
    session = made(personalities=("oracle", "oracle"), instructs=True, ask_cost=0.1, max_turns=1)
    with pytest.raises(ValueError, match="the student cannot ask now: the teachers have yet to speak"):
        session.ask()
    session.open(1)
    session.say("One.", 0)
    with pytest.raises(ValueError, match="the teacher has spoken of this moment"):
        session.say("Two.", 0)
    with pytest.raises(ValueError, match="teacher must be a number from 0 to 1, got -1"):
        session.say("Two.", -1)
    session.say("Two.", 1)
    assert session.heard
    session.act(0)
    with pytest.raises(ValueError, match="the episode has ended; open another one"):
        session.act(0)


def test_an_action_whose_world_fails_was_not_and_arrays_are_kept_as_they_were(monkeypatch):
    family = next(family for family in FAMILIES if family.name == "optimization")
    session = made(family)
    session.open(1)
    session.speak()
    action, records, kept = np.array([0.5, 0.5], np.float32), [], []
    for step in (0.1, 0.2):
        action += np.float32(step)
        records += played(session, [action])
        kept.append(repr(records[-1]))

    def fail(action):
        raise RuntimeError("the simulator")

    with monkeypatch.context() as patch:
        patch.setattr(session.world, "advance", fail)
        with pytest.raises(RuntimeError, match="the simulator"):
            session.act(action)
    assert repr(session.turn) == kept[-1]
    action += np.float32(0.1)
    played(session, [action])
    assert [repr(record) for record in records] == kept


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        ({"max_turns": 0}, "max_turns must be an integer of at least 1, got 0"),
        ({"budgets": [Budget(), Budget()]}, "budgets must be one for each of 1 teachers, got 2"),
    ],
)
def test_arguments_are_checked(arguments, match):
    with pytest.raises(ValueError, match=match):
        made(**arguments)
