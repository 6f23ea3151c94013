"""Planned oracles: what they say of environments that bring none, and which environments they refuse."""

import enum
import itertools
import random
import time
from functools import cache, partial
from typing import ClassVar

import gymnasium
import numpy as np
import pytest
from design import amount
from gymnasium.envs.toy_text.blackjack import BlackjackEnv, draw_card
from gymnasium.envs.toy_text.frozen_lake import FrozenLakeEnv
from gymnasium.envs.toy_text.taxi import TaxiEnv
from minigrid.core.world_object import Lava
from minigrid.envs.empty import EmptyEnv

import llf_teacher
from llf_teacher.tools.audit import audit
from pz_envs.lesson import Lesson
from pz_envs.settings import Settings
from teachers.atoms import FN, FP, HN, HP, Label, Moment, R
from teachers.common import NoDifference
from teachers.planning import Exact, Expert, PlanningError, progress, survey
from teachers.planning.exact.claims import Avoid, Dawdle, Fading, PoorlyChosen, Slower, Total
from teachers.planning.known import Known, known, words_of
from teachers.planning.planner import RewardsOnlyWarning
from teachers.planning.state_key import comparable, other_parts
from teachers.testing import Pupil, check_oracle
from worlds.wrapped.layers import copied
from worlds.wrapped.position import Position

pytestmark = pytest.mark.usefixtures("short_trials")


def taxi():
    return gymnasium.wrappers.TimeLimit(TaxiEnv(), 200)


def lake(**options):
    return gymnasium.make("FrozenLake-v1", map_name="8x8", **options)


ENVIRONMENTS = {
    "lake": lake,
    "taxi": taxi,
    "cliff": lambda: gymnasium.make("CliffWalking-v1"),
    "blackjack": lambda: gymnasium.make("Blackjack-v1"),
    "door": lambda: gymnasium.make("MiniGrid-DoorKey-5x5-v0"),
}
on_every_environment = pytest.mark.parametrize("name", ENVIRONMENTS)


def lesson(name, **options):
    return Lesson(ENVIRONMENTS[name], Exact(**options))


@on_every_environment
def test_a_planned_oracle_passes_the_kit(name):
    subject = lesson(name)
    check_oracle(
        Pupil(subject.make_world, subject.make_teacher, max_turns=subject.max_turns, turns=amount(12, full=40))
    )


def test_with_a_discount_it_passes_the_kit():
    subject = lesson("lake", gamma=0.95)
    check_oracle(Pupil(subject.make_world, subject.make_teacher, max_turns=subject.max_turns, turns=40))
    env = llf_teacher.StudentEnv(subject, text=True)
    assert "0.95" in env.reset(seed=0)[0]["instruction"]


@on_every_environment
def test_no_claim_is_false_and_lies_are_caught(name):
    subject = lesson(name)
    honest = audit(subject, turns=60, students=("random", "obedient"))
    assert honest.count(Label.DISTORTED) == honest.contradictions == honest.leaks == 0 < honest.checked
    liar = audit(lesson(name), "mistake(eps=1)", turns=60, students=("random",))
    assert liar.count(Label.TRUTHFUL) == sum(n for (kind, _), n in liar.claims.items() if kind is None)


@pytest.mark.parametrize(
    ("name", "episodes"),
    [("lake", 400), ("blackjack", 3000), ("cliff", 20), ("taxi", 50), pytest.param("door", 3, marks=pytest.mark.full)],
)
def test_values_are_what_the_best_actions_earn(name, episodes):
    """In the environment itself, each time from another state that random actions reach."""
    subject = lesson(name)
    world, rng, missed = subject.make_world(), np.random.default_rng(1), []
    oracle = subject.make_teacher(world).oracle
    for seed in range(episodes):
        world.reset(seed=seed)
        oracle.start(world.truth)
        over, worth, earned, lead = False, None, 0.0, rng.integers(8)
        while not over:
            values = oracle.values(world.truth)
            if lead <= 0 and worth is None:
                known = oracle.model.at(world.truth, oracle.lab)
                worth = known.best(known.worths(world.truth.seen, world.truth.turn)).earned
            action = world.sample_action(rng) if worth is None else values.index(max(values))
            _, reward, terminated, truncated, _ = world.step(action)
            over, lead = terminated or truncated or world.truth.turn >= subject.max_turns, lead - 1
            earned += 0.0 if worth is None else reward
        if worth is not None:
            missed.append(earned - worth)
    assert len(missed) > episodes / 8
    assert np.mean(missed) == pytest.approx(0, abs=max(1e-9, 4 * np.std(missed) / len(missed) ** 0.5))


@pytest.mark.full
@pytest.mark.parametrize(("name", "plays"), [("lake", 40), ("blackjack", 300), ("cliff", 1), ("taxi", 1), ("door", 1)])
def test_roll_outs_from_fifty_states_earn_what_is_expected(name, plays):
    """From the same state again and again, each time with other draws."""
    subject = lesson(name)
    world, rng = subject.make_world(), np.random.default_rng(2)
    lab = world.scratch()
    oracle = subject.make_teacher(world).oracle
    missed = []
    for seed in range(50):
        world.reset(seed=seed)
        oracle.start(world.truth)
        for _ in range(rng.integers(6)):
            before = world.truth
            if any(world.step(world.sample_action(rng))[2:4]):
                world.restore(before)
                break
        place = world.truth
        values = oracle.model.at(place, oracle.lab)
        expected, earned = values.best(values.worths(place.seen, place.turn)).earned, []
        for play in range(plays):
            lab.restore(place)
            bare = lab.env.unwrapped
            bare.np_random = np.random.default_rng([seed, play])
            if name == "blackjack":  # what the student does not see is averaged over, too
                bare.dealer[1] = draw_card(bare.np_random)
            total, over, turn = 0.0, False, place.turn
            while not over and turn < subject.max_turns:
                now = values.ranked(values.worths(place.seen if turn == place.turn else lab.truth.seen, turn))
                _, reward, terminated, truncated, _ = lab.advance(now.index(max(now)))
                total, over, turn = total + reward, terminated or truncated, turn + 1
            earned.append(total)
        error = np.std(earned) / len(earned) ** 0.5
        missed.append((np.mean(earned) - expected) / max(error, 1e-9) if error else np.mean(earned) - expected)
    assert len(missed) == 50
    if plays == 1:
        assert missed == pytest.approx([0.0] * 50, abs=1e-9)
    else:  # standard errors, whose mean square is near 1
        assert np.max(np.abs(missed)) < 5
        assert np.mean(np.square(missed)) < 2


