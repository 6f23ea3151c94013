"""Lifetimes: learners that take advice, many episodes of one student, drawn parameters, and what the teacher sees."""

import copy

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv
from playing import earned, episode

import llf_teacher
from llf_teacher.gym.lifetime_statistics import FIELDS, is_mistake
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.variation import draw_student
from teachers.atoms import ParseFailure
from teachers.feedback import SUBSETS
from worlds.testing import plain

GRID, ARMS, BOOTH = "llf-gridworld-v0", "llf-bandits-BanditTenArmedGaussian-v0", "llf-optimization-Booth-v0"
LEARNERS = {
    GRID: "q_learning(trust=1.0, forget=False, optimism=0.0, epsilon=0.1)",
    ARMS: "ucb(trust=1.0, forget=False)",
    BOOTH: "nelder_mead(trust=1.0, forget=False)",
}
FP, FN = 0b01000, 0b10000


def live(id, say=FP, seed=0, student=None, **settings):
    """The reward of a lifetime."""
    env = llf_teacher.TeacherEnv(
        id, student=student or LEARNERS[id], **{"episodes": 10, "cost": 0.0, "max_turns": 30, **settings}
    )
    return earned(env, say, seed)


@pytest.mark.parametrize("id", LEARNERS)
def test_a_lifetime_passes_gymnasiums_check(id):
    check_env(llf_teacher.TeacherEnv(id, student=LEARNERS[id], episodes=3, announce=True), skip_render_check=True)


@pytest.mark.parametrize("id", LEARNERS)
def test_lifetimes_repeat(id):
    def trace(seed):
        env = llf_teacher.TeacherEnv(id, student=LEARNERS[id], episodes=3, max_turns=6, announce=True)
        rng = np.random.default_rng(0)
        played = episode(env, lambda observation, info: int(rng.integers(SUBSETS)), seed)
        return [plain(env.reset(seed=seed)[0]), *(plain(outcome[:2]) for outcome in played)]

    assert trace(1) == trace(1) != trace(2)


@pytest.mark.parametrize("id", LEARNERS)
def test_advice_changes_what_becomes_of_a_student(id):
    """Greedy learners keep to what they were led to; `ucb` counts, and makes up for what it has not tried yet."""
    student = LEARNERS[BOOTH] if id == BOOTH else LEARNERS[GRID]

    def regret(say):
        """Of the students, so that the noise of rewards plays no part."""
        settings = {"student": student, "budget": 30, "teacher_reward": "student_progress"}
        return -np.mean([live(id, say, seed, **settings) for seed in range(8)])

    assert regret(FP) < 0.9 * regret(0)


@pytest.mark.parametrize("id", LEARNERS)
def test_students_learn_across_episodes(id):
    """Unadvised, what is not forgotten makes later episodes better than the first one."""

    def returns(forget):
        spec = LEARNERS[id].replace("forget=False", f"forget={forget}")
        sums = []
        for seed in range(12):
            env = llf_teacher.TeacherEnv(id, student=spec, episodes=25, cost=0.0, max_turns=12, until_success=False)
            env.reset(seed=seed)
            episodes = np.zeros(25)
            for number in range(25):
                for _ in range(13):
                    _, reward, _, truncated, _ = env.step(0)
                    episodes[number] += reward
            assert truncated
            sums.append(episodes[-8:].mean())
        return np.mean(sums)

    assert returns(forget=False) > returns(forget=True)


def test_a_follower_does_what_it_is_advised_to():
    env = llf_teacher.TeacherEnv(GRID, student="q_learning(trust=1.0)", cost=0.0)
    env.reset(seed=0)
    for _ in range(4):
        advised = env.session.teacher.oracle.plan(env.session.moment.after, 1)
        env.step(FP)
        assert env.session.moment.action == advised[0]
        if env.session.moment.success:
            break


