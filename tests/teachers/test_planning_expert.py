"""The expert tier: what it says of experts that are known or given, what it measures, and which it refuses."""

import copy
import dataclasses
import pickle
import random
from functools import partial

import gymnasium
import minigrid
import numpy as np
import pytest
from design import amount
from gymnasium import spaces
from minigrid.utils.baby_ai_bot import BabyAIBot

import llf_teacher
from llf_teacher.tools.audit import audit
from pz_envs.lesson import Lesson
from teachers.atoms import FN, FP, HN, HP, KINDS, Label, Moment, R
from teachers.common import Chance, PartlyRight, Right, Trap, Wrong
from teachers.oracle import RefusalError
from teachers.planning import TIERS, Exact, Expert, PlanningError
from teachers.planning.expert import ExpertWarning, guide
from teachers.planning.expert.claims import Ahead, Around, Behind, Costs, Demonstration, Followed, Neared, Would
from teachers.testing import Pupil, check_oracle
from worlds.wrapped.generators import generators, reseed

pytestmark = pytest.mark.usefixtures("short_trials")

assert minigrid  # registers its environments


class Line(gymnasium.Env):
    """A point on a line, which is pushed towards 0; `noise` pushes, too."""

    observation_space = spaces.Box(-np.inf, np.inf, (1,), np.float64)

    def __init__(self, noise=0.0, box=False):
        self.noise = noise
        self.action_space = spaces.Box(-1, 1, (2,), np.float32) if box else spaces.Discrete(3)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.at = self.np_random.uniform(-5, 5)
        return np.array([self.at]), {"at": self.at}

    def step(self, action):
        push = float(np.sum(action)) / 2 if np.ndim(action) else int(action) - 1
        self.at += push + (self.noise * self.np_random.normal() if self.noise else 0)
        return np.array([self.at]), -abs(self.at), False, False, {"at": self.at}


def towards(observation, info):
    """Pushes to 0."""
    return 1 + int(info["at"] < -0.5) - int(info["at"] > 0.5)


def steer(observation, info):
    """Pushes to 0, as hard as it takes."""
    return np.clip(np.full(2, -observation[0]), -1, 1)


class Guess(gymnasium.Env):
    """A coin is tossed at each step, and pays who guessed it."""

    observation_space, action_space = spaces.Discrete(1), spaces.Discrete(2)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return 0, {}

    def step(self, action):
        return 0, float(action == self.np_random.integers(2)), False, False, {}


def heads(observation, info):
    return 0


class Rare(Guess):
    """One step: action 1 costs 1 three times in four, and pays 100 once."""

    def step(self, action):
        lucky = self.np_random.random() < 0.25
        return 0, (100.0 if lucky else -1.0) * action, True, False, {}


TOYS = {
    "line": lambda: Lesson(Line, Expert(towards), max_turns=20),
    "noisy": lambda: Lesson(partial(Line, 0.3), Expert(towards, rollouts=8, horizon=4), max_turns=20),
    "box": lambda: Lesson(partial(Line, box=True), Expert(steer, tolerance=0.5, horizon=4), max_turns=20),
}


def lander(**options):
    pytest.importorskip("Box2D", reason="box2d has no wheel for this Python")
    return gymnasium.make("LunarLander-v3", **options)


KNOWN = {
    "lander": lander,
    "baby": lambda: gymnasium.make("BabyAI-GoToLocal-v0"),
}


@pytest.mark.parametrize("name", TOYS)
def test_it_passes_the_kit(name):
    subject = TOYS[name]()
    check_oracle(Pupil(subject.make_world, subject.make_teacher, max_turns=20, turns=amount(12, full=40)))


@pytest.mark.parametrize("name", TOYS)
def test_no_claim_is_false_and_lies_are_caught(name):
    honest = audit(TOYS[name](), turns=amount(24, full=60), students=("random", "obedient"))
    assert honest.count(Label.DISTORTED) == honest.contradictions == honest.leaks == 0 < honest.checked
    assert {kind for kind, _ in honest.claims} >= set(KINDS)
    liar = audit(TOYS[name](), "mistake(eps=1)", turns=amount(12, full=30), students=("random",))
    assert liar.count(Label.TRUTHFUL) == sum(n for (kind, _), n in liar.claims.items() if kind is None)


@pytest.mark.parametrize("name", KNOWN)
def test_experts_that_are_known_tell_the_truth(name):
    found = audit(Lesson(KNOWN[name], "expert"), turns=6, students=("random", "obedient"), instruction_types=("b",))
    assert found.count(Label.DISTORTED) == found.contradictions == found.leaks == 0 < found.checked


