"""Lifetimes in PettingZoo's forms: who learns keeps it, budgets last, endings are told once, who has ended waits."""

import numpy as np
import pettingzoo
import pytest
from playing import agents, episode

import llf_teacher
from llf_teacher.students.parsing import parse_student
from pz_envs.family import all_families
from pz_envs.parallel_seats import ParallelSeats
from pz_envs.seats import STUDENT, TEACHER
from pz_envs.testing import require_aec, require_parallel
from worlds.testing import plain

GRID, BANDIT = (next(f for f in all_families() if f.name == name) for name in ("gridworld", "bandits"))
SEATINGS = {"tutoring": {}, "classroom": {"students": 3}, "panel": {}}
LEARNER = "q_learning(trust=1.0, forget=False, optimism=0.0, epsilon=0.1)"
ADVICE = 0b01000


def seats(env, spec):
    """The students' policies."""
    bare = env.unwrapped
    session = bare.sessions[0] if hasattr(bare, "sessions") else bare.session
    students = [agent for agent in env.possible_agents if agent.startswith("student")]
    return {agent: parse_student(spec).seat(GRID, session.world) for agent in students}


def speak(observation):
    return int(np.flatnonzero(observation["action_mask"])[-1])


def all_is_said(agent, observation):
    return speak(observation) if agent.startswith("teacher") else 0


@pytest.mark.parametrize("speech", ["kinds", "claims", "message"])
@pytest.mark.parametrize("asking", [{}, {"ask_cost": 0.1}])
@pytest.mark.parametrize("seating", SEATINGS)
@pytest.mark.parametrize("name", ["gridworld", "bandits-BanditTenArmedRandomFixed"])
def test_pettingzoo_accepts_it(name, seating, asking, speech):
    id = f"llf/{name}-v0" if seating == "tutoring" else f"llf/{name}-{seating}-v0"
    settings = {"episodes": 3, "max_cycles": 4, **SEATINGS[seating], **asking}
    require_aec(lambda: pettingzoo.make("aec", id, speech=speech, **settings))
    if speech == "kinds":
        require_parallel(lambda: pettingzoo.make("parallel", id, speech=speech, **settings))


@pytest.mark.parametrize("seating", SEATINGS)
def test_each_episode_begins_alike_and_its_end_is_told_once(seating):
    env = GRID.raw_env(seating=seating, speech="kinds", episodes=4, max_cycles=3, **SEATINGS[seating])
    students = [agent for agent in env.possible_agents if agent.startswith("student")]
    starts, told, shares = dict.fromkeys(students, ()), dict.fromkeys(students, 0), []
    for agent, dead, observation, _, info in agents(env, all_is_said, seed=7):
        if not dead and agent in students:
            if env.moment_of(agent).turn == 0:
                starts[agent] += (plain(env.moment_of(agent).after),)
                if env.episode:
                    assert not info["final_terminated"]  # three moves to the right find nothing here
                    assert "state" in info["final_obs"]
                    assert "atoms" in info["final_info"]
            told[agent] += "final_obs" in info
        elif not dead:
            shares.append(float(observation["episode"][0]))
    assert all(len(each) == 4 and len(set(map(str, each))) == 1 for each in starts.values())
    assert set(told.values()) == {3}
    assert sorted(set(shares)) == [0, 0.25, 0.5, 0.75]
    assert shares == sorted(shares)


def test_a_budget_is_that_of_the_lifetime():
    for seating, more in SEATINGS.items():
        env = GRID.raw_env(seating=seating, speech="kinds", episodes=3, max_cycles=4, budget=6, **more)
        spent = [_budget(env).spent for _ in agents(env, all_is_said, seed=1)]
        assert spent == sorted(spent), seating
        assert spent[-1] == 6, seating


def _budget(env):
    inner = env.unwrapped
    return inner.budget if hasattr(inner, "budget") else inner.session.teacher_turns[0].budget


def lost(env, spec, seed, chosen):
    """Regret of each episode, summed over the class, with a teacher who does as `chosen` says."""
    game = ParallelSeats(env, seats(env, spec))
    observations, _ = game.reset(seed=seed)
    regrets = np.zeros(env.episodes)
    while game.agents:
        episode = env.episode
        observations, rewards, *_ = game.step({TEACHER: chosen(observations[TEACHER])})
        regrets[episode] -= rewards[TEACHER]
    return regrets


@pytest.mark.parametrize("seating", ["tutoring", "classroom"])
def test_who_remembers_learns_from_one_episode_for_the_next(seating):
    def regrets(spec):
        return np.mean([lost(make(), spec, seed, lambda _: 0) for seed in range(4)], axis=0)

    def make():
        paid = {"cost": 0.0, "teacher_reward": "student_progress", **SEATINGS[seating]}
        return GRID.raw_env(seating=seating, speech="kinds", episodes=20, max_cycles=20, num_rooms=5, **paid)

    kept, forgot = regrets(LEARNER), regrets(LEARNER.replace("forget=False", "forget=True"))
    assert kept[-5:].mean() < kept[:5].mean() / 3
    assert forgot[-5:].mean() > kept[-5:].mean() * 3