def test_the_teacher_knows_nothing_of_the_luck_to_come():
    """Whatever the coming draws are, the same state and turn get the same words, and a slip is not blamed."""
    subject = lesson("lake")
    world = subject.make_world()
    oracle = subject.make_teacher(world).oracle
    said, slips = {}, 0
    for seed in range(300):
        world.reset(seed=seed)
        oracle.start(world.truth)
        for turn in range(6):
            before = world.truth
            advice = oracle.judge(Moment.opening(before, turn))
            assert said.setdefault((before.seen, turn), advice) == advice
            action = next(each.action for each in advice if each.kind is FP) if advice else 0
            _, reward, terminated, truncated, _ = world.step(action)
            verdict = oracle.judge(Moment(before, action, reward, world.truth, False, turn + 1, False), {HP, HN})
            assert [each.kind for each in verdict] == [HP] * bool(advice)
            slips += max(oracle.values(world.truth)) < max(oracle.values(before)) - oracle.model.spread / 1000
            if terminated or truncated:
                break
    assert slips > 50


def test_advice_arrives():
    """With a sum of rewards without discount the end of the turns counts, so that no detour is as good as the way."""
    env = llf_teacher.teach(lake(is_slippery=False), oracle="auto", success=lambda *step: step[1] > 0)
    info, turns = env.reset(seed=0)[1], 0
    while not info.get("success"):
        (advice,) = [atom.claim for atom in info["atoms"] if atom.kind is FP]
        _, _, _, truncated, info = env.step(advice.action)
        turns += 1
        assert not truncated
    assert turns == 14


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda: gymnasium.make("CartPole-v1"), "no table of transitions `P`; .* real numbers in state, which hardly"),
        (
            lambda: gymnasium.wrappers.TransformReward(lake(), lambda reward: 2 * reward - 1),
            "does not say what happens",
        ),
        (  # random play does not reach the goal
            lambda: gymnasium.wrappers.TransformReward(lake(), lambda reward: -reward),
            "does not say what happens: .* led to None for -1",
        ),
        (lambda: gymnasium.make("MiniGrid-Dynamic-Obstacles-5x5-v0"), "chance decides what actions do"),
        (lambda: gymnasium.make("Pendulum-v1"), r"no table of transitions `P`; .* pass oracle=Exact\(state=f\)"),
    ],
)
def test_what_is_not_known_is_refused_with_the_reason(make, match):
    with pytest.raises(PlanningError, match=match):
        llf_teacher.teach(make, oracle="exact")


class Tables(gymnasium.Env):
    """Has a table of transitions that begin and end in its one state, and does not tell that it is in it."""

    P: ClassVar = {0: {0: [(1.0, 0, 0.0, False)]}}
    observation_space = action_space = gymnasium.spaces.Discrete(1)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.hidden = object()
        return 0, {}

    def step(self, action):
        return 0, 0.0, False, False, {}


def test_a_table_needs_the_state():
    with pytest.raises(PlanningError, match="has a table `P`, but no attribute `s`"):
        Lesson(Tables, "exact")


def test_the_state_must_be_hashable():
    with pytest.raises(
        TypeError, match=r"state must give something hashable, such as a tuple or bytes, got \(0, \[\]\)"
    ):
        Lesson(Tables, Exact(state=lambda env: (0, [])))


class Walk(gymnasium.Env):
    """Four cells in a row, with a state of many kinds."""

    observation_space, action_space = gymnasium.spaces.Discrete(4), gymnasium.spaces.Discrete(2)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.cells, self.seen, self.notes = np.eye(4, dtype=np.int64)[0], {0}, {"last": None, "all": [0.0]}
        return 0, {}

    def step(self, action):
        place = min(max(int(self.cells.argmax()) + 2 * int(action) - 1, 0), 3)
        self.cells = np.eye(4, dtype=np.int64)[place]
        return place, float(place == 3), place == 3, False, {}


class Told(Walk):
    """Says what its state is, and has parts that cannot be compared."""

    def reset(self, **options):
        self.part = object()
        return super().reset(**options)

    def get_state(self):
        return self.cells


class Drifting(Walk):
    """Its state has a real number."""

    def step(self, action):
        self.notes["all"] = [float(self.np_random.random())]
        return super().step(action)


@pytest.mark.parametrize("make", [Walk, Told])
def test_states_are_read_from_the_environment(make):
    assert Lesson(make, "exact", max_turns=9).planned.size == "4 states"


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (Drifting, "its state has real numbers in notes, which hardly recur"),
        (lambda: gymnasium.wrappers.FrameStackObservation(Walk(), 2), "the wrapper FrameStackObservation may have"),
    ],
)
def test_states_that_cannot_be_read_are_refused(make, match):
    with pytest.raises(PlanningError, match=match):
        Lesson(make, "exact", max_turns=9)


def test_each_tier_says_what_it_can():
    found = survey(gymnasium.make("CartPole-v1"), 100)
    assert list(found) == ["exact", "expert"]
    assert all(isinstance(each, PlanningError) for each in found.values())
    assert survey(lake(), 100)["exact"].size == "64 states"


def test_where_no_tier_serves_rewards_are_said_and_a_warning_says_what_would_give_more():
    match = r"exact: .*real numbers(.|\n)*\n- expert: .*pass oracle=Expert(.|\n)*says what was paid, and no more"
    with pytest.warns(RewardsOnlyWarning, match=match):
        env = llf_teacher.teach(gymnasium.make("CartPole-v1"), oracle="auto")
    plan = env.family.planned
    assert plan.tier == "rewards"
    assert list(plan.refused) == ["exact", "expert"]
    assert env.teacher.oracle.feedback_types == ("r",)
    env.reset(seed=0)
    assert [atom.kind for atom in env.step(0)[-1]["atoms"]] == [R]
    with pytest.warns(RewardsOnlyWarning):
        words = Lesson(Easy, "auto").planned.action_words
    assert words == {"stick": 0, "hit": 1}


def test_long_planning_shows_a_bar(monkeypatch):
    """On a terminal, after a second; elsewhere nothing is written."""
    shown = []
    monkeypatch.setattr(progress, "_PATIENCE", -1.0)
    monkeypatch.setattr(progress.sys.stderr, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(progress.ProgressBar, "__exit__", lambda bar, *error: shown.append(bar._bar) or bar._bar.stop())
    Lesson(Walk, "exact", max_turns=9)
    (task,) = shown[0].tasks
    assert task.total >= task.completed > 0


def test_what_the_student_sees_of_an_unknown_environment_is_not_claimed():
    assert Lesson(Tables, Exact(state=lambda env: 0)).planned.privileged is None
    assert Lesson(lake(), "auto").planned.privileged is False


@pytest.mark.parametrize(("lost", "time"), [(1.0, "1 action"), (2.0, "2 actions"), (0.5, "0.5 actions")])
def test_time_is_counted_in_actions(lost, time):
    assert Slower(action=0, answer="left", lost=lost).time == Dawdle(action=0, answer="left", lost=lost).time == time


def test_bounds_are_met():
    with pytest.raises(PlanningError, match=r"more than \d+ states can be reached, .* the bounds are states=100"):
        lesson("door", states=100)
    with pytest.raises(PlanningError, match="give max_turns or gamma"):
        Lesson(lake(max_episode_steps=100_000), "exact")


def test_states_that_look_alike_are_found_out():
    with pytest.raises(PlanningError, match="two states have the same key and differ"):
        lesson("door", state=lambda env: (tuple(env.unwrapped.agent_pos), int(env.unwrapped.agent_dir)))


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"oracle": "best"}, "oracle must be a subclass .* name of one .auto, exact, .*., got 'best'"),
        ({"oracle": "auto", "look": len}, "leave out look"),
        ({"oracle": "auto", "phrases": {}}, "leave out look"),
    ],
)
def test_bad_arguments_are_named(options, match):
    with pytest.raises(ValueError, match=match):
        llf_teacher.teach(lake(), **options)
    with pytest.raises(ValueError, match="gamma must be None or a number from 0 to below 1, got 1"):
        Exact(gamma=1)


