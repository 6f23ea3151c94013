"""The best times to advise: the students are those of the environments, and no choice of times is better."""

import itertools
import math
from collections import Counter

import numpy as np
import pytest

from llf_teacher.gym import TeacherEnv
from llf_teacher.registry import entry
from llf_teacher.reproductions.optimum import Life, Span, least, lived
from llf_teacher.reproductions.rows import optimum
from llf_teacher.reproductions.rows.optimum import house_of
from llf_teacher.students.builtin.q_learning import QLearning
from worlds.gridworld import Gridworld

ADVICE = 0b01000


class InTurn:
    """In place of a generator: who draws for the n-th time in a room gets n, beginning with 0."""

    def __init__(self, learner):
        self.learner, self.times = learner, Counter()

    def integers(self, count):
        room = id(self.learner._here)
        self.times[room] += 1
        return (self.times[room] - 1) % count


class Settled:
    """A learner that goes through equal values in turn."""

    reads = "atoms and reward"

    def __init__(self, learner):
        self.learner, self.turns = learner, InTurn(learner)

    def __getattr__(self, name):
        return getattr(self.learner, name)

    def reset(self, rng):
        self.learner.reset(self.turns)


@pytest.mark.parametrize("optimism", [0.0, 1.0])
@pytest.mark.parametrize("seed", range(3))
def test_a_life_is_that_of_the_environment(seed, optimism):
    house = {"num_rooms": 6, "min_goal_dist": 3}
    family, episodes, turns = entry("llf-gridworld-v0").family, 6, 12
    learner = QLearning(trust=1.0, forget=False, optimism=optimism, epsilon=0.0)
    env = TeacherEnv(
        "llf-gridworld-v0",
        student=lambda _: Settled(learner.seat(family, family.make_world(**house))),
        episodes=episodes,
        max_turns=turns,
        feedback_type="fp",
        cost=0.0,
        teacher_reward="student_progress",
        **house,
    )
    env.reset(seed=seed)
    life = Life(house_of(env.session.world.truth), Span(episodes, turns, optimism))
    rng, done = np.random.default_rng(seed), False
    while not done:
        advised = bool(rng.random() < 0.2) and not env.session.moment.over
        over, room, before = env.session.moment.over, env.session.world.truth.room, life.lost
        if not over:
            assert room == life.room
            life.go(life.house.advice[room] if advised else life.meant(), advised=advised)
        _, reward, terminated, truncated, _ = env.step(ADVICE if advised else 0)
        assert life.lost - before == -reward
        done = terminated or truncated
    env.close()
    assert life.over
    assert life.lost > 0


def life_of(seed, optimism, episodes=3, turns=6):
    world = Gridworld(num_rooms=5, min_goal_dist=2)
    world.reset(seed=seed)
    return Life(house_of(world.truth), Span(episodes, turns, optimism))


@pytest.mark.parametrize("optimism", [0.0, 1.0])
@pytest.mark.parametrize("seed", range(4))
def test_no_choice_of_times_is_better(seed, optimism):
    """Beside all pairs of moves at which advice could be given."""
    life = life_of(seed, optimism)
    ends = []
    for times in itertools.combinations(range(18), 2):
        ends.append(lived(life, lambda now, times=times: now.moves in times, 2))
    for cost in (lambda end: end.lost, lambda end: end.settled):
        assert least(life, cost, 2) == min(map(cost, [*ends, lived(life, lambda now: False, 0)]))
    assert life.moves == 0


def test_what_is_known_is_the_most_that_it_costs():
    life = life_of(1, 0.0)
    best = least(life, lambda end: end.lost, 1)
    assert 0 < best < lived(life, lambda now: False, 0).lost
    assert least(life, lambda end: end.lost, 1, best) == best
    assert least(life, lambda end: end.lost, 1, best - 1) == best - 1


@pytest.mark.parametrize("seed", range(20))
def test_who_is_led_one_way_is_taught_in_its_square(seed):
    life = life_of(seed, 0.0, episodes=8, turns=20)
    way = life.house.distance[life.room]
    led = lived(life, lambda now: now.meant() != now.house.advice[now.room], math.inf)
    assert led.lost == 0
    assert led.settled <= way**2
    assert led.said <= way * (way + 1) / 2
    assert least(life, lambda end: end.lost, led.said, led.lost + 1) == 0


def test_a_measurement_in_order():
    """Of early, importance, announced mistake, near mistakes, the optimum; then what it takes to teach."""
    case = optimum.CASES["6 rooms, undecided"]
    none, two = (
        dict(zip(optimum.MEASURES, optimum.measure(**optimum._setting(case, budget), seed=3), strict=True))
        for budget in (0, 2)
    )
    assert len({none[teacher] for teacher in optimum.TEACHERS}) == 1
    assert all(two["optimum"] <= two[teacher] for teacher in optimum.TEACHERS)
    assert two["optimum"] < none["optimum"]
    assert two[optimum.TAUGHT] < none[optimum.TAUGHT]
    assert all(none[each] == two[each] for each in (optimum.MOVES, optimum.ADVICE, optimum.WAY))
