"""Names for loops of one's own, and what was trained by numbers in the scalar game and in studies."""

import sys
from dataclasses import dataclass, field

import numpy as np
import pettingzoo
import pytest
from gymnasium.error import ResetNeeded

import llf_teacher
from llf_teacher.registry import PREFIX
from llf_teacher.studies import run
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from pz_envs.family import all_families
from teachers.atoms import FP, Moment
from teachers.feedback import SUBSETS
from teachers.numeric import ChoosesKinds
from worlds.testing import plain

GRID, ARMS = "llf-gridworld-v0", "llf-bandits-BanditTenArmedRandomFixed-v0"
MODULE = """
from dataclasses import dataclass

from teachers.numeric import ChoosesKinds

SEEN = []


class Follower:
    def act(self, numbers):
        SEEN.append(numbers)
        return int(numbers[54:58].argmax())


class Lacking:
    def act(self, numbers):
        return 0


def made():
    return Lacking()


@dataclass(frozen=True)
class Important(ChoosesKinds):
    def choose(self, numbers):
        return 0b01000 if numbers[7] > 1.5 else 0
"""


@pytest.fixture
def mine(tmp_path, monkeypatch):
    (tmp_path / "by_numbers.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    yield __import__("by_numbers")
    del sys.modules["by_numbers"]


def test_an_agent_by_numbers_sees_the_array_and_plays_in_studies(mine, tmp_path):
    study = Study(ids=[GRID], teachers=["only(kinds='fp')", "by_numbers:Important"], students=[mine.Follower], seeds=2)
    with run(study, tmp_path / "study.sqlite", workers=1) as results:
        said = {(row["teacher"], row["seed"]): (row["claims"], sum(row["regrets"])) for row in results.rows()}
    assert said["only(kinds='fp')", 0][1] == 0
    assert all(0 < said["by_numbers:Important", seed][0] <= said["only(kinds='fp')", seed][0] for seed in (0, 1))
    env = llf_teacher.StudentEnv(GRID, numbers=True, teacher="only(kinds='fp')")
    seen = [env.reset(seed=0)[0]]
    for _ in range(3):
        seen.append(env.step(int(seen[-1][54:58].argmax()))[0])
    np.testing.assert_array_equal(mine.SEEN[:4], seen)


def test_an_agent_by_numbers_from_a_function_says_what_it_reads(mine):
    study = Study(ids=[GRID], teachers=["oracle"], students=["by_numbers:made"], seeds=1)
    with pytest.raises(ValueError, match=r"act\(numbers\) needs atoms; set `reads = 'atoms'` on the factory"):
        play(next(iter(study.episodes())))


def test_a_teacher_by_numbers_says_what_it_would_in_the_teachers_seat(mine):
    teacher = mine.Important()
    seat = llf_teacher.TeacherEnv(GRID, student="obedient", teacher_numbers=True)
    env = llf_teacher.make(GRID, teacher=teacher)
    for seed in range(3):
        numbers, _ = seat.reset(seed=seed)
        env.reset(seed=seed)
        student = env.seat("obedient")
        student.reset(env.session.seeds.stream("student"))
        done = False
        while not done:
            spoke = bool(teacher.choose(numbers))
            assert spoke == any(atom.kind is FP for atom in env.session.atoms)
            numbers, _, terminated, truncated, _ = seat.step(teacher.choose(numbers))
            done = terminated or truncated
            if not done:
                env.step(student.act(*env.seen_by(student)))
                assert env.moment.action == seat.moment.action


@dataclass(frozen=True)
class Noted(ChoosesKinds):
    """Notes what it sees, and says some of it."""

    seen: list = field(default_factory=list)

    def choose(self, numbers):
        self.seen.append(numbers)
        return some_of(numbers)


def some_of(numbers):
    return int(1000 * np.abs(numbers).sum()) % SUBSETS


@pytest.mark.parametrize("settings", [{"budget": 4}, {"max_turns": 3}])
@pytest.mark.parametrize(
    "family",
    [each for each in all_families() if "importance" in each.oracle_class().abilities()],
    ids=lambda family: family.name,
)
def test_a_teacher_by_numbers_sees_what_the_seat_observes(family, settings):
    """In each turn, with the lesson's own horizon, and what is left of a budget."""
    id, teacher = PREFIX + family.showcase[0], Noted()
    seat = llf_teacher.TeacherEnv(id, student="obedient", teacher_numbers=True, **settings)
    env = llf_teacher.make(id, teacher=teacher, **settings)
    numbers, _ = seat.reset(seed=4)
    env.reset(seed=4)
    student = env.seat("obedient")
    student.reset(env.session.seeds.stream("student"))
    for turn in range(4):
        assert len(teacher.seen) == turn + 1
        np.testing.assert_array_equal(teacher.seen[-1], numbers)
        assert teacher.seen[-1].dtype == numbers.dtype
        numbers, _, terminated, truncated, _ = seat.step(some_of(numbers))
        if terminated or truncated:
            break
        env.step(student.act(*env.seen_by(student)))
    assert turn == 3


def test_a_teacher_by_numbers_sees_that_the_student_asks():
    seat = pettingzoo.make("aec", "llf/gridworld-v0", speech="kinds", teacher_numbers=True, ask_cost=0.1)
    seat.reset(seed=1)
    teacher = Noted()
    env = llf_teacher.make(GRID, teacher=teacher, ask_cost=0.1)
    env.reset(seed=1)
    seat.step(some_of(seat.observe("teacher_0")))
    seat.unwrapped.session.ask()
    env.session.ask()
    env.session.speak()
    np.testing.assert_array_equal(teacher.seen[-1], seat.unwrapped.observe("teacher_0"))
    assert teacher.seen[-1][0] == 1


def test_a_teacher_by_numbers_needs_a_lesson():
    teacher = all_families()[0].make_teacher(all_families()[0].taught_world(), Noted())
    teacher.reset(np.random.default_rng(0))
    world = teacher.oracle.lab
    world.reset(seed=0)
    with pytest.raises(ValueError, match="needs a lesson, whose turns are known"):
        teacher.speak(Moment.opening(world.truth))


def test_another_episode_begins_where_it_is_told_and_spends_the_same_budget():
    env = llf_teacher.make(GRID, budget=3, feedback_type="fp")
    with pytest.raises(ResetNeeded, match="call reset"):
        env.start_next_episode()
    observation, _ = env.reset(seed=3)
    start = env.moment.after
    env.step(0)
    again, info = env.start_next_episode(start)
    assert plain(again["observation"]) == plain(observation["observation"])
    assert env.moment.turn == 0
    assert [atom.kind for atom in info["atoms"] if atom.kind] == [FP]
    env.start_next_episode(start)
    assert not env.session.feedback  # three pieces are spent


def test_values_and_what_a_policy_may_see():
    env = llf_teacher.make(GRID, until_success=True)
    env.reset(seed=1)
    policy = env.seat("oracle")
    policy.reset(np.random.default_rng(0))
    while (values := env.values()) is not None:
        observation, info = env.seen_by(policy)
        assert ("moment" in info, set(observation)) == (True, {"state", "instruction", "feedback"})
        assert "moment" not in env.seen_by(env.seat("obedient"))[1]
        action = policy.act(observation, info)
        assert values[action] == max(values)
        env.step(action)
    assert env.moment.success


def test_what_has_no_values_has_none():
    env = llf_teacher.make("llf-poem-Haiku-v0")
    env.reset(seed=1)
    assert env.values() is None


def test_a_personality_must_choose():
    @dataclass(frozen=True)
    class Idle(ChoosesKinds):
        pass

    with pytest.raises(TypeError, match="abstract"):
        Idle()