def test_a_lesson_says_what_it_rests_on():
    plan = lesson("door").planned
    assert plan.tier == "exact"
    assert plan.privileged
    assert "states that can be reached" in plan.why
    assert llf_teacher.teach(lake(), oracle="auto").teacher.oracle.tier == "exact"


def test_the_plan_is_for_the_turns_of_the_lesson():
    env = llf_teacher.teach(lake(), oracle="auto", max_turns=7)
    assert "at most 7 actions" in env.reset(seed=0)[0]["instruction"]
    assert env.session.teacher.oracle.model.horizon == env.session.max_turns == 7
    settings = Settings(max_turns=9)
    assert llf_teacher.teach(lake(), oracle="auto", settings=settings).session.teacher.oracle.model.horizon == 9
    subject = lesson("lake")
    assert llf_teacher.StudentEnv(subject, max_turns=subject.max_turns).session.max_turns == 100
    with pytest.raises(ValueError, match="planned for episodes of 100 turns, got max_turns 7"):
        llf_teacher.StudentEnv(subject, max_turns=7)
    assert llf_teacher.StudentEnv(lesson("lake", gamma=0.9), max_turns=7).session.max_turns == 7
    with pytest.raises(ValueError, match=r"max_turns .* must be an integer of at least 1, got 0"):
        llf_teacher.teach(lake(), oracle="auto", max_turns=0)


def best_by_hand(table, horizon, gamma):
    """The value of each action in each state and turn, by recursion."""

    @cache
    def values(state, turn):
        if turn == horizon:
            return (0.0,) * len(table[state])
        return tuple(
            sum(
                chance * (reward + (0.0 if over else gamma * max(values(after, turn + 1))))
                for chance, after, reward, over in row
            )
            for row in table[state].values()
        )

    return values


@pytest.mark.parametrize(("options", "horizon"), [({}, 40), ({"gamma": 0.9}, 150)])
def test_what_is_called_best_is_best_by_a_recursion_of_its_own(options, horizon):
    """Also where actions differ by little: about these it is silent."""
    table = lake().unwrapped.P
    values = best_by_hand(table, horizon, options.get("gamma", 1.0))
    subject = Lesson(lake, Exact(**options), max_turns=40)
    world = subject.make_world()
    oracle = subject.make_teacher(world).oracle
    oracle.start((world.reset(seed=0), world.truth)[1])
    kinds = set()
    for state in table:
        for turn in range(0, 40, 3):
            now = Position(state, turn, world.truth.episode)
            best = values(state, 0 if "gamma" in options else turn)
            for action in range(4):
                said = {each.kind for each in oracle.judge(Moment(now, action, 0.0, now, False, turn, True))}
                kinds |= said
                assert HP not in said or best[action] == pytest.approx(max(best), rel=1e-6, abs=1e-12)
            advice = oracle.judge(Moment.opening(now), {FP, FN})
            for each in advice:
                first = best[each.action] == pytest.approx(max(best), rel=1e-6, abs=1e-12)
                assert first if each.kind is FP else getattr(each, "lost", 0) > 0
                assert each.holds(Moment.opening(now), oracle.lab)
    assert {HP, HN} <= kinds


def test_texts_that_are_no_actions_use_up_turns():
    """Where too few are left for the goal, no action can earn more than another."""
    frozen = gymnasium.make("FrozenLake-v1", is_slippery=False)
    env = llf_teacher.teach(frozen, oracle="auto", max_turns=7, text=True, privileged_info=True)
    env.reset(seed=1)
    for answer, more in (("hm", True), ("hm", False), ("hm", False), ("right", False)):
        info = env.step(answer)[-1]
        said = {type(atom.claim) for atom in info["atoms"]}
        assert (Avoid in said) == more
        assert PoorlyChosen not in said
        assert all(atom.claim.holds(info["moment"], env.session.world.scratch()) for atom in info["atoms"])
    fading = llf_teacher.teach(gymnasium.make("MiniGrid-Empty-5x5-v0"), oracle="auto", text=True)
    fading.reset(seed=1)
    assert not {atom.kind for atom in fading.step("hm")[-1]["atoms"]} & {FP, FN}


class Row(gymnasium.Env):
    """Cells in a row, with a cliff at 2 that truncates the episode, or chance, or a clock that decides."""

    observation_space, action_space = gymnasium.spaces.Discrete(10), gymnasium.spaces.Discrete(2)

    def __init__(self, cliff=False, slip=0.0, late=0):
        self.cliff, self.slip, self.late = cliff, slip, late

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.cell, self.clock = 0, 0
        return 4, {}

    def step(self, action):
        self.clock = min(self.clock + 1, self.late)
        stays = self.late or (self.slip and self.np_random.random() < self.slip)
        self.cell = self.cell if stays else self.cell + 2 * int(action) - 1
        over = self.cell in (-4, 4) or (self.late > 0 and action == 1)
        paid = float(self.clock == self.late) if self.late else 2.0 * (self.cell == 4) + (self.cell == -4)
        return self.cell + 4, paid * over, over, self.cliff and self.cell == 2, {}


def advice(*given):
    atoms = llf_teacher.teach(Row(*given), oracle="exact", max_turns=20).reset(seed=0)[1]["atoms"]
    return [atom.claim.action for atom in atoms if atom.kind is FP]


def test_a_state_that_truncates_the_episode_leads_nowhere():
    assert advice() == [1]
    assert advice(True) == [0]


def test_small_chances_are_found_out():
    with pytest.raises(PlanningError, match="chance decides what actions do"):
        advice(False, 0.005)


class Counted(Row):
    """Counts its steps, which decides nothing."""

    def reset(self, **options):
        self.ticks = 0
        return super().reset(**options)

    def step(self, action):
        self.ticks += 1
        return super().step(action)


