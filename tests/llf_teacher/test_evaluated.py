"""Students who learn from evaluation: praise, blame and silence."""

import itertools

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces
from playing import episode

import llf_teacher
from llf_teacher.students.evaluated import Table, Tiling, softmax
from llf_teacher.students.parsing import parse_student
from teachers.atoms import HN, HP, ActionClaim, claim
from teachers.oracle import Oracle

GRID = "llf-gridworld-v0"
STUDENTS = ("advise", "coach", "coach(episodic=True)", "sabl", "sabl(infers=True)", "tamer")
VERDICTS = "only(kinds='hp+hn')"


def lifetime(env, teacher, seed=0):
    """The regret of each episode of a lifetime, and the student."""
    policy = env.family.make_teacher(env.session.world, teacher)
    policy.reset(np.random.default_rng(seed))
    regrets = [0.0]
    for _, reward, *ends, info in episode(env, policy.act, seed):
        regrets[-1] -= reward
        if info["moment"].turn == 0 and not any(ends):
            regrets.append(0.0)
    return regrets, env.student


def house(student, episodes=20, **options):
    options = {"speech": "message", "max_turns": 40, "cost": 0.0, "teacher_reward": "student_progress"} | options
    return llf_teacher.TeacherEnv(GRID, student=student, episodes=episodes, **options)


def lasting(student):
    name, bracket, rest = student.partition("(")
    return f"{name}(forget=False, {rest}" if bracket else f"{name}(forget=False)"


def seat(student, id=GRID):
    env = llf_teacher.make(id)
    policy = parse_student(student).seat(env.family, env.session.world)
    policy.reset(np.random.default_rng(0))
    return policy


def live(policy, heard):
    """Turns of an episode: states, actions, and their labels in time."""
    for turn, (state, action, label) in enumerate(heard, 1):
        policy.steps.append(((state,), action))
        policy.hear(turn, label)


@pytest.mark.parametrize("student", STUDENTS)
def test_verdicts_alone_teach_a_house(student):
    env = house(lasting(student), episodes=60 if "episodic" in student else 30)
    taught = np.mean([lifetime(env, VERDICTS, seed)[0][-5:] for seed in range(4)])
    left_alone = np.mean([lifetime(env, "silent", seed)[0][-5:] for seed in range(4)])
    assert taught < 3 < left_alone


@pytest.mark.parametrize("student", ["advise(temperature=1.0, gamma=0.0)", *STUDENTS[1:]])
def test_bandits(student):
    env = llf_teacher.TeacherEnv(
        "llf-bandits-BanditTenArmedGaussian-v0",
        student=lasting(student),
        episodes=20,
        max_turns=10,
        speech="message",
        teacher_reward="student_progress",
        cost=0.0,
    )
    taught, alone = (
        [sum(lifetime(env, teacher, seed)[0][-5:]) for seed in range(3)] for teacher in (VERDICTS, "silent")
    )
    assert sum(taught) < sum(alone)


def test_silence_is_praise_from_one_who_only_blames():
    """Only who counts silence learns from it; who infers the strategy finds it."""
    said = f"inactive(plus=1.0, minus=0.0) | {VERDICTS}"
    regrets, student = lifetime(house("sabl(forget=False, infers=True, error=0.01)"), said)
    plus, minus = student.strategies()
    assert student.weights() @ plus > 0.9
    assert student.weights() @ minus < 0.2
    assert sum(regrets[1:]) == 0


def test_the_posterior_of_strategies_is_that_of_all_policies_together():
    """A sum over every assignment of best actions to two states, by brute force."""
    policy = seat("sabl(infers=True, error=0.2)")
    heard = [("a", 0, 1.0), ("a", 1, 0.0), ("b", 2, -1.0), ("a", 0, 0.0), ("b", 2, 0.0), ("b", 3, 1.0)]
    live(policy, heard)
    error = 0.2

    def chance(label, right, plus, minus):
        if label > 0:
            return (1 - error if right else error) * (1 - plus)
        if label < 0:
            return (error if right else 1 - error) * (1 - minus)
        return (1 - error) * plus + error * minus if right else (1 - error) * minus + error * plus

    joint = []
    for plus, minus in zip(*policy.strategies(), strict=True):
        total = 0.0
        for best in itertools.product(range(4), repeat=2):
            by_state = dict(zip("ab", best, strict=True))
            total += np.prod([chance(label, by_state[state] == action, plus, minus) for state, action, label in heard])
        joint.append(total)
    assert policy.weights() == pytest.approx(np.array(joint) / sum(joint))


def test_odds_of_advise():
    policy = seat("advise(consistency=0.8, temperature=1.0)")
    live(policy, [*(("here", 2, label) for label in (1.0, 1.0, -1.0, 1.0)), ("here", 0, -1.0), ("here", 1, 0.0)])
    shares = np.array([0.2 / (0.2 + 0.8), 0.5, 0.8**2 / (0.8**2 + 0.2**2), 0.5])
    assert softmax(policy._scores(("here",))) == pytest.approx(shares / shares.sum())


def test_the_gradient_of_coach():
    """Against differences of the logarithm of the probability."""
    policy = seat("coach(alpha=1.0)")
    start = np.array([0.3, -0.2, 0.5, 0.0])
    policy._preference.add(("here",), start)
    live(policy, [("here", 2, 1.0)])
    moved = policy._preference(("here",)) - start
    tiny = 1e-6
    slopes = [
        (np.log(softmax(start + tiny * one)[2]) - np.log(softmax(start - tiny * one)[2])) / (2 * tiny)
        for one in np.eye(4)
    ]
    assert moved == pytest.approx(np.array(slopes), abs=1e-6)


