"""Teachers who learn when to correct: what they see, that they are paid rightly, and that they learn."""

import numpy as np
import pytest

from llf_teacher.reproductions.advisers import Choices, Lessons, seen, trained
from llf_teacher.reproductions.rows import learned

ID = "llf-gridworld-v0"
TERMS = {"episodes": 5, "turns": 20, "budget": 2, "num_rooms": 6, "min_goal_dist": 3}


def test_corrected_is_what_was_announced():
    """As long as there is advice no mistake is made by who corrects all; lifetimes that have ended ask for nothing."""
    lessons = Lessons(ID, range(20), **{**TERMS, "budget": 10_000})
    decisions = 0
    while not lessons.over:
        decisions += len(lessons.rows)
        lessons.step(np.ones(len(lessons.rows), bool))
    assert decisions > 20
    assert not lessons.lost.any()
    assert not len(lessons.rows)
    lessons.close()


def test_no_more_is_said_than_there_is():
    said = np.zeros(20)
    lessons = Lessons(ID, range(20), **TERMS)
    while not lessons.over:
        np.add.at(said, lessons.rows, 1)
        assert ((lessons.choices.left > 0) & (lessons.choices.way > 0)).all()
        lessons.step(np.ones(len(lessons.rows), bool))
    assert said.max() == 2
    lessons.close()


def test_what_is_seen():
    choices = Choices(*np.array([[4.0, 12.0], [2.0, 1.0], [0.25, 1.0], [0.5, 0.0]]))
    known = seen(choices)
    assert known[:, :4].tolist() == [[1, 0, 0, 0], [1, 0.5, 1, -1]]
    assert known[1, 4:].tolist() == [0.25, 0.5, -0.5, 1, -1, 1]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_it_does_what_it_is_paid_for(sign):
    """Paid for near mistakes and fined for far ones, or the other way round."""
    policy = trained(ID, lambda choices: sign * np.where(choices.way <= 2, 1.0, -1.0), 0, rounds=2, rows=64, **TERMS)
    near, far = Choices(*np.array([[1.0], [2.0], [0.5], [1.0]])), Choices(*np.array([[5.0], [2.0], [0.5], [1.0]]))
    assert (policy(near)[0], policy(far)[0]) == (sign > 0, sign < 0)


def test_a_training_can_be_had_again():
    choices = Choices(*np.random.default_rng(0).random((4, 200)))
    first, again, other = (trained(ID, None, number, rounds=1, rows=32, **TERMS)(choices) for number in (0, 0, 1))
    assert first.tolist() == again.tolist() != other.tolist()


def test_the_worth_of_an_action():
    choices = Choices(*np.array([[1.0, 5.0], [2.0, 1.0], [0.0, 0.0], [1.0, 1.0]]))
    assert learned._value(choices) == pytest.approx([1 - 0.95**2, 0.95**4 - 0.95**5])