def test_the_hint_for_an_environment_that_counts_steps_names_the_counter():
    with pytest.raises(PlanningError, match=r"counts steps in ticks, .* if the count decides nothing, pass .*state=f"):
        Lesson(Counted, Exact(states=20), max_turns=50)
    plain = Lesson(Counted, Exact(state=lambda env: env.unwrapped.cell), max_turns=50)
    assert plain.planned.size == "9 states"


class Late(gymnasium.Env):
    """Chance decides beyond 60 cells."""

    observation_space, action_space = gymnasium.spaces.Discrete(100), gymnasium.spaces.Discrete(2)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.cell = 0
        return 0, {}

    def step(self, action):
        far = 2 if self.cell > 60 and self.np_random.random() < 0.3 else 1
        self.cell = min(max(self.cell + (far if action else -1), 0), 99)
        return self.cell, float(self.cell == 99), self.cell == 99, False, {}


def test_chance_is_found_far_from_the_start():
    with pytest.raises(PlanningError, match="chance decides what actions do"):
        Lesson(Late, "exact", max_turns=200)


def test_a_table_of_transitions_is_not_copied():
    env = taxi()
    assert copied(env).unwrapped.P is env.unwrapped.P


def test_a_clock_of_its_own_is_a_part_of_the_state():
    """To wait pays."""
    assert advice(False, 0.0, 4) == [0]


class Broken(Row):
    """Cannot be stepped."""

    def step(self, action):
        raise RuntimeError("out of order")


@pytest.mark.parametrize("oracle", ["auto", "exact", Expert(lambda observation, info: 0)])
def test_an_environment_that_breaks_the_rules_is_refused_with_a_hint(oracle):
    with pytest.raises(PlanningError, match=r"cannot be reset and stepped .*out of order.*\.check_env\(env\)"):
        llf_teacher.teach(Broken(), oracle=oracle)


class Odd(Row):
    """Pays what is no number."""

    def step(self, action):
        observation, _, *rest = super().step(action)
        return observation, float("nan" if action else 0), *rest


def test_nothing_is_measured_where_rewards_are_no_numbers():
    env = llf_teacher.teach(Odd(), oracle=Expert(lambda observation, info: 0), max_turns=9)
    env.reset(seed=0)
    assert not {HP, HN, FN} & {atom.kind for atom in env.step(1)[-1]["atoms"]}


class Game:
    """A game that draws, with the place in it."""

    def __init__(self, seed):
        self.random, self.place = random.Random(seed), 0


class Hosted(gymnasium.Env):
    """All is in a game, whose random generator is no part of the state."""

    observation_space, action_space = gymnasium.spaces.Discrete(6), gymnasium.spaces.Discrete(2)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.game = Game(seed)
        return 0, {}

    def step(self, action):
        self.game.random.random()
        self.game.place = max(self.game.place + 2 * int(action) - 1, 0)
        over = self.game.place == 5
        return self.game.place, float(over), over, False, {}


def test_an_object_that_draws_is_read_without_its_generator():
    env = Hosted()
    env.reset(seed=0)
    seen = [other_parts(env, set()), *(env.step(action) and other_parts(env, set()) for action in (0, 1))]
    assert seen[0] == seen[1] != seen[2]


class Rare(gymnasium.Env):
    """A row on which each twentieth step slips, by draws from a generator that lies deep in it.

    Args:
        where: a name of `GENERATORS`.
    """

    observation_space, action_space = gymnasium.spaces.Discrete(7), gymnasium.spaces.Discrete(2)

    def __init__(self, where):
        self.where, self.draw, self.parts = where, GENERATORS[where], [{"deep": np.random.default_rng(0)}]

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.cell, self.parts[0]["deep"] = 3, np.random.default_rng(seed)
        if self.where == "space":
            self.action_space.seed(seed)
        return 3, {}

    def step(self, action):
        far = 2 * int(action) - 1
        self.cell = min(max(self.cell + (-far if self.draw(self) < 0.05 else far), 0), 6)
        return self.cell, float(self.cell == 6), self.cell == 6, False, {}


GENERATORS = {
    "list": lambda env: env.parts[0]["deep"].random(),
    "space": lambda env: env.action_space.np_random.random(),
    "shared": lambda env: random.random(),
}


@pytest.mark.parametrize("where", GENERATORS)
def test_draws_are_seen_wherever_the_generator_is(where):
    match = {
        "shared": "generators that all of Python or NumPy share",
        "space": "steps of a copy of the environment change what the original does",
    }.get(where)
    with pytest.raises(PlanningError, match=match or "chance decides what actions do"):
        Lesson(partial(Rare, where), Exact(state=lambda env: env.unwrapped.cell), max_turns=12)


class Key(gymnasium.Env):
    """Cells in a row, with a key at the left, without which the end at the right pays a tenth.

    Args:
        kept: how the key is kept, of `KEPT`.
    """

    observation_space, action_space = gymnasium.spaces.Discrete(8), gymnasium.spaces.Discrete(3)
    __slots__ = ("slot",)

    def __init__(self, kept="slot"):
        self.kept = kept

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.cell, self.P, self.lastaction, self.slot, self.pays = 3, [], 0, 0, None
        self.take(0)
        return self.cell, {}

    def take(self, has):
        KEPT[self.kept](self, has)

    def step(self, action):
        if action == 2 and self.cell == 0:
            self.take(1)
        elif action < 2:
            self.cell = min(max(self.cell + 2 * int(action) - 1, 0), 7)
        over = self.cell == 7
        has = self.P or self.lastaction or self.slot or (self.pays in (self.rich, Rich, rich))
        return self.cell, (10.0 if has else 1.0) * over, over, False, {}

    def rich(self):
        """What is bound to this is the key."""


class Rich:
    """This is the key."""


def rich():
    """This is the key, too."""


KEPT = {
    "slot": lambda env, has: setattr(env, "slot", has),
    "list named P": lambda env, has: env.P.extend([1] * (has > len(env.P))),
    "lastaction": lambda env, has: setattr(env, "lastaction", has),
    "method": lambda env, has: setattr(env, "pays", env.rich if has else env.close),
    "class": lambda env, has: setattr(env, "pays", Rich if has else int),
    "function": lambda env, has: setattr(env, "pays", rich if has else len),
}


@pytest.mark.parametrize("kept", KEPT)
def test_a_state_is_all_that_an_environment_holds(kept):
    """With the key in reach, it is fetched."""
    seat = llf_teacher.teach(
        partial(Key, kept), oracle="exact", max_turns=30, success=lambda _, reward, *more: reward > 5
    )
    claims = [atom.claim for atom in seat.reset(seed=0)[1]["atoms"] if atom.kind is FP]
    assert [claim.action for claim in claims] == [0]


class Shared(Key):
    """The key is in a dict that is named as tables are, which copies share."""

    def reset(self, *, seed=None, options=None):
        seen = super().reset(seed=seed)
        self.P = {}
        return seen

    def take(self, has):
        if has:
            self.P[0] = 1


