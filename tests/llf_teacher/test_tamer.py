"""The student tamer, which learns from praise and blame."""

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces
from playing import episode

import llf_teacher
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.tables import Table, Tiling
from teachers.atoms import HN, HP, ActionClaim, claim
from teachers.oracle import Oracle

GRID = "llf-gridworld-v0"
VERDICTS = "only(kinds='hp+hn')"


def lifetime(env, teacher, seed=0):
    """The regret of each episode of a lifetime."""
    policy = env.family.make_teacher(env.session.world, teacher)
    policy.reset(np.random.default_rng(seed))
    regrets = [0.0]
    for _, reward, *ends, info in episode(env, policy.act, seed):
        regrets[-1] -= reward
        if info["moment"].turn == 0 and not any(ends):
            regrets.append(0.0)
    return regrets


def house(student, episodes=20, **options):
    options = {"speech": "message", "max_turns": 40, "cost": 0.0, "teacher_reward": "student_progress"} | options
    return llf_teacher.TeacherEnv(GRID, student=student, episodes=episodes, **options)


def seat(student, id=GRID):
    env = llf_teacher.make(id)
    policy = parse_student(student).seat(env.family, env.session.world)
    policy.reset(np.random.default_rng(0))
    return policy


def test_verdicts_alone_teach_a_house():
    env = house("tamer(forget=False)", episodes=30)
    taught = np.mean([lifetime(env, VERDICTS, seed)[-5:] for seed in range(4)])
    left_alone = np.mean([lifetime(env, "silent", seed)[-5:] for seed in range(4)])
    assert taught < 3 < left_alone


def test_bandits():
    env = llf_teacher.TeacherEnv(
        "llf-bandits-BanditTenArmedGaussian-v0",
        student="tamer(forget=False)",
        episodes=20,
        max_turns=10,
        speech="message",
        teacher_reward="student_progress",
        cost=0.0,
    )
    taught, alone = ([sum(lifetime(env, teacher, seed)[-5:]) for seed in range(3)] for teacher in (VERDICTS, "silent"))
    assert sum(taught) < sum(alone)


def test_what_comes_late_counts_for_its_turn():
    """A teacher who is two turns late teaches the same, in turns that are over."""
    env = house("tamer(forget=False)")
    assert sum(lifetime(env, f"{VERDICTS} | delayed(turns=2)")[-5:]) == 0


def test_advice_is_no_evaluation():
    policy = seat("tamer")
    env = llf_teacher.make(GRID, feedback_type="fp")
    _, info = env.reset(seed=0)
    policy.act(env.student_view.observe(), info)
    assert not policy._human(policy.steps[0][0]).any()


def test_shares_of_a_table_and_tiles_that_are_met_again():
    table = Table(3)
    table.add(("a", "b"), 0.5, 1)
    assert table(("a", "b")).tolist() == [0.0, 0.5, 0.0]
    assert table(("b", "c")).tolist() == [0.0, 0.25, 0.0]
    tiling = Tiling(spaces.Box(np.array([-1.0, 0.0], np.float32), np.array([1.0, 10.0], np.float32)), 8)
    here, near, far = (set(tiling(np.array(at))) for at in ([0.0, 5.0], [0.1, 5.6], [0.9, 9.0]))
    assert len(here) == 8
    assert 0 < len(here & near) < 8
    assert not here & far


@pytest.mark.parametrize(
    ("student", "match"),
    [
        ("tamer(alpha=2)", "alpha"),
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


@pytest.mark.parametrize("late", [1, 2])
def test_a_late_label_counts_as_one_in_time(late):
    """For its turn, once; each state is seen once, so that nothing is learned between."""
    played = [("a", 0, 1.0), ("b", 1, -1.0), ("c", 2, 0.0), ("d", 3, 1.0), ("e", 0, -1.0)]
    known = []
    for delay in (0, late):
        policy = seat("tamer")
        for turn, (state, action, _) in enumerate(played, 1):
            policy.steps.append(((state,), action))
            if turn > delay:
                policy.hear(turn - delay, played[turn - delay - 1][2])
        for turn in range(len(played) + 1 - delay, len(played) + 1):
            policy.hear(turn, played[turn - 1][2])
        known.append(np.array([policy._human((state,)) for state in "abcde"]))
    assert np.abs(known[0]).max() > 0.1
    assert known[1] == pytest.approx(known[0])


def test_each_verdict_is_heard_once():
    """In an environment with a teacher that is two turns late, over a whole episode."""
    env = llf_teacher.make(GRID, teacher=f"{VERDICTS} | delayed(turns=2)", max_turns=20)
    policy = parse_student("tamer").seat(env.family, env.session.world)
    policy.reset(np.random.default_rng(0))
    _, info = env.reset(seed=3)
    over, heard = False, []
    hear = policy.hear
    policy.hear = lambda turn, label: (heard.append((turn, label)), hear(turn, label))
    while not over:
        *_, terminated, truncated, info = env.step(policy.act(env.student_view.observe(), info))
        over = terminated or truncated
    policy.act(env.student_view.observe(), info)
    assert [turn for turn, label in heard if label] == list(range(1, 19))


def test_tamer_predicts_the_mean_label():
    """A bandit whose trainer praises each action with a probability of its own."""
    praised = np.array([0.2, 0.9, 0.6, 0.4])
    policy, rng = seat("tamer(alpha=0.02)"), np.random.default_rng(0)
    for turn in range(1, 8001):
        action = int(rng.integers(4))
        policy.steps.append((("here",), action))
        policy.hear(turn, 1.0 if rng.random() < praised[action] else -1.0)
    assert policy._human(("here",)) == pytest.approx(2 * praised - 1, abs=0.25)
    assert policy.act({"state": "here"}, {"atoms": ()}) == 1


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