@pytest.mark.full
@pytest.mark.parametrize("name", [*KNOWN, "continuous lander"])
def test_experts_that_are_known_pass_the_kit(name):
    make = KNOWN.get(name, partial(lander, continuous=True))
    subject = Lesson(make, "expert")
    check_oracle(Pupil(subject.make_world, subject.make_teacher, max_turns=subject.max_turns, turns=120))


def played(subject, actions, seed=0):
    """The oracle of a lesson, and the moments of an episode."""
    world = subject.make_world()
    oracle = subject.make_teacher(world).oracle
    world.reset(seed=seed)
    oracle.start(world.truth)
    moments = [Moment.opening(world.truth)]
    for turn, action in enumerate(actions, 1):
        before = world.truth
        _, reward, *_, info = world.step(action)
        moments.append(Moment(before, world.legal(action), reward, world.truth, info["success"], turn, False))
    return oracle, moments


def test_amounts_are_what_roll_outs_earn():
    """Reckoned by hand: from 3.2 the way to 0 takes one step more, or two, each of which costs."""
    subject = TOYS["line"]()
    world = subject.make_world()
    seed = next(seed for seed in range(100) if world.reset(seed=seed)[0][0] > 3.5)
    oracle, (opening, moment) = played(subject, [2], seed)
    start = opening.after.seen[0]

    def earned(at):
        total = -abs(at)
        for _ in range(19):
            at += towards(None, {"at": at}) - 1
            total -= abs(at)
        return total

    (verdict,) = oracle.judge(moment, {HP, HN})
    assert isinstance(verdict, Behind)
    assert verdict.amount == pytest.approx(earned(start - 1) - earned(start + 1), rel=0.006)
    (advice,) = oracle.judge(opening, {FP})
    assert advice == Would(action=0, answer="0")


def test_the_teacher_knows_nothing_of_the_luck_to_come(monkeypatch):
    """With draws of their own roll-outs tell nothing of a coin; with the episode's they would tell all."""

    def warned():
        oracle, moments = played(Lesson(Guess, Expert(heads, rollouts=8, horizon=1), max_turns=200), [0] * 150)
        said = [oracle.judge(moment, {FN}) for moment in moments[:-1]]
        return [moment.reward for moment, each in zip(moments[1:], said, strict=True) if each]

    assert len(warned()) < 10
    monkeypatch.setattr(guide, "reseed", lambda env, *seed: None)
    assert len(profit := warned()) > 50
    assert set(profit) == {1.0}  # action 1 would have lost each time


def test_parts_of_an_environment_that_share_a_generator_share_the_new_draws():
    env = gymnasium.make("Acrobot-v1")
    env.reset(seed=0)
    env.unwrapped.part = [{"deep": env.unwrapped.np_random, "old": np.random.RandomState(1)}]
    count = len(generators(env))
    drawn = []
    for seed in (1, 1, 2):
        reseed(env, seed)
        drawn.append((env.unwrapped.part[0]["deep"].random(), env.unwrapped.part[0]["old"].random_sample()))
        assert env.unwrapped.part[0]["deep"] is env.unwrapped.np_random
    assert drawn[0] == drawn[1] != drawn[2]
    assert count == len(generators(env)) == 2


def test_what_is_said_of_chance_is_confirmed_by_other_draws():
    subject = Lesson(partial(Line, 1.0), Expert(towards, horizon=4), max_turns=20)
    said = 0
    for seed in range(5):
        oracle, moments = played(subject, [seed % 3] * 20, seed)
        for moment in moments:
            for each in oracle.judge(moment, {HP, HN, FN}):
                said += 1
                assert each.holds(moment, oracle.lab)
                assert each.rollouts == 16
    assert said > 50


@pytest.mark.full
def test_other_draws_seldom_disagree_where_chances_are_worst():
    """Where one outcome in four is another one, all of 16 agree once in a hundred times, and most disagree seldom."""
    subject = Lesson(Rare, Expert(heads), max_turns=1)
    said = false = 0
    for seed in range(6000):
        oracle, (opening, _) = played(subject, [0], seed)
        for each in oracle.judge(opening, {FN}):
            said += 1
            false += not each.holds(opening, oracle.lab)
    assert 20 < said < 120  # 0.75 ** 16 of them are 60
    assert false <= 3  # each with a chance of 0.027