def test_what_copies_share_is_found_out():
    with pytest.raises(PlanningError, match="copies of the environment share a part of its state"):
        Lesson(Shared, "exact", max_turns=30)


class Fetch(gymnasium.Wrapper):
    """Pays for the key itself."""

    def reset(self, **given):
        self.had = False
        return self.env.reset(**given)

    def step(self, action):
        self.had |= bool(action == 2 and self.unwrapped.cell == 0)
        seen, reward, *more = self.env.step(action)
        return seen, reward * (10 if self.had else 1), *more


class Gives(Key):
    """Says what its state is."""

    def take(self, has):
        pass

    def get_state(self):
        return self.cell


def test_the_state_of_a_wrapper_counts():
    with pytest.raises(PlanningError, match="the wrapper Fetch may have a state of its own"):
        Lesson(lambda: Fetch(Gives()), "exact", max_turns=30)


class Flip(gymnasium.Env):
    """The table of transitions is drawn at the start of an episode: the treasure is at one end or the other."""

    observation_space, action_space = gymnasium.spaces.Discrete(7), gymnasium.spaces.Discrete(2)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        pays, self.s = {0: 0.0, 6: 0.0, 6 * int(self.np_random.integers(2)): 1.0}, 3
        self.P = {
            state: {
                action: [(1.0, after, pays.get(after, 0.0) * (state not in pays), after in pays)]
                for action, after in enumerate((max(state - 1, 0), min(state + 1, 6)))
            }
            for state in range(7)
        }
        return self.s, {}

    def step(self, action):
        ((_, self.s, reward, over),) = self.P[self.s][int(action)]
        return self.s, reward, over, False, {}


def test_a_table_that_changes_is_a_part_of_the_state():
    seat = llf_teacher.teach(Flip, oracle="exact", max_turns=12)
    advised = []
    for seed in range(8):
        atoms = seat.reset(seed=seed)[1]["atoms"]
        pays = seat.session.world.env.unwrapped.P[1][0][0][2]
        advised += [atom.claim.action for atom in atoms if atom.kind is FP]
        assert advised[-1] == (pays == 0)
    assert set(advised) == {0, 1}


class Ends(gymnasium.Env):
    """Cells in a row; each action but the first two ends the episode.

    Args:
        pays: what the ends of the row and the end in between pay.
        table: whether there is a table.
    """

    observation_space, action_space = gymnasium.spaces.Discrete(5), gymnasium.spaces.Discrete(3)

    def __init__(self, pays, table):
        left, right, between = pays
        self.moves = {
            state: {
                0: [(1.0, state - 1, left if state == 1 else 0.0, state == 1)],
                1: [(1.0, state + 1, right if state == 3 else 0.0, state == 3)],
                2: [(1.0, state, between, True)],
            }
            for state in range(1, 4)
        }
        self.moves |= {state: {action: [(1.0, state, 0.0, True)] for action in range(3)} for state in (0, 4)}
        if table:
            self.P = self.moves

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.s = 2
        return 2, {}

    def step(self, action):
        ((_, self.s, reward, over),) = self.moves[self.s][int(action)]
        return self.s, reward, over, False, {}


@pytest.mark.parametrize("table", [True, False])
@pytest.mark.parametrize("left", [-1e9, -float("inf"), float("nan")])
def test_rewards_beside_which_others_are_lost_are_refused(left, table):
    """The right end, which pays 1, is better than the end in between, which pays half."""
    seat = llf_teacher.teach(partial(Ends, (-99.0, 1.0, 0.5), table), oracle="exact", max_turns=9)
    assert [each.claim.action for each in seat.reset(seed=0)[1]["atoms"] if each.kind is FP] == [1]
    with pytest.raises(PlanningError, match="rewards must be finite"):
        Lesson(partial(Ends, (left, 1.0, 0.5), table), "exact", max_turns=9)


class Later(Flip):
    """Another table in episodes of great seeds; or episodes that are cut off."""

    def __init__(self, most=99):
        self.most = most

    def reset(self, *, seed=None, options=None):
        seen = super().reset(seed=1 if seed is None or seed < 100 else 0)
        self.steps = 0
        return seen

    def step(self, action):
        seen, reward, terminated, _, info = super().step(action)
        self.steps += 1
        return seen, reward, terminated, self.steps >= self.most, info


def test_of_another_table_nothing_is_said():
    seat = llf_teacher.teach(Later, oracle="exact", max_turns=12)
    assert {each.kind for each in seat.reset(seed=5)[1]["atoms"]} >= {FP, FN}
    table = seat.session.world.env.unwrapped.P
    with pytest.warns(UserWarning, match="another table"):
        assert not {each.kind for each in seat.reset(seed=100)[1]["atoms"]} & {FP, FN}
    assert table != seat.session.world.env.unwrapped.P


def test_a_table_does_not_serve_where_episodes_are_cut_off():
    """They are explored instead."""
    whys = [Lesson(partial(Later, 2), "exact", max_turns=turns).planned.why for turns in (2, 12)]
    assert "table" in whys[0]
    assert "copies" in whys[1]


class Edge(Key):
    """Raises in a cell that random play hardly reaches."""

    def step(self, action):
        if self.cell == 6 and self.slot:
            raise RuntimeError("over the edge")
        return super().step(action)


def test_an_environment_that_raises_where_it_is_explored_is_refused():
    with pytest.raises(PlanningError, match=r"the environment raised RuntimeError\('over the edge'\) after action"):
        Lesson(Edge, "exact", max_turns=30)


class Many(gymnasium.Env):
    """A hundred thousand actions."""

    observation_space, action_space = gymnasium.spaces.Discrete(3), gymnasium.spaces.Discrete(100_000)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.cell = 0
        return 0, {}

    def step(self, action):
        self.cell = action % 3
        return self.cell, 0.0, False, False, {}


def test_the_bound_of_steps_holds_within_a_state():
    with pytest.raises(PlanningError, match=r"1 of which were explored in 202 steps; the bounds are .* steps=200"):
        Lesson(Many, Exact(steps=200), max_turns=9)


def test_bounds_count_what_is_done_and_not_the_time_that_it_takes(monkeypatch):
    """The tier is the same on a machine that is busy with other work."""
    hours = itertools.count()
    for clock in ("time", "monotonic", "perf_counter", "process_time"):
        monkeypatch.setattr(time, clock, lambda: 3_600.0 * next(hours))
    assert Lesson(partial(Hall, 12, (99, 99)), "auto", max_turns=11).planned.size == "78 states"


class Constant(EmptyEnv):
    """The goal is worth 1, whenever it is reached."""

    def _reward(self):
        return 1.0


