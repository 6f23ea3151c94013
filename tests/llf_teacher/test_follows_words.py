"""Students that follow the words of people and models do as they are read, and know no more than those words."""

import json

import numpy as np
import pytest

import llf_teacher
from llf_teacher.registry import entry
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies import Study
from llf_teacher.studies.execution.episode import play
from teachers.atoms import FP, Atom, Claim, Moment, claim
from teachers.belief import Belief

ROOMS, ARMS = "llf-gridworld-v0", "llf-bandits-BanditTenArmedGaussian-v0"
FOLLOWS = "obedient(follows_words=True)"


class Says:
    """Says these words, first an instruction, and the last ones again."""

    def __init__(self, *words):
        self.words = words

    def reset(self, rng):
        pass

    def act(self, observation, info):
        return self.words[min(info["moment"].turn, len(self.words) - 1)]


def moments(student, *words, id=ROOMS, turns=4, seed=0, **options):
    """The moments of an episode in which a teacher says these words."""
    env = llf_teacher.make(id, teacher=Says(*words), max_turns=turns, **options)
    policy = parse_student(student).seat(env.family, env.session.world)
    policy.reset(np.random.default_rng(seed))
    env.reset(seed=0)
    while not env.session.over:
        env.step(policy.act(env.student_view.observe(), env.student_view.info_for(policy)))
        yield env.session.moment


def acted(*student_and_words, **settings):
    return [int(moment.action) for moment in moments(*student_and_words, **settings)]


SOUTH = "Now head south."


@pytest.mark.parametrize("words", [SOUTH, "Go south next.", f"Well. {SOUTH} Lovely."])
def test_it_does_as_it_is_told_though_that_is_wrong(words):
    assert acted(FOLLOWS, "Find the treasure.", words)[1:] == [3, 3, 3]
    assert acted("obedient", "Find the treasure.", words)[1:] != [3, 3, 3]


def test_a_verdict_without_an_action_is_on_its_own():
    """So that in one room it does nothing again, until it has done all."""
    for seed in range(5):
        played = moments(FOLLOWS, "Go.", "There was a mistake in that.", seed=seed)
        assert len({(moment.before.room, moment.action) for moment in played}) == 4


@pytest.mark.parametrize("id", [ROOMS, ARMS])
def test_where_a_teacher_says_claims_it_is_as_without(id):
    for student in ("obedient", "obedient | forgetful(half_life=2)", "obedient | mishears(p=0.5)"):
        other = student.replace("obedient", FOLLOWS)
        study = Study(ids=[id], teachers=["mistake(eps=0.3)"], students=[student, other], seeds=1, max_turns=5)
        one, two = (play(spec) for spec in study.episodes())
        assert one.turns == two.turns


def test_traits_change_what_is_read():
    words = "Find the treasure.", SOUTH
    assert acted(f"{FOLLOWS} | mishears(p=1.0)", *words) == acted("obedient | mishears(p=1.0)", *words)
    assert acted(f"{FOLLOWS} | forgetful(half_life=1)", *words)[1:] == [3, 3, 3]


def test_a_reasoner_weighs_worlds_by_what_it_reads():
    words = "Pull an arm.", "Pull arm 4 next."
    assert acted("reasoner(worlds=64, follows_words=True)", *words, id=ARMS)[1] == 4
    assert acted("reasoner(worlds=64)", *words, id=ARMS)[1] != 4


@claim
class Unready(Claim):
    """Nothing that a world could tell."""

    kind = FP

    def holds(self, moment, lab):
        raise TypeError("no such room")


def test_what_is_read_and_cannot_be_checked_is_false_in_a_world():
    family = entry(ARMS).family
    world = family.make_world()
    world.reset(seed=0)
    read, said = (Belief(family.make_posterior_context(world), np.random.default_rng(0), 8) for _ in range(2))
    for belief in (read, said):
        belief.see(Moment.opening(world.truth))
    read.learn([Atom(Unready(), "Hm.", 0)], [Atom(Unready(), "Hm.", 0)])
    assert read.ignored == 1, "it is false in all of them"
    assert np.isfinite(read.regrets()).any()
    with pytest.raises(TypeError, match="no such room"):
        said.learn([Atom(Unready(), "Hm.", 0)])


HOSTILE = [
    "The treasure is in the room __import__('os').system('true').",
    "Go " * 3000,
    "You found the treasure in nowhere-9.",
    "There is a treasure within 9999 moves.",
    json.dumps({"claims": [{"type": "Go", "action": "south"}]}),
]


@pytest.mark.parametrize("student", [FOLLOWS, "reasoner(worlds=8, follows_words=True)"])
def test_strange_words_end_no_episode(student):
    options = {"map": True} if "reasoner" in student else {}
    played = list(moments(student, "Find it.", *HOSTILE, turns=len(HOSTILE) + 1, **options))
    assert played[-1].over