def test_the_bot_is_that_of_the_whole_episode():
    """It plans anew after what the student does, and says what a bot of one's own says that has watched all of it."""
    env = KNOWN["baby"]()
    rng = np.random.default_rng(0)
    actions = [int(each) for each in rng.integers(3, size=25)]
    oracle, moments = played(Lesson(KNOWN["baby"], "expert"), actions, 5)
    env.reset(seed=5)
    bot, taken = BabyAIBot(env), None
    for moment, action in zip(moments, [*actions, None], strict=True):
        wanted = int(bot.replan(taken))
        (advice,) = oracle.judge(moment, {FP})
        assert advice.action == wanted
        assert advice.holds(moment, oracle.lab)
        if action is not None:
            over = env.step(action)[2]
            assert not over
        taken = action


@pytest.mark.parametrize("level", ["BabyAI-KeyInBox-v0", "BabyAI-PutNextS5N2Carrying-v0"])
def test_levels_at_which_the_bot_fails_are_refused(level):
    with pytest.raises(PlanningError, match="MiniGrid's bot fails at levels"):
        Lesson(gymnasium.make(level), "expert")


def test_the_way_of_an_expert_is_shown_where_nothing_is_left_to_chance():
    subject = TOYS["line"]()
    env = llf_teacher.StudentEnv(subject, instruction_type="c")
    env.reset(seed=3)
    (way,) = [atom.claim for atom in env.session.atoms if isinstance(atom.claim, Demonstration)]
    assert len(way.actions) == 20
    world = subject.make_world()
    _, info = world.reset(seed=3)
    for action in way.actions:
        assert action == towards(None, info)
        info = world.step(action)[-1]
    noisy = TOYS["noisy"]()
    assert noisy.make_teacher(noisy.make_world()).oracle.instruction_types == ("b",)


@pytest.mark.parametrize("way", [pickle.dumps, copy.deepcopy])
def test_a_lesson_goes_on_in_a_copy(way):
    env = llf_teacher.StudentEnv(Lesson(Line(0.3), Expert(towards, rollouts=8), max_turns=20))
    env.reset(seed=1)
    env.step(1)
    other = way(env)
    other = pickle.loads(other) if isinstance(other, bytes) else other
    assert other.step(0)[0]["feedback"] == env.step(0)[0]["feedback"] != ""


def test_advice_with_numbers_can_be_written():
    subject = Lesson(partial(Line, box=True), Expert(steer), max_turns=20)
    env = llf_teacher.StudentEnv(subject, text=True, privileged_info=True)
    info = env.reset(seed=1)[1]
    for _ in range(8):
        (advice,) = [atom.claim for atom in info["atoms"] if isinstance(atom.claim, Around)]
        info = env.step(advice.answer)[-1]
        assert info["moment"].action == advice.action
        assert not {type(atom.claim) for atom in info["atoms"]} & {Behind, Ahead}
    oracle, (opening, _) = played(subject, [np.zeros(2, np.float32)], 1)
    (advice,) = oracle.judge(opening, {FP})
    near = oracle.lab.legal(np.asarray(advice.action, np.float32) * np.float32(0.9))
    far = oracle.lab.legal(np.asarray(advice.action, np.float32) * np.float32(0.4))
    assert Around(action=near, answer="?", tolerance=0.05).holds(opening, oracle.lab)
    assert not Around(action=far, answer="?", tolerance=0.05).holds(opening, oracle.lab)
    assert not Around(action=near, answer="?", tolerance=0.5).holds(opening, oracle.lab)


class Model:
    """Has the interface of Stable-Baselines3's models."""

    def predict(self, observation, state=None, episode_start=None, deterministic=False):
        assert deterministic
        return np.array(1 + int(observation[0] < -0.5) - int(observation[0] > 0.5)), state


def test_a_model_is_an_expert():
    one, other = (played(Lesson(Line, Expert(policy), max_turns=20), [0, 1, 2], 2) for policy in (Model(), towards))
    assert [one[0].judge(each) for each in one[1]] == [other[0].judge(each) for each in other[1]]


class Moody:
    """An expert that pushes to the right, but for a fault where it stands near 0."""

    fault = None

    def __init__(self):
        self.asked = 0

    def __call__(self, observation, info):
        self.asked += 1
        return self.fault(self.asked) if self.fault and abs(observation[0]) < 2 else 2


def faulty(asked):
    raise KeyError("lost")