class Armed(EmptyEnv):
    """The goal pays after a toggle only."""

    def reset(self, **given):
        self.armed = False
        return super().reset(**given)

    def step(self, action):
        self.armed |= action == self.actions.toggle
        seen, reward, *more = super().step(action)
        return seen, reward * self.armed, *more


class Drawn(EmptyEnv):
    """Its own grid, under MiniGrid's rules."""

    def __init__(self, **options):
        super().__init__(size=5, **options)

    def _gen_grid(self, width, height):
        super()._gen_grid(width, height)
        self.put_obj(Lava(), 2, 2)


class Easy(BlackjackEnv):
    """The dealer draws no card."""

    def step(self, action):
        if action:
            return super().step(action)
        return self._get_obs(), 1.0 if sum(self.player) >= sum(self.dealer) else -1.0, True, False, {}


def patched():
    env = gymnasium.make("MiniGrid-Empty-5x5-v0")
    env.unwrapped._reward = lambda: 1.0
    return env


@pytest.mark.parametrize(
    ("make", "follows"),
    [
        (partial(Constant, size=5), False),
        (partial(Armed, size=5), False),
        (patched, False),
        (lambda: Fetch(gymnasium.make("MiniGrid-Empty-5x5-v0")), False),
        (Easy, False),
        (BlackjackEnv, True),
        (Drawn, True),
        (lambda: gymnasium.make("MiniGrid-Fetch-5x5-N2-v0"), True),
    ],
)
def test_rules_are_known_of_those_only_who_follow_them(make, follows):
    """A subclass of another package, an instance or a wrapper may have other ones."""
    own = known(make())
    assert (own.table or own.fading) is not None if follows else (own.table, own.fading, own.state) == (None,) * 3


def test_a_subclass_is_not_taught_its_base():
    assert Lesson(partial(Drawn, max_steps=30), "exact").planned.tier == "exact"
    with pytest.raises(PlanningError, match="cannot be compared"):
        Lesson(partial(Constant, size=5), "exact")


def test_a_refused_subclass_is_told_which_rules_are_not_its_own():
    match = "chance decides(.|\n)*\nNote: Easy overrides step, so that rules known of BlackjackEnv may not hold"
    with pytest.raises(PlanningError, match=match):
        Lesson(Easy, "exact")
    with pytest.warns(RewardsOnlyWarning, match=match):
        Lesson(Easy, "auto")


class Toll(gymnasium.Wrapper):
    """The goal pays only after cell 3; or the wrapper counts what decides nothing."""

    def __init__(self, env, decides=True):
        super().__init__(env)
        self.decides = decides

    def reset(self, **given):
        self.passed = False
        return self.env.reset(**given)

    def step(self, action):
        seen, reward, *more = self.env.step(action)
        self.passed |= seen == 3
        return seen, reward if self.passed or not self.decides else 0, *more


class Dearer(FrozenLakeEnv):
    """After 12 steps, the goal pays more than the table says."""

    def reset(self, **given):
        self.late = 0
        return super().reset(**given)

    def step(self, action):
        self.late += 1
        seen, reward, *more = super().step(action)
        return seen, reward * (3 if self.late > 12 else 1), *more


def small(**options):
    return gymnasium.make("FrozenLake-v1", is_slippery=False, **options)


def test_a_table_serves_only_where_nothing_else_changes(long_trials):
    with pytest.raises(PlanningError, match="the table of transitions has no part for passed of Toll, which changes"):
        Lesson(lambda: Toll(small()), "exact")
    state = Exact(state=lambda env: env.unwrapped.s)
    assert "table" in Lesson(lambda: Toll(small(), decides=False), state).planned.why
    with pytest.raises(PlanningError, match="two states have the same key and differ"):
        Lesson(lambda: Toll(small()), state)


@pytest.mark.parametrize("turns", [pytest.param(15, marks=pytest.mark.full), 100])
def test_a_count_that_decides_is_found_out(turns, long_trials):
    """By the table, and with a state that leaves it out."""
    make = partial(Dearer, is_slippery=False)
    for oracle in (Exact(states=5), Exact(state=lambda env: env.unwrapped.s)):
        with pytest.raises(PlanningError):
            Lesson(make, oracle, max_turns=turns)


class Strict(gymnasium.Env):
    """Has a table, and raises if it is stepped after the end."""

    observation_space, action_space = gymnasium.spaces.Discrete(3), gymnasium.spaces.Discrete(2)

    def __init__(self, raises=2):
        self.raises = raises
        self.P = {s: {a: [(1.0, min(s + a, 2), float(s + a == 2), s + a == 2)] for a in range(2)} for s in range(3)}

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.s = 0
        return 0, {}

    def step(self, action):
        if self.s == self.raises:
            raise RuntimeError("call reset")
        ((_, self.s, reward, over),) = self.P[self.s][int(action)]
        return self.s, reward, over, False, {}


def test_after_the_end_no_step_is_tried():
    assert "table" in Lesson(Strict, "exact", max_turns=9).planned.why
    twice = gymnasium.wrappers.RecordEpisodeStatistics
    for make in (partial(Strict, 1), lambda: twice(twice(small()))):
        with pytest.raises(PlanningError, match=r"the environment raised \w+\(.*\) after action"):
            Lesson(make, "exact", max_turns=9)


class Text(Row):
    """Pays in text in some cells."""

    def __init__(self, *cells):
        super().__init__()
        self.cells = cells

    def step(self, action):
        seen, reward, *more = super().step(action)
        return seen, f"{reward}" if self.cell in self.cells else reward, *more


def test_rewards_that_are_no_numbers_are_refused():
    for cells in ((-1, 1), (2,)):
        with pytest.raises(PlanningError, match=r"number.*got '0.0'"):
            Lesson(partial(Text, *cells), "exact", max_turns=9)


def test_the_shortest_of_several_time_limits_counts():
    env = gymnasium.wrappers.TimeLimit(small(max_episode_steps=6), 7)
    assert Lesson(env, "exact").planned.horizon == 6


def test_a_passenger_with_changing_wishes_is_in_no_table():
    for chance in (0.01, 0.3):
        with pytest.raises(PlanningError, match="fickle_passenger=True has it; leave that option out"):
            Lesson(gymnasium.make("Taxi-v4", fickle_passenger=True, fickle_probability=chance), "exact")


def test_what_the_student_cannot_see_is_found_out():
    """Blackjack's hidden card is averaged over by the rules, and known in an expert's roll-outs."""
    stick = Expert(lambda observation, info: 0)
    assert Lesson(gymnasium.make("Blackjack-v1"), "exact").planned.privileged is False
    for make, oracle in ((BlackjackEnv, stick), (Easy, stick), (Flip, "exact")):
        seat = llf_teacher.teach(make, oracle=oracle, max_turns=9)
        assert seat.family.planned.privileged
        assert seat.reset(seed=0)[1]["privileged"] is True
    for make in (Walk, Row):
        assert Lesson(make, "exact", max_turns=9).planned.privileged is None
    blind = gymnasium.wrappers.TransformObservation(small(), lambda seen: 0, gymnasium.spaces.Discrete(1))
    assert Lesson(blind, "exact").planned.privileged