@pytest.mark.parametrize("student", ["q_learning(trust=1.0, epsilon=0.5)", "ucb(trust=1.0)"])
def test_a_follower_does_not_do_what_it_is_warned_of(student):
    for seed in range(30):
        env = llf_teacher.TeacherEnv(ARMS, student=student, cost=0.0)
        env.reset(seed=seed)
        for _ in range(20):
            env.step(FN)
            (atom,) = env.session.feedback.atoms
            assert env.session.moment.action != atom.claim.action


def test_late_advice_is_not_taken_for_the_present():
    env = llf_teacher.make(ARMS, teacher="only(kinds='fp') | delayed(turns=1)")
    policy = parse_student("ucb(trust=1.0)").seat(env.family, env.session.world)
    policy.reset(np.random.default_rng(0))
    env.reset(seed=0)
    actions = set()
    for _ in range(10):
        action = policy.act(env.student_view.observe(), env.student_view.info_for(policy))
        env.step(action)
        actions.add(action)
    assert len(actions) == 10, "it goes on trying each arm once"


def test_trust_is_the_rate_of_following():
    followed = said = 0
    for seed in range(60):
        env = llf_teacher.TeacherEnv(ARMS, student="ucb(trust=0.3)", cost=0.0)
        env.reset(seed=seed)
        best = env.session.world.truth.best
        for _ in range(9):  # while it tries each arm once by itself, in random order
            intention = env.student.intend(env.student_view.observe(), env.student_view.info_for(env.student))
            env.step(FP)
            if intention not in best:
                said += 1
                followed += env.session.moment.action in best
    assert said > 300
    assert 0.2 < followed / said < 0.4


def test_what_it_announces_is_what_it_does():
    def silent(observation, info):
        seen.append(info.get("intention"))
        return 0

    for id, learner in LEARNERS.items():
        seen = []
        alone = live(id, 0, student=learner)
        announced = live(id, silent, student=learner, announce=True)
        assert alone == announced, "asking changes nothing"
        assert any(each is not None for each in seen)
    env = llf_teacher.TeacherEnv(GRID, student=LEARNERS[GRID], episodes=5, announce=True)
    _, info = env.reset(seed=0)
    for _ in range(60):
        before, truth = info.get("intention"), env.session.world.truth
        observation, _, _, _, info = env.step(0)
        if before is not None:
            assert env.session.moment.action == before
            optimal = before in [
                d
                for d, v in enumerate(env.session.teacher.oracle.values(truth))
                if v == max(env.session.teacher.oracle.values(truth))
            ]
            assert observation["lifetime"][FIELDS.index("optimal")] == optimal


def test_what_the_teacher_sees_of_a_lifetime():
    env = llf_teacher.TeacherEnv(GRID, student="random", episodes=2, max_turns=3, cost=0.0, budget=2)
    observation, info = env.reset(seed=0)
    way = len(env.session.teacher.oracle.plan(info["moment"].after, 3))
    assert observation["lifetime"].tolist() == pytest.approx([0] * 8 + [way / (way + 4)])
    assert info["student"] == "random"
    assert "intention" not in info
    env.step(FP)
    env.step(FP)
    env.step(FP)
    observation, reward, terminated, truncated, _ = env.step(0)
    seen = dict(zip(FIELDS, observation["lifetime"].tolist(), strict=True))
    assert (reward, terminated, truncated) == (0, False, False)
    assert seen["episode"] == 0.5
    assert seen["optimal"] == 0
    # The same start again; it was advised there.
    assert seen["visits"] >= 0.2 - 1e-6
    assert seen["advised"] >= 0.2 - 1e-6
    assert observation["features"][3] == 0, "the budget is the lifetime's"
    assert env.step(FP)
    assert env.session.feedback == ""