class Always:
    """An expert with a fault everywhere."""

    def __init__(self, fault):
        self.fault, self.asked = fault, 0

    def __call__(self, observation, info):
        self.asked += 1
        return self.fault(self.asked)


FAULTS = {
    r"the expert raised KeyError\('lost'\)": faulty,
    "the expert gave 7, which is no action; allowed: an integer from 0 to 2": lambda asked: 7,
    "the expert changes its mind: asked twice in one state it gave . and .; make it deterministic": lambda asked: (
        asked // 3 % 2
    ),
}


@pytest.mark.parametrize("message", FAULTS)
def test_an_expert_that_fails_at_once_is_refused(message):
    with pytest.raises(PlanningError, match=message):
        Lesson(Line, Expert(Always(FAULTS[message])))


@pytest.mark.parametrize("message", FAULTS)
def test_the_teacher_is_silent_where_the_expert_fails(message):
    """The lesson goes on, and what is said elsewhere is checked."""
    expert = Moody()
    subject = Lesson(Line, Expert(expert, horizon=1), max_turns=20)
    world = subject.make_world()
    oracle = subject.make_teacher(world).oracle
    next(seed for seed in range(99) if world.reset(seed=seed)[0][0] < -4)
    expert.fault = FAULTS[message] if "mind" not in message else lambda asked: asked % 2

    def play():
        for turn in range(8):
            moment = Moment.opening(world.truth, turn)
            claims = oracle.judge(moment)
            assert all(each.holds(moment, oracle.lab) for each in claims)
            yield world.truth.seen[0], claims
            world.step(2)

    with pytest.warns(ExpertWarning, match=message):
        said = list(play())
    assert all(bool(each) == (abs(at) >= 2) for at, each in said)
    assert sum(oracle.silences.values()) == 2 * sum(not each for _, each in said) > 0


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda: Lesson(Line, "expert"), r"no expert is known; pass oracle=Expert\(policy=f\)"),
        (lambda: Expert(policy=3), r"policy must be a function \(observation, info\) -> action, .* got 3"),
        (lambda: Expert(rollouts=2), "rollouts must be an integer of at least 8, got 2"),
        (lambda: Expert(horizon=0), "horizon must be an integer of at least 1, got 0"),
        (lambda: Expert(others=-1), "others must be an integer of at least 0, got -1"),
        (lambda: Expert(tolerance=0), "tolerance must be a positive number, got 0"),
        (lambda: Expert(margin=float("nan")), "margin must be a positive number, got nan"),
        (lambda: Lesson(Unseeded, Expert(towards)), "the same seed and actions had two results"),
        (lambda: Lesson(Shared, Expert(towards)), "draws from the generators that all of Python or NumPy share"),
    ],
)
def test_what_does_not_serve_is_refused_with_the_reason(make, match):
    with pytest.raises(ValueError, match=match):
        make()


class Unseeded(Line):
    """Draws from a generator of its own, which nobody seeds."""

    luck = staticmethod(np.random.default_rng().normal)

    def step(self, action):
        self.at += Unseeded.luck()
        return super().step(action)


class Shared(Line):
    """Draws from the generator that all share, which it seeds."""

    def reset(self, *, seed=None, options=None):
        random.seed(seed)
        return super().reset(seed=seed)

    def step(self, action):
        self.at += random.gauss(0, 1)
        return super().step(action)


def test_it_says_nothing_of_values():
    subject = TOYS["line"]()
    oracle, (opening, moment) = played(subject, [0])
    assert oracle.values(opening.after) is None
    assert oracle.importance(opening.after) == 0
    with pytest.raises(RefusalError, match="gives no values"):
        oracle.regret(moment)
    assert oracle.abilities() == {"hindsight", "advice"}


def test_a_lesson_says_what_it_rests_on():
    assert list(TIERS)[-1] == "expert"
    plan = Lesson(KNOWN["lander"], "expert").planned
    assert plan.tier == "expert"
    assert plan.privileged
    assert "16 for each comparison" in plan.why
    assert TOYS["line"]().planned.privileged is None
    assert "nothing was found to be left to chance" in TOYS["line"]().planned.why
    assert {each.kind for each in (Ahead, Followed)} == {HP}
    assert {Behind.kind, Costs.kind} == {HN, FN}


class Short(gymnasium.Env):
    """An environment whose steps lack a part."""

    observation_space, action_space = spaces.Discrete(2), spaces.Discrete(2)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return 0, {}

    def step(self, action):
        return 0, float("nan"), False, False