@pytest.mark.parametrize("name", ["cliff", "lake", "door"])
def test_equal_says_the_values_themselves(name):
    """Without the price of time by which actions of equal sums are ranked."""
    seat = llf_teacher.StudentEnv(lesson(name), teacher="equal(eps=1)", privileged_info=True)
    oracle, said = seat.teacher.oracle, 0
    for seed in range(4):
        info, over, rng = seat.reset(seed=seed)[1], False, np.random.default_rng(seed)
        while not over:
            before = info["moment"].after
            _, _, *ends, info = seat.step(
                int(rng.integers(2, 4) if name == "lake" else rng.integers(oracle.model.actions))
            )
            over = any(ends) or info["moment"].turn > 60
            for claim in (atom.claim for atom in info["atoms"] if isinstance(atom.claim, NoDifference)):
                worths = oracle.model.at(before, oracle.lab).expected(before.seen, before.turn)
                assert claim.mine == pytest.approx(worths[claim.action].earned, abs=1e-12)
                said += 1
    assert said > 3
    honest = audit(lesson(name), "equal(eps=1)", turns=60, students=("random",))
    assert honest.count(Label.DISTORTED) == honest.contradictions == 0


def test_a_reward_that_is_no_number_is_said_as_it_is():
    env = llf_teacher.teach(Odd, max_turns=9, privileged_info=True)
    env.reset(seed=0)
    info = env.step(1)[-1]
    (atom,) = info["atoms"]
    assert "nan" in atom.text
    assert atom.claim.holds(info["moment"], env.session.world.scratch())


class Gust(gymnasium.Env):
    """A square of cells from corner to corner; a gust in one of them may blow back to the start.

    Args:
        side: cells of a side.
        place: where the gust is; None: each step draws, which decides nothing.
        chance: of the gust.
    """

    action_space = gymnasium.spaces.Discrete(4)

    def __init__(self, side=8, place=None, chance=0.05):
        self.side, self.place, self.chance = side, place, chance
        self.observation_space = gymnasium.spaces.Discrete(side * side)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.cell = (options or {}).get("cell", (0, 0))
        return 0, {}

    def step(self, action):
        move = ((1, 0), (0, 1), (-1, 0), (0, -1))[action]
        self.cell = tuple(min(max(at + by, 0), self.side - 1) for at, by in zip(self.cell, move, strict=True))
        if (self.place is None or self.cell == self.place) and self.np_random.random() < self.chance and self.place:
            self.cell = (0, 0)
        over = self.cell == (self.side - 1,) * 2
        return self.cell[0] * self.side + self.cell[1], float(over), over, False, {}


@pytest.mark.parametrize("place", [(6, 6), (7, 6), (3, 7), (5, 5), (6, 2)])
def test_chance_in_a_single_cell_is_found(place):
    with pytest.raises(PlanningError, match="chance decides what actions do"):
        Lesson(partial(Gust, place=place), "exact", max_turns=14)


def test_draws_that_decide_nothing_are_tried_within_the_bound():
    assert Lesson(partial(Gust, 2), "exact", max_turns=14).planned.size == "4 states"
    with pytest.raises(PlanningError, match=r"steps or more draw random numbers; to try each 300 times"):
        Lesson(partial(Gust, 8), Exact(steps=5_000), max_turns=14)


class Hall(Gust):
    """Nothing is drawn; a corner pays twice as much as another, which is nearer."""

    def step(self, action):
        seen, *_ = super().step(action)
        pays = {(self.side - 1, self.side - 1): 2.0, (0, self.side - 1): 1.0}.get(self.cell, 0.0)
        return seen, pays, pays > 0, False, {}


def hall(turns, states=5_000):
    seat = llf_teacher.teach(partial(Hall, 12, (99, 99)), oracle=Exact(states=states), max_turns=turns)
    return lambda *cell: [
        atom.claim.action
        for atom in seat.reset(seed=0, options={"cell": cell} if cell else None)[1]["atoms"]
        if atom.kind is FP
    ], seat.teacher.oracle.model


def test_only_the_states_that_time_suffices_for_are_explored():
    """Values from another start are not taken where they lack states."""
    for turns, start, action in ((11, (), 1), (4, (11, 7), 1), (4, (11, 6), None)):
        advised, model = hall(turns)
        assert model.size == (turns + 1) * (turns + 2) // 2
        assert advised(*start) == ([] if action is None else [action])
    advised, model = hall(5)
    assert advised() == []
    assert advised(2, 8) == [1]  # its way is not known from the corner
    assert model.size > 6 * 7 / 2


def test_an_episode_with_too_many_states_is_played_in_silence():
    advised, model = hall(5, 30)
    with pytest.warns(UserWarning, match="no values in this episode: more than 30 states can be reached"):
        assert advised(6, 6) == []
    assert model.silences.total() == 1
    assert advised() == []


class Hasty(EmptyEnv):
    """The time limit, and with it what a goal pays, is drawn in each episode."""

    def _gen_grid(self, width, height):
        super()._gen_grid(width, height)
        self.max_steps = int(self._rand_int(6, 21))


def test_what_fades_is_that_of_the_episode():
    """And the turns are those of its limit."""
    seat = llf_teacher.teach(partial(Hasty, size=5, max_steps=20), oracle="exact", instruction_type="b")
    for seed in range(6):
        info = seat.reset(seed=seed)[1]
        world = seat.session.world
        steps = world.env.unwrapped.max_steps
        claims = [atom.claim for atom in info["atoms"]]
        assert [each.turns for each in claims if type(each) is Total] == [steps]
        assert [each.part for each in claims if type(each) is Fading] == pytest.approx([0.9 / steps])
        best = max(seat.teacher.oracle.stated_values(world.truth))
        assert best == pytest.approx(1 - 0.9 * 5 / steps)
        assert all(
            each.holds(Moment.opening(world.truth), seat.teacher.oracle.lab) for each in claims if type(each) is Total
        )


class Named(Gust):
    """Names its actions, or too many of them, or by no numbers."""

    def __init__(self, words=None, **kinds):
        super().__init__(3, (9, 9))
        if words:
            self.words = words
        else:
            self.actions = enum.Enum("actions", kinds)

    def get_action_meanings(self):
        return getattr(self, "words", None)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (partial(Named, ["E", "S", "W", "N"]), ["e", "s", "w", "n"]),
        (partial(Named, ["E", "S", "W", "N", "FIRE"]), []),
        (partial(Named, East=0, South_by=1, West=2, North=3), ["east", "south by", "west", "north"]),
        (partial(Named, East="e", South="s"), []),
        (lambda: gymnasium.wrappers.ClipReward(small(), 0, 1), ["left", "down", "right", "up"]),
        (lambda: gymnasium.wrappers.TransformAction(small(), lambda a: (a + 1) % 4, gymnasium.spaces.Discrete(4)), []),
        (lambda: gymnasium.wrappers.TransformAction(small(), lambda a: a, gymnasium.spaces.Discrete(2)), []),
        (lambda: gymnasium.wrappers.StickyAction(small(), 0.1), []),
    ],
)
def test_words_are_those_of_all_actions_as_they_are_taken(make, words):
    env = make()
    assert list(words_of(env, known(env) or Known())) == words