def test_the_world_stays_or_is_drawn_anew():
    def starts(same_world, seed=0):
        env = llf_teacher.TeacherEnv(GRID, student="random", episodes=3, max_turns=2, same_world=same_world)
        env.reset(seed=seed)
        found = [env.session.moment.after]
        for _ in range(8):
            env.step(0)
            if env.session.moment.turn == 0:
                found.append(env.session.moment.after)
        env.reset()
        return [*found, env.session.moment.after]

    first, second, third, other = starts(True)
    assert first == second == third != other
    assert len(set(starts(False))) == 4


def test_what_is_random_in_a_world_that_stays_is_drawn_anew():
    env = llf_teacher.TeacherEnv(ARMS, student="ucb(trust=1.0)", episodes=2, max_turns=5, cost=0.0)
    env.reset(seed=0)
    rewards = [env.step(FP)[1] for _ in range(12)]
    assert rewards[:5] != rewards[6:11]


def test_parameters_are_drawn_at_reset():
    vary = {"alpha": (0.1, 0.9), "epsilon": (0.0, 0.3), "trust": (0, 1)}
    env = llf_teacher.TeacherEnv(GRID, student=LEARNERS[GRID], episodes=2, max_turns=1, vary=vary)
    specs = [env.reset(seed=seed)[1]["student"] for seed in range(20)]
    assert len(set(specs)) == 20
    students = [parse_student(spec) for spec in specs]
    assert all(0.1 <= student.alpha <= 0.9 and 0 <= student.epsilon <= 0.3 for student in students)
    assert {student.trust for student in students} == {0, 1}
    assert all(student.optimism == 0 for student in students)
    assert env.reset(seed=3)[1]["student"] == specs[3]
    one = draw_student(parse_student("ucb"), {"scale": (2.0, 2.0)}, np.random.default_rng(0))
    assert str(one) == "ucb(scale=2.0)"


def test_students_of_ones_own():
    class Newcomer:
        count = 0

        def __init__(self, rng):
            Newcomer.count += 1
            self.episodes = 0

        def reset(self, rng):
            self.episodes += 1

        def act(self, observation, info):
            return 0

    env = llf_teacher.TeacherEnv(GRID, student=Newcomer, episodes=3, max_turns=1)
    for lifetime in range(1, 3):
        earned(env, 0)
        assert (Newcomer.count, env.student.episodes) == (lifetime, 3)


def test_each_lifetime_has_a_new_student():
    env = llf_teacher.TeacherEnv(GRID, student=LEARNERS[GRID], episodes=2, max_turns=2)
    env.reset(seed=0)
    first = env.student
    env.reset()
    assert env.student is not first


def test_a_seed_brings_a_new_student():
    def pulls(seed):
        env.reset(seed=seed)
        taken = []
        for _ in range(8):
            env.step(0)
            taken.append(env.session.moment.action)
        return taken

    env = llf_teacher.TeacherEnv(ARMS, student="ucb(forget=False)", max_turns=20)
    first = pulls(0)
    assert pulls(None) != first
    assert pulls(0) == first


@pytest.mark.parametrize("vector", [SyncVectorEnv, AsyncVectorEnv])
@pytest.mark.parametrize("episodes", [1, 3])
def test_announcements_go_through_gymnasiums_vectors(vector, episodes):
    """Some environments have one while others have none."""

    def make(first):
        student = "q_learning(forget=False)"
        return lambda: llf_teacher.TeacherEnv(GRID, student=student, announce=True, episodes=episodes, max_turns=first)

    envs = vector([make(2), make(3)], autoreset_mode="NextStep")
    _, infos = envs.reset(seed=0)
    announced = 0
    for _ in range(12):
        assert infos["intention"].dtype.kind == "i"
        announced += infos["_intention"].sum()
        *_, infos = envs.step(np.zeros(2, int))
        if "intention" not in infos:
            break
    assert announced > 4
    envs.close()


def test_who_cannot_announce_is_refused_however_it_is_made():
    refused = pytest.raises(ValueError, match=r"has no intend\(observation, info\), which announce=True needs")
    for student in (Still(), Still, "obedient"):
        with refused:
            llf_teacher.TeacherEnv(GRID, student=student, announce=True)
    env = llf_teacher.TeacherEnv(GRID, student=lambda rng: Still(rng), announce=True)  # of whom nothing is known yet
    with refused:
        env.reset(seed=0)