@pytest.mark.parametrize("name", ["obedient", "text_only"])
def test_who_reads_takes_the_last_words_along(name):
    """All is said when an episode is over; an episode later it has an effect on who remembers."""

    def regrets(forget):
        paid = {"cost": 0.0, "teacher_reward": "student_progress", "num_rooms": 6, "max_cycles": 20}
        env = GRID.raw_env(speech="kinds", episodes=6, teacher="end_of_episode(top_k=99)", feedback_type="fp", **paid)
        return lost(env, f"{name}(forget={forget})", 5, speak)

    assert regrets(forget=False)[-1] == 0
    assert regrets(forget=True)[-1] > 0


def test_a_lifetime_is_that_of_the_teachers_seat():
    """`TeacherEnv` with as many episodes, and the same student, who draws nothing."""

    class Walker:
        def reset(self, rng):
            self.turn = 0

        def act(self, observation, info):
            self.turn += 1
            heard = [atom.claim.action for atom in info["atoms"] if atom.kind == "fp"]
            return heard[0] if heard else self.turn % 4

    settings = {"episodes": 6, "budget": 20, "teacher_reward": "student_progress"}
    teacher = llf_teacher.TeacherEnv("llf-gridworld-v0", student=Walker(), max_turns=20, **settings)
    there = [reward for _, reward, *_ in episode(teacher, lambda observation, info: speak(observation), seed=4)]
    env = GRID.raw_env(speech="kinds", max_cycles=20, **settings)
    game = ParallelSeats(env, {STUDENT: Walker()})
    observations, _ = game.reset(seed=4)
    here = []
    while game.agents:
        observations, rewards, *_ = game.step({TEACHER: speak(observations[TEACHER])})
        here.append(rewards[TEACHER])
    assert here == there
    assert len(set(here)) > 2


def optimal(env, i):
    session = env.unwrapped.sessions[i]
    return session.teacher.oracle.plan(session.moment.after, 1)[0]


def test_who_has_ended_waits_and_is_paid_once():
    """The first student is led to the treasure, the second one walks against a wall."""
    parallel = pettingzoo.make(
        "parallel", "llf/gridworld-classroom-v0", students=2, episodes=2, max_cycles=12, min_goal_dist=2
    )
    _, infos = parallel.reset(seed=3)
    env, returns, waited = parallel.env, 0.0, 0
    while parallel.agents:
        actions = dict.fromkeys(parallel.agents, 0)
        if STUDENT in actions and "waits" not in infos[STUDENT]:
            actions[STUDENT] = optimal(env, 0)
        waited += STUDENT in actions and "waits" in infos[STUDENT]
        _, rewards, _, _, infos = parallel.step(actions)
        returns += rewards.get(STUDENT, 0.0)
    assert returns == 2  # a treasure an episode
    assert waited == 4  # of the 12 turns of the other one


def test_partners_are_told_of_an_end_as_they_read():
    class Listener:
        reads = "words"

        def __init__(self):
            self.begun, self.ended, self.seen = 0, [], set()

        def reset(self, rng):
            self.begun += 1

        def act(self, observation, info):
            self.seen |= set(info)
            return 0

        def finish(self, observation, info, terminated):
            assert "atoms" not in info
            assert info["turns_left"] == 0
            self.ended.append(terminated)

    env = GRID.raw_env(speech="kinds", episodes=3, max_cycles=2)
    listener = Listener()
    game = ParallelSeats(env, {STUDENT: listener})
    game.reset(seed=0)
    while game.agents:
        game.step({TEACHER: ADVICE})
    assert listener.begun == 3
    assert listener.ended == [False] * 3
    assert listener.seen == {"success", "turns_left"}


def test_without_a_seed_another_lifetime_begins():
    env = BANDIT.raw_env(speech="kinds", episodes=2, max_cycles=2, budget=1)
    for seed in (0, None):
        first, *_, last = [env.episode for _ in agents(env, all_is_said, seed)]
        assert (first, last) == (0, 1)
        assert _budget(env).spent == 1


@pytest.mark.parametrize("episodes", [0, True, 1.5, "3"])
def test_what_is_no_number_of_episodes(episodes):
    with pytest.raises(ValueError, match="episodes must be an integer of at least 1, got"):
        GRID.raw_env(episodes=episodes)


def test_it_says_what_it_plays():
    env = GRID.raw_env(episodes=3)
    assert repr(env).startswith("<LifetimeEnv ")
    assert "episodes=3 <TutoringEnv" in repr(env)
    assert env.unwrapped is env.seats