def test_the_trace_of_coach_fades():
    policy = seat("coach(alpha=1.0, trace=0.5)")
    live(policy, [("first", 0, 0.0), ("second", 0, 0.0), ("third", 0, 1.0)])
    sizes = [policy._preference((state,))[0] for state in ("third", "second", "first")]
    assert sizes == pytest.approx([0.75, 0.375, 0.1875])


def test_by_episodes_a_policy_stays_until_the_end():
    policy = seat("coach(episodic=True, alpha=1.0, gamma=0.5)")
    live(policy, [("first", 0, 0.0), ("second", 0, 1.0)])
    assert not policy._preference(("first",)).any()
    policy.end()
    assert policy._preference(("first",))[0] == policy._preference(("second",))[0] == pytest.approx(0.5 * 0.75)


def test_rewards_that_are_told():
    env = house("coach(forget=False, listens='rewards')", episodes=60)
    told = np.mean([lifetime(env, "only(kinds='r')", seed)[0][-10:] for seed in range(4)])
    silent = np.mean([lifetime(env, "silent", seed)[0][-10:] for seed in range(4)])
    assert told < silent


def test_what_comes_late_counts_for_its_turn():
    """A teacher who is two turns late teaches the same, in turns that are over."""
    env = house("tamer(forget=False)")
    assert sum(lifetime(env, f"{VERDICTS} | delayed(turns=2)")[0][-5:]) == 0


def test_advice_is_no_evaluation():
    policy = seat("tamer")
    env = llf_teacher.make(GRID, feedback_type="fp")
    _, info = env.reset(seed=0)
    policy.act(env.student_view.observe(), info)
    assert not policy._human(policy.steps[0][0]).any()


def test_shares_of_a_table_and_tiles_that_are_met_again():
    table = Table(3, start=1.0)
    table.add(("a", "b"), 0.5, 1)
    assert table(("a", "b")).tolist() == [1.0, 1.5, 1.0]
    assert table(("b", "c")).tolist() == [1.0, 1.25, 1.0]
    tiling = Tiling(spaces.Box(np.array([-1.0, 0.0], np.float32), np.array([1.0, 10.0], np.float32)), 8)
    here, near, far = (set(tiling(np.array(at))) for at in ([0.0, 5.0], [0.1, 5.6], [0.9, 9.0]))
    assert len(here) == 8
    assert 0 < len(here & near) < 8
    assert not here & far


@pytest.mark.parametrize(
    ("student", "match"),
    [
        ("tamer(alpha=2)", "alpha"),
        ("coach(alpha=0)", "alpha"),
        ("coach(listens='advice')", "listens must be one of verdicts, rewards, got 'advice'"),
        ("coach(episodic=1)", "episodic must be True or False, got 1"),
        ("advise(consistency=0.4)", "consistency"),
        ("sabl(error=0.5)", "error"),
        ("sabl(infers=1)", "infers must be True or False, got 1"),
        ("sabl(tiles=4)", "tiles must be 0, got 4"),
        ("tamer(tiles=-1)", "tiles must be an integer from 0 to 64, got -1"),
        ("tamer(forget=2)", "forget must be True or False, got 2"),
    ],
)
def test_refusals(student, match):
    with pytest.raises(ValueError, match=match):
        parse_student(student)


def test_where_they_cannot_play():
    with pytest.raises(ValueError, match="needs discrete actions"):
        seat("tamer", "llf-highway-parking-v0")
    with pytest.raises(ValueError, match="tiles are for states in a bounded box"):
        seat("tamer(tiles=4)")


@claim
class Pumped(ActionClaim):
    """True if the car was pushed the way that it was moving."""

    kind = HP
    action: int

    def holds(self, moment, lab):
        return (self.action == 2) == (moment.before.seen[1] >= 0)


@claim
class Braked(ActionClaim):
    """True if the car was not pushed the way that it was moving."""

    kind = HN
    action: int

    def holds(self, moment, lab):
        return self.action != (2 if moment.before.seen[1] >= 0 else 0)


class Swing(Oracle):
    """Judges by what adds energy."""

    feedback_types = (HP, HN)

    def _basics(self, truth):
        return ()

    def _hindsight(self, claims, moment, kinds):
        right = moment.action == (2 if moment.before.seen[1] >= 0 else 0)
        claims.append((Pumped if right else Braked)(action=int(moment.action)))

    def _advice(self, claims, moment, kinds):
        pass


def test_a_car_on_a_hill_with_tiles():
    """Few states are met twice; with tiles what is near is judged alike."""
    phrases = {
        Pumped: [f"Pushing {{action}} was right{mark}" for mark in (".", "!", " there.", " then.")],
        Braked: [f"Pushing {{action}} was wrong{mark}" for mark in (".", "!", " there.", " then.")],
    }
    lesson = llf_teacher.Lesson(lambda: gymnasium.make("MountainCar-v0"), Swing, phrases=phrases)
    turns = {}
    for student in ("tamer(forget=False, tiles=8)", "random"):
        env = llf_teacher.TeacherEnv(lesson, student=student, speech="message", episodes=6, cost=0.0)
        teacher = lesson.make_teacher(env.session.world)
        teacher.reset(np.random.default_rng(0))
        lengths = [0]
        for *_, terminated, truncated, info in episode(env, teacher.act):
            lengths[-1] = max(lengths[-1], info["moment"].turn)
            if info["moment"].turn == 0 and not (terminated or truncated):
                lengths.append(0)
        turns[student] = lengths
    taught, untaught = turns.values()
    assert min(untaught) == 200
    assert max(taught[-3:]) < 150