def test_where_words_do_not_fit_there_are_numbers():
    seat = llf_teacher.teach(partial(Named, ["E", "S", "W", "N", "FIRE"]), oracle="auto", max_turns=9)
    assert [atom.claim.answer for atom in seat.reset(seed=0)[1]["atoms"] if atom.kind is FP] == ["0"]


@pytest.mark.parametrize(
    "wrap",
    [
        lambda env: gymnasium.wrappers.TransformObservation(env, lambda seen: -seen, None),
        lambda env: gymnasium.wrappers.TransformAction(env, lambda action: 3 - action, gymnasium.spaces.Discrete(4)),
        lambda env: gymnasium.wrappers.FrameStackObservation(env, 2),
    ],
)
def test_an_expert_is_known_only_of_what_it_sees_and_does(wrap):
    pytest.importorskip("Box2D", reason="box2d has no wheel for this Python")
    env = gymnasium.make("LunarLander-v3")
    assert known(env).expert
    assert known(wrap(env)).expert is known(wrap(env)).describe is None
    with pytest.raises(PlanningError, match="no expert is known"):
        Lesson(wrap(env), Expert())


class Holds(Gust):
    """Holds something that is hard to look at.

    Args:
        what: a name of `HARD`.
    """

    def __init__(self, what):
        super().__init__(3, (9, 9))
        self.what = what

    def reset(self, **given):
        self.held = HARD[self.what]()
        return super().reset(**given)


def a_function_that_calls_itself():
    def down(n):
        return n and down(n - 1)

    return down


def a_function_with_an_empty_cell():
    def calls():
        return later()

    if not calls:
        later = calls
    return calls


def a_list_that_holds_itself():
    found = [1]
    found.append(found)
    return found


def a_deep_list():
    found = []
    for _ in range(5_000):
        found = [found]
    return found


HARD = {
    each.__name__: each
    for each in (a_function_that_calls_itself, a_function_with_an_empty_cell, a_list_that_holds_itself, a_deep_list)
}


@pytest.mark.parametrize("what", HARD)
def test_what_holds_itself_is_compared_or_refused(what):
    if what == "a_deep_list":
        with pytest.raises(PlanningError, match="hold each other more than 50 times"):
            Lesson(partial(Holds, what), "exact", max_turns=9)
        return
    assert comparable(HARD[what]()) == comparable(HARD[what]())
    if "function" in what:
        with pytest.raises(
            PlanningError, match=r"it holds the function .*, which closes over (down|later); copies share"
        ):
            Lesson(partial(Holds, what), "exact", max_turns=9)
        return
    subject = Lesson(partial(Holds, what), "auto", max_turns=9)
    assert (subject.planned.tier, subject.planned.size) == ("exact", "9 states")


class Happy(FrozenLakeEnv):
    """For five steps, the goal pays double.

    Args:
        since: the first of them.
    """

    def __init__(self, since, **options):
        self.since = since
        super().__init__(**options)

    def reset(self, **given):
        self.taken = 0
        return super().reset(**given)

    def step(self, action):
        self.taken += 1
        seen, reward, *more = super().step(action)
        return seen, reward * (2 if self.since <= self.taken < self.since + 5 else 1), *more


@pytest.mark.parametrize("since", [12, 30, 93])
def test_a_count_that_decides_for_a_while_is_found_out(since):
    with pytest.raises(PlanningError, match="counts steps in taken"):
        Lesson(partial(Happy, since, is_slippery=False), Exact(states=20), max_turns=100)


def told(seat, **given):
    claims = seat.reset(**given)[1]["atoms"]
    return {atom.kind for atom in claims} & {FP, FN}


def double(bare):
    for row in bare.P.values():
        for action, each in row.items():
            row[action] = [(chance, after, 2 * reward, over) for chance, after, reward, over in each]


@pytest.mark.parametrize(
    ("make", "change", "back"),
    [
        (small, lambda env: double(env.unwrapped), None),
        (small, lambda env: setattr(env, "_max_episode_steps", 4), lambda env: setattr(env, "_max_episode_steps", 100)),
        (taxi, lambda env: setattr(env.unwrapped, "fickle_passenger", True), None),
        (
            lambda: gymnasium.make("Blackjack-v1"),
            lambda env: setattr(env.unwrapped, "natural", True),
            lambda env: setattr(env.unwrapped, "natural", False),
        ),
    ],
)
def test_of_other_rules_than_those_planned_for_nothing_is_said(make, change, back):
    seat = llf_teacher.teach(make, oracle="exact")
    assert told(seat, seed=3)
    change(seat.session.world.env)
    with pytest.warns(UserWarning, match="another table, other options or another time limit"):
        assert not told(seat, seed=3)
    if back is not None:
        back(seat.session.world.env)
        assert told(seat, seed=3)


class Wanders(Gust):
    """Begins elsewhere each time, whatever the seed, and ends at once."""

    def reset(self, **given):
        super().reset(**given)
        self.cell = (int(np.random.default_rng().integers(self.side)), 0)
        return self.cell[0], {}

    def step(self, action):
        seen, reward, *_ = super().step(action)
        return seen, reward, True, False, {}


class Lists(Gust):
    """Its rewards are lists of one number."""

    def step(self, action):
        seen, reward, *more = super().step(action)
        return seen, np.array([reward]), *more


def test_refusals_say_what_is_wrong():
    for make, match in (
        (partial(Wanders, 5, (9, 9)), r"reset\(seed=0\) does not give the same each time"),
        (partial(Lists, 3, (9, 9)), "the reward must be a number"),
    ):
        with pytest.raises(PlanningError, match=match):
            Lesson(make, "exact", max_turns=20)


class Tires(Gust):
    """After six steps the goal pays more."""

    def reset(self, **given):
        self.taken = 0
        return super().reset(**given)

    def step(self, action):
        self.taken += 1
        seen, reward, *more = super().step(action)
        return seen, reward * (1 + (self.taken > 6)), *more


def test_a_large_state_is_not_written_out():
    large = Exact(state=lambda env: ("large" * 99, env.unwrapped.cell))
    with pytest.raises(PlanningError, match=r"differ: action [01] led to the end for 2 and to the end for 1;"):
        Lesson(partial(Tires, 3, (9, 9)), large, max_turns=20)
