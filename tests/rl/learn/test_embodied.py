"""The known result whose measurement needs torch: a model that learns from lessons in words."""

import numpy as np
import pytest
import torch

from llf_teacher.reproductions.household import Sentences, blundering, play
from llf_teacher.reproductions.row import FIRST_SEED, all_rows
from llf_teacher.reproductions.rows import embodied
from llf_teacher.reproductions.rows.embodied import house
from llf_teacher.reproductions.sequence import SequenceModel

TASK = {"task": "pick_and_place_simple", "max_turns": 20}


def trained(kinds, lessons, epochs, seed=0):
    env, errs = house(kinds, "plain", Sentences(False, None), **TASK), np.random.default_rng(seed)
    errands = [play([(env, i)], blundering(env, 0.3, errs))[0] for i in range(lessons)]
    model = SequenceModel(np.random.default_rng(seed))
    model.learn(errands, epochs)
    return model


def score(model, kinds, tests=20):
    """In other houses, in the words of the lessons."""
    houses = [(house(kinds, "plain", Sentences(False, None), **TASK), 1000 + i) for i in range(tests)]
    return np.mean([errand.score for errand in play(houses, model.player())])


def test_a_model_learns_to_do_what_it_hears():
    """And not from what it does not hear."""
    model = trained("fp", 150, 4)
    assert score(model, "fp") > 0.35
    assert score(model, "n") < 0.15


def test_the_row_measures_the_same_twice(monkeypatch):
    monkeypatch.setattr(embodied, "EPISODES", 24)
    monkeypatch.setattr(embodied, "TESTS", 4)
    before = torch.get_rng_state(), np.random.get_state()[1].tolist()  # noqa: NPY002 (to see that nobody draws from it)
    row = all_rows()["embodied"]
    first, again = (row.measure(**row.settings[-1], seed=FIRST_SEED) for _ in range(2))
    assert first == again
    assert len(first) == len(row.measures)
    assert all(0 <= each <= 1 for each in first)
    assert torch.equal(before[0], torch.get_rng_state())
    assert before[1] == np.random.get_state()[1].tolist()  # noqa: NPY002 (as above)


def test_a_player_remembers_each_errand_by_itself():
    """Side by side errands end as they do alone."""
    model = trained("fp", 20, 1)
    houses = [(house("fp", "plain", Sentences(False, None), **TASK), 2000 + i) for i in range(3)]
    together = play(houses, model.player())
    alone = [play([each], model.player())[0] for each in houses]
    assert [errand.turns for errand in together] == [errand.turns for errand in alone]


@pytest.mark.parametrize("teacher", embodied.TEACHERS.values())
def test_the_teachers_of_the_test_speak(teacher):
    env = house("hp+hn+fp", embodied.TEST_VOICE, Sentences(True, np.random.default_rng(0)), teacher, **TASK)
    (errand,) = play([(env, 5)], blundering(env, 0.9, np.random.default_rng(0)))
    heard = sum(bool(turn.heard) for turn in errand.turns) / len(errand.turns)
    assert (heard == 1, heard == 0) == (teacher == "oracle", teacher == "silent")