class Nothing(Short):
    """One whose rewards are no numbers."""

    def step(self, action):
        return *super().step(action), {}


@pytest.mark.parametrize("oracle", ["auto", "exact", Expert(lambda observation, info: 1)])
def test_what_cannot_be_stepped_is_refused(oracle):
    with pytest.raises(PlanningError, match=r"cannot be reset and stepped as Gymnasium demands.*check_env"):
        llf_teacher.teach(Short, oracle=oracle)


def test_rewards_that_are_no_numbers_are_not_compared():
    env = llf_teacher.teach(Nothing, oracle=Expert(lambda observation, info: 1), max_turns=5)
    env.reset(seed=0)
    assert {atom.kind for atom in env.step(0)[-1]["atoms"]} == {FP, R}


class Lure(gymnasium.Env):
    """Action 2 pays 100, others cost 1 and 2."""

    observation_space, action_space = spaces.Discrete(9), spaces.Discrete(3)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.count = 0
        return 0, {}

    def step(self, action):
        self.count += 1
        return self.count, (-1.0, -2.0, 100.0)[int(action)], self.count == 8, False, {}


def test_an_environment_that_was_drawn_is_still_taught():
    """Its window cannot be copied."""
    pole = gymnasium.make("CartPole-v1", render_mode="rgb_array")
    env = llf_teacher.teach(pole, oracle=Expert(lambda seen, info: int(seen[2] + seen[3] > 0), horizon=20))
    for seed in (1, 2):
        env.reset(seed=seed)
        assert env.session.world.env.render().ndim == 3
        assert FP in {atom.kind for atom in env.step(0)[-1]["atoms"]}


@pytest.mark.parametrize("personality", ["myopic", "noisy"])
def test_personalities_that_need_values_are_refused(personality):
    with pytest.raises(ValueError, match=f"personality '{personality}.*' needs"):
        llf_teacher.StudentEnv(TOYS["line"](), teacher=personality)


@pytest.mark.parametrize("personality", ["verification", "elaborator", "vague(q=1)", "sycophant"])
def test_no_personality_calls_a_comparison_good_or_bad(personality):
    """The expert takes what pays -1, where another action pays 100."""
    env = llf_teacher.teach(Lure, oracle=Expert(heads), max_turns=8, teacher=personality, privileged_info=True)
    info = env.reset(seed=0)[1]
    said = [atom.claim for atom in info["atoms"]]
    for action in (0, 1, 2, 0):
        said += [atom.claim for atom in env.step(action)[-1]["atoms"]]
    assert not {type(claim) for claim in said} & {Right, Wrong, PartlyRight, Chance, Trap}
    assert {type(claim) for claim in said} & {Would, Followed} or personality == "verification"
    oracle, (opening, moment) = played(Lesson(Lure, Expert(heads), max_turns=8), [0])
    (praise,), advice = oracle.judge(moment, {HP}), oracle.judge(opening, {FP, FN})
    assert praise.holds(moment, oracle.lab)
    assert not Right.on((praise,), action=0).holds(moment, oracle.lab)
    assert not Right(action=0).means(moment, oracle)
    assert not any(cls.on(each).holds(opening, oracle.lab) for cls, each in zip((Chance, Trap), advice, strict=True))
    assert not any(cls().means(opening, oracle) for cls in (Chance, Trap))


class Dart(gymnasium.Env):
    """A throw earns 5 less its distance from 0.123 on a scale; 10 if it is there."""

    observation_space = spaces.Box(-1, 1, (1,), np.float32)

    def __init__(self, scale=1.0, wrap=False):
        self.scale, self.wrap = scale, wrap
        self.action_space = spaces.Box(-scale, scale, (1,), np.float32)
        if wrap:
            self.action_space = spaces.Dict(to=spaces.Tuple([self.action_space]))

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return np.zeros(1, np.float32), {}

    def step(self, action):
        at = float((action["to"][0] if self.wrap else action)[0]) / self.scale
        return np.zeros(1, np.float32), 10.0 if abs(at - 0.123) < 1e-6 else 5 - abs(at - 0.123), True, False, {}

    def throw(self, at):
        """The action."""
        at = np.array([at * self.scale], np.float32)
        return {"to": (at,)} if self.wrap else at