def test_a_mistake_is_worth_less_than_another_action():
    session = llf_teacher.make(GRID).unwrapped.session
    session.open(1)
    session.speak()
    values = session.teacher.oracle.values(session.moment.after)
    assert [is_mistake(session, action) for action in range(4)] == [value < max(values) for value in values]
    assert is_mistake(session, ParseFailure("x", "y"))
    reading = llf_teacher.make(GRID, text=True).unwrapped.session
    reading.open(1)
    assert is_mistake(reading, "no action")


def test_an_announced_mistake_is_one_also_where_actions_have_no_values():
    """In optimization the loss rises by it; the check looks the loss up, the feature asks the oracle."""
    env = llf_teacher.TeacherEnv(BOOTH, student=LEARNERS[BOOTH], episodes=2, announce=True)
    observation, info = env.reset(seed=0)
    mistakes = []
    while "intention" in info:
        before, announced = info["moment"].after.y, observation["lifetime"][FIELDS.index("mistake")]
        observation, _, _, _, info = env.step(0)
        if info["moment"].turn:
            assert bool(announced) == (info["moment"].after.y > before)
            mistakes.append(bool(announced))
    assert {True, False} == set(mistakes)


class Still:
    """Pulls the first arm; an instance is a policy, the class makes them."""

    def __init__(self, rng=None):
        """Nothing to draw."""

    def reset(self, rng):
        """Nothing to forget."""

    def act(self, observation, info):
        return 0


def test_intentions_are_announced_in_a_single_episode():
    env = llf_teacher.TeacherEnv(ARMS, student="ucb", announce=True)
    _, info = env.reset(seed=0)
    for _ in range(5):
        intention = info.get("intention")
        _, *_, info = env.step(0)
        assert intention == info["moment"].action
    assert info["student"] == "ucb"


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        ({"episodes": 0}, "episodes must be an integer of at least 1, got 0"),
        ({"student": "random", "announce": True}, "the student random has no intend"),
        ({"student": "ucb", "vary": {"skale": (0, 1)}}, "unknown parameter of ucb 'skale'; did you mean scale"),
        ({"student": "ucb", "vary": {"scale": (1, 0)}}, r"vary\['scale'\] must be the least and the greatest value"),
        ({"student": "ucb", "vary": {"scale": 3}}, r"vary\['scale'\] must be the least and the greatest value"),
        ({"student": "ucb", "vary": {"trust": (0.5, 2)}}, "trust must be a number from 0 to 1, got 2"),
        ({"student": object(), "vary": {"scale": (0, 1)}}, "vary needs a student that is given by its spec"),
        ({"student": "ucb(forget=3)"}, "forget must be True or False, got 3"),
        ({"student": "q_learning(epsilon=2)"}, "epsilon must be a number from 0 to 1, got 2"),
    ],
)
def test_bad_arguments(settings, match):
    with pytest.raises(ValueError, match=match):
        llf_teacher.TeacherEnv(ARMS, **settings)


def test_a_reward_may_see_the_lifetime():
    seen = []

    def newcomer(moment, oracle, life):
        """Pays for success in the first episodes."""
        seen.append(life.episode)
        return float(moment.success and life.episode < 2)

    settings = {"student": "obedient", "teacher_reward": newcomer, "cost": 0.0}
    env = copy.deepcopy(llf_teacher.TeacherEnv(GRID, episodes=4, **settings))
    assert earned(env, FP, seed=3) == 2
    assert sorted(set(seen)) == [0, 1, 2, 3]
    once = llf_teacher.TeacherEnv(GRID, until_success=True, **settings)
    observation, _ = once.reset(seed=3)
    assert "lifetime" not in observation
    once.step(0b01000)
    assert seen[-1] == 0