@pytest.mark.parametrize("wrap", [False, True])
@pytest.mark.parametrize("scale", [1.0, 0.001])
def test_an_expert_is_followed_as_it_acts_and_said_to_within_a_tolerance(scale, wrap):
    """Rounded, its throw would earn 5."""
    make = partial(Dart, scale, wrap)
    aim = make().throw
    env = llf_teacher.teach(make, oracle=Expert(lambda *_: aim(0.123)), max_turns=1, privileged_info=True)
    info = env.reset(seed=0)[1]
    (advice,) = [atom.claim for atom in info["atoms"] if atom.kind is FP]
    assert isinstance(advice, Around)
    assert advice.tolerance == pytest.approx(0.05 * scale)
    (blame,) = [atom.claim for atom in env.step(aim(0.9))[-1]["atoms"] if atom.kind is HN]
    assert blame.amount == pytest.approx(5.78)
    env.reset(seed=0)
    praise = [atom.claim for atom in env.step(aim(0.09))[-1]["atoms"] if atom.kind is HP]
    assert [(type(each), each.tolerance) for each in praise] == [(Neared, advice.tolerance)]
    lab, moment = env.teacher.oracle.lab, env.session.moment
    assert praise[0].holds(moment, lab)
    assert not Neared(
        **{name: getattr(praise[0], name) for name in Followed.__dataclass_fields__}, tolerance=1.0
    ).holds(moment, lab)
    with pytest.raises(
        PlanningError, match=r"says nothing of an action with a number that ranges over .*; allowed: less"
    ):
        Lesson(make, Expert(lambda *_: aim(0.123), tolerance=1.01 * scale))


class Race(gymnasium.Env):
    """From 10 to a goal, which is not seen, in 8 steps; only the last one pays: what was lost."""

    observation_space, action_space = spaces.Discrete(21), spaces.Discrete(2)

    def __init__(self, copies=True):
        self.goal, self.copies, self.resets = 20, copies, [0]

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.at, self.count = 10, 0
        self.resets[0] += 1
        return 10, {"start": self.at}

    def step(self, action):
        self.count, self.at = self.count + 1, self.at + (-1, 1)[int(action)]
        over = self.count == 8
        return self.at, -float(abs(self.at - self.goal)) * over, over, False, {"start": 10}

    def __deepcopy__(self, memo):
        if not self.copies:
            raise TypeError("no copies")
        other = type(self)()
        other.__dict__ |= {name: copy.deepcopy(part, memo) for name, part in self.__dict__.items()}
        return other


class Restless(Race):
    """Its goal is another one from the 3,000th reset on, long after it was planned."""

    def step(self, action):
        self.goal = 20 if self.resets[0] < 3000 else 0
        return super().step(action)


def right(observation, info):
    assert info["start"] == 10
    return 1


def compared(info):
    """What was measured, by the class of the claim, and less than 0 if it is less."""
    signs = {Followed: 1, Ahead: 1, Behind: -1, Costs: -1}
    said = [atom.claim for atom in info["atoms"] if type(atom.claim) in signs]
    return {type(each): signs[type(each)] * each.amount for each in said}


@pytest.mark.parametrize("copies", [True, False])
def test_roll_outs_begin_in_the_very_state(copies):
    """The goal is moved after the lesson was made: before an episode, and within one."""
    base = Race(copies)
    lesson = Lesson(base if copies else partial(Race, False), Expert(right))
    env = llf_teacher.StudentEnv(lesson, privileged_info=True)
    base = env.session.world.env
    assert compared(env.reset(seed=0)[1]) == {Costs: -2}
    base.goal = 0
    if copies:
        assert compared(env.reset(seed=0)[1]) == {}  # what the expert does costs 2 now
        assert compared(env.step(0)[-1]) == {Ahead: 2}
        assert compared(env.step(1)[-1]) == {}
    else:
        with pytest.warns(ExpertWarning, match="cannot be replayed: that gave another value of goal"):
            assert compared(env.reset(seed=0)[1]) == {}
    base.goal = 20
    assert compared(env.reset(seed=0)[1]) == {Costs: -2}
    assert compared(env.step(0)[-1]) == {Behind: -2, Costs: -2}
    base.goal = 0
    env.teacher.oracle.silences.clear()
    with pytest.warns(ExpertWarning, match="cannot be replayed: that gave another value of goal"):
        assert compared(env.step(0)[-1]) == {}
    assert env.teacher.oracle.silences


def test_roll_outs_begin_in_the_very_state_of_a_world_that_ages(long_trials):
    env = llf_teacher.StudentEnv(Lesson(Restless(), Expert(right)), privileged_info=True)
    while env.session.world.env.resets[0] < 3000:
        said = compared(env.reset(seed=0)[1])
    assert said == {}
    assert compared(env.step(0)[-1]) == {Ahead: 2}


class Gale(gymnasium.Env):
    """A walk on which a wind blows from step 26 on, when no trial looks any more."""

    observation_space, action_space = spaces.Box(-200, 200, (2,), np.float32), spaces.Discrete(2)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.at = self.count = 0
        return np.zeros(2, np.float32), {}

    def step(self, action):
        self.count += 1
        self.at += (-1, 1)[int(action)] + (int(self.np_random.integers(-3, 4)) if self.count > 25 else 0)
        return np.array([self.at, self.count], np.float32), -float(abs(self.at)), False, self.count >= 50, {}


def back(observation, info):
    return int(observation[0] < 0)


def test_chance_after_the_trial_is_measured_by_many_roll_outs():
    found = audit(Lesson(Gale, Expert(back, rollouts=8, horizon=20), max_turns=50), turns=40, students=("random",))
    assert found.count(Label.DISTORTED) == found.contradictions == 0 < found.checked
    subject = Lesson(Gale, Expert(back, horizon=20), max_turns=50)
    assert "nothing was found to be left to chance" in subject.planned.why
    oracle, moments = played(subject, [1] * 40)
    said = [(moment.turn, each.rollouts) for moment in moments for each in oracle.judge(moment, {HN, FN})]
    assert {rollouts for turn, rollouts in said if turn <= 5} == {1}
    assert {rollouts for turn, rollouts in said if turn > 10} == {16}
    (way,) = oracle.brief(moments[0].after, "c")[3:]
    assert len(way.actions) == 20
    oracle, moments = played(Lesson(Gale, Expert(back), max_turns=50), [])
    (way,) = oracle.brief(moments[0].after, "c")[3:]
    assert len(way.actions) == 26  # the last one is chosen before the wind blows
    assert way.holds(moments[0], oracle.lab)


class Jam(gymnasium.Env):
    """A motor that jams farther on than trials come."""

    observation_space, action_space = spaces.Discrete(99), spaces.Discrete(2)
    far = 30

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.at = 0
        return 0, {}

    def step(self, action):
        if self.at == self.far:
            raise RuntimeError("motor jammed")
        self.at = max(0, self.at + (-1, 1)[int(action)])
        return self.at, float(self.at), False, False, {}


def test_a_lesson_goes_on_where_a_roll_out_raises(monkeypatch):
    env = llf_teacher.teach(Jam, oracle=Expert(lambda *_: 1), max_turns=40, privileged_info=True)
    with pytest.warns(
        ExpertWarning, match=r"no warning in turn 0: the environment raised RuntimeError\('motor jammed'\)"
    ):
        info = env.reset(seed=0)[1]
    assert [type(atom.claim) for atom in info["atoms"] if atom.kind] == [Would]
    assert list(env.teacher.oracle.silences) == [
        "the environment raised RuntimeError('motor jammed') after action 1 when it was tried"
    ]
    env.teacher.oracle.silences.clear()
    with pytest.warns(ExpertWarning, match=r"no (praise or blame|warning) in turn 1"):
        info = env.step(0)[-1]
    assert [atom.kind for atom in info["atoms"]] == [R, FP]
    monkeypatch.setattr(Jam, "far", 3)
    with pytest.raises(PlanningError, match=r"motor jammed.* \(step \d+ after reset\(seed=0\)\)"):
        Lesson(Jam, Expert(lambda *_: 1), max_turns=40)


def test_an_expert_that_tosses_a_coin_is_found_out():
    """Its answers differ in all but one state of 128, and not yet in the trial."""
    coin = random.Random(0)
    tossing = []
    subject = Lesson(Line, Expert(lambda *_: coin.randrange(2) if tossing else 0, horizon=1), max_turns=40)
    oracle, moments = played(subject, [1] * 40)
    tossing.append(1)
    with pytest.warns(ExpertWarning, match="changes its mind"):
        said = [bool(oracle.judge(moment, {FP})) for moment in moments]
    assert sum(said) <= 2


def test_an_expert_is_asked_as_often_as_the_page_says():
    asked = []
    env = llf_teacher.teach(Line, oracle=Expert(lambda *_: asked.append(1) or 1, horizon=10), max_turns=20)
    env.reset(seed=0)
    counts = []
    for turn in range(9):
        asked.clear()
        env.step(turn % 3)
        counts.append(len(asked))
    assert max(counts) <= 4 * 10 + 16  # of which each state's own question has eight


@dataclasses.dataclass(slots=True)
class Dice:
    """Holds a generator in a slot."""

    source: np.random.Generator


def yielding(source):
    while True:
        yield source.random()


DICE = {  # what holds the generator of an environment, and how that draws a number from 0 to 1
    "slot": (Dice, lambda held: held.source.random()),
    "set": (lambda source: {source}, lambda held: next(iter(held)).random()),
    "closure": (lambda source: lambda: source.random(), lambda held: held()),
    "default": (lambda source: lambda of=source: of.random(), lambda held: held()),
    "method": (lambda source: source.random, lambda held: held()),
    "partial": (lambda source: partial(source.integers, 2), lambda held: held()),
    "bits": (lambda source: source.bit_generator, lambda held: held.random_raw() / 2**64),
    "array": (lambda source: np.array([source, None], object), lambda held: held[0].random()),
}


SHARED = {
    "closure": "it holds the function .*, which closes over source; copies share that",
    "default": "it holds the function .*, which has as a default a mutable value; copies share that",
}


class Bet(gymnasium.Env):
    """A coin each turn; action 0 bets on heads, 1 on tails, and 2 does not bet.

    Args:
        held: a name of `DICE`.
    """

    observation_space, action_space = spaces.Discrete(8), spaces.Discrete(3)

    def __init__(self, held):
        self.held = held

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.turn = 0
        self.dice = DICE[self.held][0](np.random.default_rng(int(self.np_random.integers(2**31))))
        return 0, {}

    def step(self, action):
        self.turn += 1
        won = 1.0 if DICE[self.held][1](self.dice) < 0.5 else -1.0
        return self.turn, (won, -won, 0.0)[action], self.turn == 6, False, {}


@pytest.mark.parametrize("held", DICE)
def test_a_generator_is_found_wherever_it_is_held(held):
    """A fair bet is neither gained nor lost; and no transitions are believed."""
    if held in SHARED:
        with pytest.raises(PlanningError, match=SHARED[held]):
            Lesson(partial(Bet, held), Expert(lambda observation, info: 2))
        return
    subject = Lesson(partial(Bet, held), Expert(lambda observation, info: 2))
    assert "16 for each comparison" in subject.planned.why
    seat = llf_teacher.StudentEnv(subject)
    assert not [atom for seed in range(3) for atom in seat.reset(seed=seed)[1]["atoms"] if type(atom.claim) is Costs]
    with pytest.raises(PlanningError, match=r"chance decides what actions do|copies do not continue"):
        Lesson(partial(Bet, held), Exact(state=lambda env: env.unwrapped.turn))


class Torch:
    """Has the methods of PyTorch's generators."""

    def __init__(self):
        self.source = random.Random(0)

    def manual_seed(self, seed):
        self.source.seed(seed)

    def get_state(self):
        return self.source.getstate()

    def set_state(self, state):
        self.source.setstate(state)


def test_a_generator_like_that_of_torch_is_given_other_draws():
    env = Line()
    env.torch = Torch()
    before = env.torch.get_state()
    reseed(env, 1)
    assert generators(env)[0] is env.torch
    assert env.torch.get_state() != before


class Sealed(Line):
    """Holds an object of a module in C, which may draw."""

    def reset(self, **given):
        self.part = memoryview(b"...")
        return super().reset(**given)

    def __deepcopy__(self, memo):
        return super().__reduce_ex__(4)[0](type(self))


def test_where_an_object_cannot_be_looked_into_there_may_be_chance():
    subject = Lesson(Sealed, Expert(lambda observation, info: 1), snapshot="replay")
    assert "16 for each comparison, for its attribute 'part', into which Python cannot look, may" in subject.planned.why
    with pytest.raises(PlanningError, match=r"'part', into which .* may draw random numbers; hold it in Python"):
        Lesson(Sealed, Exact(state=lambda env: env.unwrapped.cell))


@pytest.mark.parametrize("wrap", ["NormalizeReward", "NormalizeObservation"])
def test_a_wrapper_that_remembers_other_episodes_is_named(wrap):
    match = f"{wrap} around it, keeps something from one episode" if wrap == "NormalizeReward" else "two results"
    with pytest.raises(PlanningError, match=match):
        Lesson(lambda: getattr(gymnasium.wrappers, wrap)(Line()), Expert(lambda seen, info: int(seen[0] > 0)))
