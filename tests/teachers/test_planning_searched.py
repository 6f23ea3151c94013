"""The searched tier: what is said of plans that were found, what is proven, and which environments are refused."""

import dataclasses
import pickle
import random
import threading
from functools import partial
from typing import ClassVar

import gymnasium
import minigrid  # noqa: F401 (its environments are registered by this)
import networkx as nx
import numpy as np
import pytest
from design import amount
from gymnasium import spaces

import llf_teacher
from llf_teacher.tools.audit import audit
from pz_envs.lesson import Lesson
from teachers.atoms import FN, FP, HN, HP, Label, Moment
from teachers.planning import TIERS, Exact, PlanningError, Searched
from teachers.planning.known.minigrid import _heuristic
from teachers.planning.searched.claims import (
    ActionsLeft,
    Astray,
    Doomed,
    Hold,
    Nearer,
    Next,
    OutOfReach,
    Ruin,
    Safe,
    Way,
)
from teachers.planning.searched.search import refuted, search
from teachers.testing import Pupil, check_oracle
from worlds.wrapped.gym_world import GymWorld
from worlds.wrapped.snapshots import Copies, Replays, States, way_back

pytestmark = pytest.mark.usefixtures("short_trials")

WALLS = {(1, 0), (1, 1), (1, 2), (3, 4), (3, 3), (3, 2)}
MOVES = ((1, 0), (0, 1), (-1, 0), (0, -1))


class Maze(gymnasium.Env):
    """A grid of five by five with two walls; the fifth action is a leap into the void."""

    observation_space, action_space = spaces.MultiDiscrete([5, 5]), spaces.Discrete(5)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.place, self.steps = (0, int(self.np_random.integers(5))), 0
        return np.array(self.place), {}

    def moved(self, action):
        x, y = self.place[0] + MOVES[action][0], self.place[1] + MOVES[action][1]
        return (x, y) if 0 <= x < 5 and 0 <= y < 5 and (x, y) not in WALLS else self.place

    def step(self, action):
        self.steps += 1
        if action == 4:
            return np.array(self.place), 0.0, True, False, {}
        self.place = self.moved(action)
        there = self.place == (4, 4)
        return np.array(self.place), float(there), there, False, {}


class Kept(Maze):
    """Sets itself back."""

    def get_state(self):
        return self.place, self.steps

    def set_state(self, state):
        self.place, self.steps = state


class Forgetful(Kept):
    """Sets itself back to another place."""

    def set_state(self, state):
        self.place, self.steps = (0, 0), state[1]


class Locked(Maze):
    """Can be neither copied nor set back, but replayed."""

    def __init__(self):
        self.lock = threading.Lock()


class Wild(Locked):
    """Cannot be replayed either: each episode begins elsewhere."""

    episodes = 0

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.episodes += 1
        self.place = 0, self.episodes % 5
        return np.array(self.place), {}


class Slippery(Maze):
    """Slips on the last step before the goal only; the draws to come would tell when."""

    def step(self, action):
        if action < 4 and self.moved(action) == (4, 4) and self.np_random.random() < 0.5:
            action = (action + 2) % 4
        return super().step(action)


class Line(gymnasium.Env):
    """A point on a line that is pushed by any force up to 1, to beyond 4."""

    observation_space, action_space = spaces.Box(-9, 9, (1,), np.float64), spaces.Box(-1, 1, (1,), np.float64)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.point = 0.0
        return np.array([self.point]), {}

    def step(self, action):
        self.point = float(np.clip(self.point + action[0], -9, 9))
        return np.array([self.point]), float(self.point >= 4), self.point >= 4, False, {}


WAYS = {"copies": (Maze, Copies), "states": (Kept, States), "replays": (Locked, Replays), "again": (Forgetful, Copies)}


def mountain_car():
    return gymnasium.make("MountainCar-v0")


def lesson(make, turns=30, **options):
    return Lesson(make, Searched(**options), max_turns=turns)


def cart_pole():
    return gymnasium.make("CartPole-v1")


def pupil(subject, turns):
    return Pupil(subject.make_world, subject.make_teacher, max_turns=subject.max_turns, turns=turns)


def moments(subject, episodes, seed=0):
    """An oracle, and the moments of random play."""
    world, rng = subject.make_world(), np.random.default_rng(seed)
    oracle = subject.make_teacher(world).oracle
    for number in range(episodes):
        world.reset(seed=number + seed)
        yield oracle, Moment.opening(world.truth)
        over = False
        while not over:
            before, action = world.truth, world.legal(world.sample_action(rng))
            _, reward, terminated, truncated, info = world.step(action)
            over = terminated or truncated or world.truth.turn >= subject.max_turns
            yield oracle, Moment(before, action, reward, world.truth, info["success"], world.truth.turn, over)


@pytest.mark.parametrize("name", WAYS)
def test_the_way_back_is_proven_and_the_oracle_passes_the_kit(name):
    make, way = WAYS[name]
    subject = lesson(make)
    assert type(subject.planned.model.task.way) is way is type(way_back(make()))
    check_oracle(pupil(subject, amount(5, full=12)))


def test_an_oracle_that_keeps_going_passes_the_kit():
    check_oracle(pupil(Lesson(cart_pole, "searched"), 30))


@pytest.mark.full
@pytest.mark.parametrize(
    "id", ["MiniGrid-MultiRoom-N2-S4-v0", "MiniGrid-MultiRoom-N4-S5-v1", "MiniGrid-DoorKey-8x8-v0", "MountainCar-v0"]
)
def test_known_environments_pass_the_kit(id):
    check_oracle(pupil(Lesson(lambda: gymnasium.make(id), "searched"), 40))


@pytest.mark.parametrize(
    "make", [Maze, *(pytest.param(make, marks=pytest.mark.full) for make in (cart_pole, mountain_car))]
)
def test_no_claim_is_false_and_lies_are_caught(make):
    subject = Lesson(make, "searched", max_turns=None if make is mountain_car else 60)
    honest = audit(subject, turns=amount(24, full=60), students=("random", "obedient"))
    assert honest.count(Label.DISTORTED) == honest.contradictions == honest.leaks == 0 < honest.checked
    liar = audit(subject, "mistake(eps=1)", turns=amount(16, full=40), students=("random",))
    assert liar.count(Label.TRUTHFUL) == sum(n for (kind, _), n in liar.claims.items() if kind is None)


@pytest.mark.parametrize("make", [Maze, pytest.param(cart_pole, marks=pytest.mark.full)])
def test_claims_with_another_number_or_action_do_not_hold(make):
    """Each class has its liars: one for each number, and for another action."""
    lied = set()
    for oracle, moment in moments(Lesson(make, "searched", max_turns=30), 20 if make is cart_pole else 8):
        way = oracle.brief(moment.after, "c") if "c" in oracle.instruction_types and not moment.turn else ()
        for claim in (*oracle.judge(moment), *way):
            if not type(claim).__module__.startswith("teachers.planning"):
                continue
            assert claim.holds(moment, oracle.lab)
            changes = {name: getattr(claim, name) + 1 for name in ("before", "count", "turns") if hasattr(claim, name)}
            if isinstance(claim, Next | ActionsLeft | Nearer | Safe):
                changes["left"] = claim.left + 1
            if isinstance(claim, Astray):
                changes["left"] = claim.left + 9
            if isinstance(claim, Astray | OutOfReach | Doomed | Nearer | Safe):
                changes["action"] = 1 - claim.action if claim.action < 2 else 0
            if hasattr(claim, "goal"):
                changes["goal"] = "win"
            if isinstance(claim, Way):
                changes["actions"] = (4, *claim.actions[1:])
            for name, value in changes.items():
                assert not dataclasses.replace(claim, **{name: value}).holds(moment, oracle.lab), (claim, name)
                lied.add(type(claim))
            for other in oracle.falsehoods(claim, moment):
                lied.add(type(claim))
                assert not other.holds(moment, oracle.lab)
    names = {each.__name__ for each in lied}
    goal = {"Solve", "Way", "Next", "Nearer", "Astray", "OutOfReach", "Ruin"}
    assert names >= (goal if make is Maze else {"Hold", "Safe", "Doomed", "Fatal"})


def distances():
    """From each place of the maze to the goal, by networkx."""
    maze, ways = Maze(), nx.DiGraph()
    for place in ((x, y) for x in range(5) for y in range(5) if (x, y) not in WALLS):
        for action in range(4):
            maze.place = place
            ways.add_edge(place, maze.moved(action))
    return nx.single_target_shortest_path_length(ways, (4, 4))


def test_what_is_said_agrees_with_the_true_distances():
    far, kinds = distances(), set()
    for oracle, moment in moments(lesson(Maze, state=lambda env: env.unwrapped.place), 30):
        here = far[moment.after.seen]
        for claim in oracle.judge(moment, {HP, HN, FP, FN}):
            kinds.add(claim.kind)
            if isinstance(claim, Next):
                assert claim.left == here
            elif isinstance(claim, Nearer):
                assert (claim.before, claim.left) == (far[moment.past.seen], here)
                assert claim.left == claim.before - 1
            elif isinstance(claim, Astray):
                assert claim.before == far[moment.past.seen] <= claim.left == here
            else:
                assert isinstance(claim, OutOfReach | Ruin) == (claim.action == 4)
    assert kinds == {HP, HN, FP, FN}


@pytest.mark.parametrize(
    "id",
    [
        pytest.param("MiniGrid-DoorKey-6x6-v0", marks=pytest.mark.full),
        pytest.param("MiniGrid-Empty-6x6-v0", marks=pytest.mark.full),
        "MiniGrid-MultiRoom-N2-S4-v0",
    ],
)
def test_the_heuristic_of_minigrid_never_guesses_too_much(id):
    """Along shortest ways that a search without it finds."""
    env = gymnasium.make(id)
    task = Lesson(env, Searched(heuristic=lambda env: 0.0, admissible=True, nodes=4000)).planned.model.task
    world = GymWorld(env, look=task.state)
    for seed in range(2):
        world.reset(seed=seed)
        lab = world.scratch()
        lab.restore(world.truth)
        found = search(task, lab, 1000)
        assert found.shortest
        for left in range(len(found.actions), 0, -1):
            assert _heuristic(world.env) <= left
            world.step(found.actions[-left])


@pytest.mark.parametrize(
    ("make", "turns"),
    [
        (Maze, range(6, 15)),
        (lambda: gymnasium.make("MiniGrid-MultiRoom-N2-S4-v0"), range(3, 20)),
        (mountain_car, range(80, 130)),
        (cart_pole, (500,)),
    ],
)
def test_the_plan_arrives(make, turns):
    env = llf_teacher.teach(make, oracle="searched", feedback_type="fp")
    for seed in (101,) if make is cart_pole else (101, 102):
        info, over, count = env.reset(seed=seed)[1], False, 0
        while not over:
            (advice,) = [atom.claim for atom in info["atoms"] if atom.kind is FP]
            _, _, terminated, truncated, info = env.step(advice.action)
            over, count = terminated or truncated, count + 1
        assert info["success"]
        assert count in turns


def test_bounds_are_met():
    """Each search takes no more steps, and says less."""
    subject = lesson(Maze)
    world = subject.make_world()
    world.reset(seed=0)
    for nodes in (1, 7, 30):
        task = dataclasses.replace(subject.planned.model.task, nodes=nodes)
        found = search(task, world, 30)
        assert found.nodes <= nodes
        assert found.actions is None
        assert found.least <= 8
    slow = dataclasses.replace(subject.planned.model.task, seconds=1e-9)
    assert search(slow, world, 30).nodes == 0
    with pytest.raises(PlanningError, match=r"a search of 20 steps .* nodes=20 .* heuristic="):
        lesson(Maze, nodes=20)


def test_a_plan_that_needs_luck_is_none():
    """The draws to come would show a way over the slippery last step, or that there is none."""
    with pytest.raises(PlanningError, match="chance decides what actions do"):
        Lesson(gymnasium.make("FrozenLake-v1"), "searched")
    subject = lesson(Maze)
    task = dataclasses.replace(subject.planned.model.task, way=Copies())
    world, proven = GymWorld(Slippery, look=subject.planned.look), 0
    for seed in range(20):
        world.reset(seed=seed)
        lab = world.scratch()
        lab.restore(world.truth)
        found = search(task, lab, 30)
        assert found.lucky
        assert found.actions is None
        assert found.least == 0
        lab.restore(world.truth)
        proven += refuted(task, lab, 30, 30)
    assert not proven


class Icy(Slippery):
    """Has another way to the goal, on which nothing slips."""

    def step(self, action):
        if action == 4 and self.place == (2, 4):
            self.place = (4, 4)
            return np.array(self.place), 1.0, True, False, {}
        return super().step(action)


def test_a_way_without_luck_is_found_where_others_need_it():
    env = llf_teacher.teach(Icy, oracle="searched", max_turns=30)
    for seed in range(8):
        info, answers = env.reset(seed=seed)[1], []
        while not info.get("success"):
            answers.append(next(atom.claim.action for atom in info["atoms"] if atom.kind is FP))
            info = env.step(answers[-1])[-1]
        assert answers[-1] == 4


def test_states_that_look_alike_are_found_out():
    with pytest.raises(PlanningError, match=r"two states have the same key and differ .* give state="):
        lesson(Maze, state=lambda env: env.unwrapped.place[1])


class Treacherous(Slippery):
    """The last step to the goal slips once in twenty times."""

    def step(self, action):
        slips = action < 4 and self.moved(action) == (4, 4) and self.np_random.random() < 0.05
        return Maze.step(self, (action + 2) % 4 if slips else action)


def test_a_small_chance_is_found_by_playing_a_plan_often():
    """A search sees no slip: it takes a step with few other random numbers."""
    with pytest.raises(PlanningError, match="chance decides what actions do"):
        lesson(Treacherous)


class Turns(Maze):
    """Safe in the first two episodes; later the last step slips seldom."""

    safe = 0, 1

    def reset(self, *, seed=None, options=None):
        self.slips = seed not in self.safe
        return super().reset(seed=seed)

    def step(self, action):
        slips = self.slips and action < 4 and self.moved(action) == (4, 4) and self.np_random.random() < 0.05
        return super().step((action + 2) % 4 if slips else action)


def test_where_chance_decides_the_teacher_is_silent_and_says_why():
    env = llf_teacher.teach(Turns, oracle="searched", max_turns=30)
    assert any(atom.kind is FP for atom in env.reset(seed=0)[1]["atoms"])
    with pytest.warns(UserWarning, match="no plan in this state: chance decides where the actions of the plan lead"):
        assert not any(atom.kind is FP for atom in env.reset(seed=5)[1]["atoms"])
    assert env.step(4)[2]
    assert env.teacher.oracle.silences["chance decides where the actions of the plan lead"] >= 1


class Broken(Maze):
    def step(self, action):
        return super().step(action)[:4]


class Endless(Maze):
    """Has no goal, and always a new state."""

    def step(self, action):
        self.seen = (*getattr(self, "seen", ()), action)
        return np.array(self.place), 0.0, False, False, {}


class Barren(Maze):
    """Has no goal."""

    def step(self, action):
        observation, _, terminated, truncated, info = super().step(action)
        return observation, 0.0, terminated, truncated, info


class Pairs(Maze):
    action_space = spaces.MultiDiscrete([2, 2])

    def step(self, action):
        return super().step(int(action[0]))


@pytest.mark.parametrize(
    ("make", "options", "error", "match"),
    [
        (Wild, {}, PlanningError, r"neither copied, nor set back, nor replayed .* get_state\(\)"),
        (Broken, {}, PlanningError, "cannot be reset and stepped .*check_env"),
        (Endless, {"nodes": 50}, PlanningError, "found no way to solve the task in 30 turns; .* heuristic="),
        (Barren, {}, PlanningError, "no step solves the task in any state .* give success="),
        (Pairs, {}, PlanningError, r"actions cannot be listed: .*choices="),
        (Line, {"choices": [[7.0]]}, PlanningError, "choices must be actions"),
        (Line, {"choices": []}, PlanningError, "choices must have at least one action"),
        (Maze, {"state": lambda env: [0]}, TypeError, r"state must give something hashable, .* got \[0\]"),
        (Maze, {"heuristic": lambda env: 1 / 0}, PlanningError, "must give a number .* raised ZeroDivisionError"),
        (Maze, {"heuristic": lambda env: "near"}, PlanningError, "heuristic must give a number"),
        (Maze, {"heuristic": lambda env: float("nan")}, PlanningError, "must give a finite number .* got nan"),
        (Maze, {"heuristic": lambda env: 50, "admissible": True}, PlanningError, "guesses 50 actions where"),
        (Maze, {"nodes": 0}, ValueError, "nodes must be an integer of at least 1, got 0"),
        (Maze, {"lasts": 1.5}, ValueError, r"lasts must be an integer of at least 1, got 1\.5"),
        (Maze, {"seconds": 0}, ValueError, "seconds must be greater than 0, got 0"),
        (Barren, {"lasts": 9, "choices": [4]}, PlanningError, "no way was found to keep an episode going for 9"),
    ],
)
def test_what_cannot_be_searched_is_refused_with_the_remedy(make, options, error, match):
    with pytest.raises(error, match=match):
        lesson(make, **options)


def test_a_heuristic_that_fails_later_leaves_a_lesson_that_goes_on():
    class Rises:
        start = None

        def __call__(self, env):
            if self.start is not None and env.unwrapped.place != self.start:
                raise RuntimeError("lost")
            return 0.0

    heuristic = Rises()
    env = llf_teacher.StudentEnv(lesson(Maze, heuristic=heuristic))
    heuristic.start = (9, 9)

    def play():
        atoms = env.reset(seed=5)[1]["atoms"]
        return [atom for atom in atoms if atom.kind is FP], env.step(0)[1]

    with pytest.warns(
        UserWarning, match=r"no plan in this state: heuristic must give a number .* RuntimeError\('lost'"
    ):
        assert play() == ([], 0.0)


def test_continuous_actions_are_a_grid_that_is_stated_and_proves_nothing():
    subject = lesson(Line)
    assert "of the actions [-1.0], [0.0], [1.0] only" in subject.planned.why
    env = llf_teacher.StudentEnv(subject, text=True)
    assert "[-1.0], [0.0], [1.0]" in env.reset(seed=0)[0]["instruction"]
    info = env.step("[1.0]")[-1]
    assert {atom.kind for atom in info["atoms"]} == {"r", HP, FP}
    assert not {atom.kind for atom in env.step("[-0.5]")[-1]["atoms"]} & {HP, HN, FN}
    task = subject.planned.model.task
    assert not task.measures
    assert not refuted(task, env.session.world.scratch(), 1, 30)
    check_oracle(pupil(subject, 20))


def test_another_task_than_the_usual_one_has_another_heuristic():
    door = Lesson(gymnasium.make("MiniGrid-DoorKey-5x5-v0"), "searched")
    assert door.planned.model.task.admissible

    def holds_key(observation, reward, terminated, truncated, info):
        return bool((observation["image"][3, 6] == (5, observation["image"][3, 6][1], 0)).all())

    keys = Lesson(gymnasium.make("MiniGrid-DoorKey-5x5-v0"), "searched", success=holds_key)
    assert keys.planned.model.task.heuristic is None
    env = llf_teacher.StudentEnv(keys)
    info, turns = env.reset(seed=3)[1], 0
    while not info["success"]:
        info = env.step(next(atom.claim.action for atom in info["atoms"] if atom.kind is FP))[-1]
        turns += 1
        assert turns < 20


def test_what_is_said_does_not_depend_on_what_was_asked_before():
    """Of the same episode, another oracle in another process says the same, in whatever order it is asked."""
    first = [(moment, oracle.judge(moment)) for oracle, moment in moments(lesson(Maze), 5)]
    subject = pickle.loads(pickle.dumps(lesson(Maze)))
    oracle = subject.make_teacher(subject.make_world()).oracle
    for moment, said in reversed(first):
        assert oracle.judge(moment) == said


class Count(gymnasium.Wrapper):
    """Counts steps."""

    steps: ClassVar[int] = 0

    def step(self, action):
        Count.steps += 1
        return super().step(action)


def test_a_plan_is_kept_while_it_is_followed():
    env = llf_teacher.teach(lambda: Count(Maze()), oracle="searched", max_turns=30)
    env.reset(seed=0)
    model = env.teacher.oracle.model
    searched = len(model._found)
    plan = model.plan(env.session.world.truth, env.teacher.oracle.lab).actions
    for action in plan[:-1]:
        before = Count.steps
        env.step(action)
        assert Count.steps - before <= 2 * 30  # its own step, and warnings
    assert len(model._found) == searched


def test_auto_takes_the_tier_that_serves(monkeypatch):
    monkeypatch.setitem(TIERS, "exact", partial(Exact, states=amount(500, full=5_000)))
    env = llf_teacher.teach(Maze, oracle="auto", max_turns=300)  # exact: too many states with their counts of steps
    assert env.teacher.oracle.tier == "searched"
    assert "a search of at most 3,000 steps a turn through copies" in env.family.planned.why
    assert Lesson(Maze, Exact(state=lambda env: env.unwrapped.place), max_turns=30).planned.tier == "exact"
    with pytest.raises(ValueError, match=r"exact: .*\n- searched: .*\n- expert: .*\nFollow one of these hints"):
        llf_teacher.teach(Barren, oracle="auto", max_turns=300)


@pytest.mark.parametrize("personality", ["worked_example", "myopic", "noisy"])
def test_personalities_that_need_more_are_refused(personality):
    with pytest.raises(ValueError, match=f"personality '{personality}.*' needs"):
        llf_teacher.StudentEnv(lesson(Maze), teacher=personality)


@pytest.mark.parametrize("teacher", ["hinter", "harsh", "vague", "sandwich", "delayed(turns=2) | mistake(eps=0.5)"])
def test_other_personalities_work(teacher):
    env = llf_teacher.StudentEnv(lesson(Maze), teacher=teacher, text=True)
    env.reset(seed=1)
    for answer in ("0", "1", "hm", "1", "3"):
        assert isinstance(env.step(answer)[0]["feedback"], str)


def test_an_environment_that_was_drawn_is_still_taught():
    """Its window cannot be copied."""
    env = llf_teacher.teach(gymnasium.make("CartPole-v1", render_mode="rgb_array"), oracle="searched")
    for seed in (1, 2):
        env.reset(seed=seed)
        assert env.session.world.env.render().ndim == 3
        assert {atom.kind for atom in env.step(0)[-1]["atoms"]} >= {HP, FP}


class Corridor(gymnasium.Env):
    """Cells from -3 to 6, both ends solve the task; a ledge before 4, a gate before 6, a cliff, and its own time."""

    observation_space, action_space = spaces.Discrete(10), spaces.Discrete(2)

    def __init__(self, gate=0, cliff=None, limit=100):
        self.gate, self.cliff, self.limit = gate, cliff, limit

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.place, self.steps = 0, 0
        return 3, {}

    def step(self, action):
        self.steps += 1
        after = self.place + 2 * int(action) - 1
        closed = (self.place, after) == (4, 3) or (after == 6 and self.steps < self.gate)
        self.place = self.place if closed else after
        over = self.place in (-3, 6)
        return (
            self.place + 3,
            float(over),
            over,
            not over and (self.place == self.cliff or self.steps >= self.limit),
            {},
        )


def heard(actions, *given):
    """The claims of each turn."""
    env = llf_teacher.teach(Corridor(*given), oracle="searched", max_turns=20)
    for episode in actions:
        env.reset(seed=0)
        yield [[atom.claim for atom in env.step(action)[-1]["atoms"]] for action in episode]


def test_a_count_of_steps_that_decides_is_refused():
    assert next(heard([[1]]))
    with pytest.raises(PlanningError, match=r"the number of steps \(steps\) decides what action 1 does after 5"):
        next(heard([[1]], 12))


def test_no_step_that_truncates_the_episode_is_praised():
    ((*_, last),) = heard([[1, 1, 1]], 0, 3)
    assert not any(isinstance(claim, Nearer) for claim in last)


def test_a_limit_of_its_own_is_no_part_of_what_is_known_of_a_state():
    """In the same cell the time suffices early, and not late."""
    late, early = heard([[1, 0, 1, 0, 1, 0], [0]], 0, None, 8)
    assert any(isinstance(claim, Next) for claim in late[3])
    assert not any(isinstance(claim, Next) for claim in late[5])
    assert any(isinstance(claim, Next) for claim in early[0])


class Held(Corridor):
    """Cannot be copied."""

    def reset(self, *, seed=None, options=None):
        self.lock = threading.Lock()
        return super().reset(seed=seed, options=options)


def test_where_the_count_of_steps_cannot_be_tried_it_is_a_part_of_the_state():
    env = llf_teacher.teach(lambda: Held(12), oracle="searched", max_turns=20)
    env.reset(seed=0)
    said = [atom.claim for action in (1, 1, 1, 1) for atom in env.step(action)[-1]["atoms"]]
    assert any(isinstance(claim, Nearer | Astray | Next) for claim in said)
    assert not any(isinstance(claim, OutOfReach) for claim in said)


class Falls(Maze):
    """Each step is paid, the one that ends the episode, too, which is a fall."""

    def step(self, action):
        observation, _, terminated, truncated, info = super().step(action)
        return observation, 1.0, terminated, truncated, info


def test_no_teacher_leads_to_a_fall_that_is_paid():
    with pytest.raises(
        PlanningError, match="positive rewards, so that an end with one may be a failure; give success="
    ):
        lesson(Falls)
    assert lesson(Falls, lasts=9).planned.tier == "searched"


def test_where_only_an_expert_knows_the_task_nothing_is_searched_for():
    with pytest.raises(PlanningError, match="no goal is known that a search can find, but an expert is"):
        Lesson(gymnasium.make("Acrobot-v1"), "searched")


class Window(gymnasium.Env):
    """A row with a goal far on the left, and one on the right behind a door that is open for two steps only."""

    observation_space, action_space = spaces.Discrete(40), spaces.Discrete(3)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.cell, self.steps = 0, 0
        return 20, {}

    def step(self, action):
        after = self.cell + int(action) - 1
        self.cell = self.cell if after == 2 and action == 2 and self.steps not in (5, 6) else after
        self.steps += 1
        over = self.cell in (4, -12)
        return self.cell + 20, float(over), over, False, {}


class KeptWindow(Window):
    """Sets itself back."""

    def get_state(self):
        return self.cell, self.steps

    def set_state(self, state):
        self.cell, self.steps = state


@pytest.mark.parametrize("make", [Window, KeptWindow])
def test_a_count_of_steps_that_decides_for_a_while_is_refused(make):
    with pytest.raises(PlanningError, match=r"the number of steps \(steps\) decides what action 2 does after 1"):
        lesson(make)


class Game:
    """A game that draws, with the place in it."""

    def __init__(self, seed):
        self.random, self.place = random.Random(seed), 0


class Hosted(gymnasium.Env):
    """All is in a game, whose random generator is no part of the state."""

    observation_space, action_space = spaces.Discrete(6), spaces.Discrete(2)

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
    state = lesson(Hosted).planned.look
    env = Hosted()
    env.reset(seed=0)
    keys = [state(env), *(env.step(action) and state(env) for action in (0, 1))]
    assert keys[0] == keys[1] != keys[2]


class Rare(gymnasium.Env):
    """A row on which each hundredth step slips, by draws from a generator that lies deep in it.

    Args:
        where: a name of `GENERATORS`.
    """

    observation_space, action_space = spaces.Discrete(7), spaces.Discrete(2)

    def __init__(self, where="list"):
        self.draw, self.parts = GENERATORS[where], [{"deep": np.random.default_rng(0)}]

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.cell, self.parts[0]["deep"] = 3, np.random.default_rng(seed)
        self.action_space.seed(seed)
        return 3, {}

    def step(self, action):
        far = 2 * int(action) - 1
        self.cell = min(max(self.cell + (-far if self.draw(self) < 0.01 else far), 0), 6)
        return self.cell, float(self.cell == 6), self.cell == 6, False, {}


GENERATORS = {
    "list": lambda env: env.parts[0]["deep"].random(),
    "space": lambda env: env.action_space.np_random.random(),
    "shared": lambda env: random.random(),
}


@pytest.mark.parametrize("where", GENERATORS)
def test_draws_are_seen_wherever_the_generator_is(where):
    match = "generators that all of Python or NumPy share" if where == "shared" else "a search would use its luck"
    with pytest.raises(PlanningError, match=match):
        lesson(partial(Rare, where), turns=12)


class Forward(gymnasium.Env):
    """Each episode goes one cell on, as a count of steps would; there are no others."""

    observation_space, action_space = spaces.Discrete(2), spaces.Discrete(2)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.cell = 0
        return 0, {}

    def step(self, action):
        self.cell = (1, None)[self.cell]
        return 1, float(action), True, False, {}


def test_what_cannot_count_steps_is_refused():
    with pytest.raises(PlanningError, match=r"the number of steps \(cell\) decides"):
        lesson(Forward)


class Raising(gymnasium.Env):
    """A line whose steps to the left raise at the third place."""

    action_space, observation_space = spaces.Discrete(3), spaces.Discrete(9)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.place = 0
        return self.place, {}

    def step(self, action):
        if (self.place, action) == (3, 0):
            raise RuntimeError("out of order")
        self.place = min(max(self.place + int(action) - 1, 0), 8)
        return self.place, float(self.place == 8), self.place == 8, False, {}


def test_an_environment_that_raises_where_it_is_searched_is_refused_with_its_reason():
    with pytest.raises(
        PlanningError, match=r"raised RuntimeError\('out of order'\) after action 0 in a state that was"
    ):
        llf_teacher.teach(Raising(), oracle="searched", text=True, max_turns=12)


class Moves(gymnasium.Env):
    """A row of cells with the goal in the middle; each episode begins elsewhere, whatever the seed."""

    observation_space, action_space = gymnasium.spaces.Discrete(11), gymnasium.spaces.Discrete(2)
    episodes, goal = 0, 5

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.episodes += 1
        self.cell = (2, 8)[self.episodes % 2]
        return self.cell, {}

    def step(self, action):
        self.cell = min(max(self.cell + (-1, 1)[action], 0), 10)
        return self.cell, float(self.cell == self.goal), self.cell == self.goal, False, {}


class Frozen(Moves):
    """Cannot be copied; only its seed is said to decide."""

    def __deepcopy__(self, memo):
        raise TypeError("no copies")

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.cell = 2
        return self.cell, {}


def next_of(info):
    return next(((atom.claim.action, atom.claim.left) for atom in info["atoms"] if type(atom.claim) is Next), None)


def test_a_plan_is_for_the_state_in_which_the_episode_begins():
    seat = llf_teacher.teach(Moves, oracle="searched", max_turns=30)
    starts = [seat.reset(seed=7) for _ in range(4)]
    assert {(seen["observation"], next_of(info)) for seen, info in starts} == {(2, (1, 3)), (8, (0, 3))}
    bare = seat.session.world.env.unwrapped
    bare.goal = 9
    observation, info = seat.reset(seed=7)
    assert next_of(info) == (1, 9 - observation["observation"])


def test_where_a_replay_begins_in_another_state_there_is_no_plan():
    seat = llf_teacher.teach(Frozen, oracle="searched", max_turns=30)
    assert next_of(seat.reset(seed=7)[1]) == (1, 3)
    seat.session.world.env.unwrapped.goal = 0
    with pytest.warns(UserWarning, match="the episode cannot be replayed"):
        assert next_of(seat.reset(seed=7)[1]) is None


def test_a_plan_is_for_the_constants_of_the_episode():
    seat = llf_teacher.teach(mountain_car, oracle="searched")
    _, left = next_of(seat.reset(seed=7)[1])
    seat.session.world.env.unwrapped.force = 3e-3
    info = seat.reset(seed=7)[1]
    assert next_of(info)[1] < left
    assert all(atom.claim.holds(seat.session.moment, seat.session.world.scratch()) for atom in info["atoms"])
    seat = llf_teacher.teach(partial(gymnasium.make, "CartPole-v1"), oracle="searched")
    assert any(type(atom.claim) is Hold for atom in seat.reset(seed=7)[1]["atoms"])
    seat.session.world.env.unwrapped.force_mag = 0.1
    assert not any(type(atom.claim) is Hold for atom in seat.reset(seed=7)[1]["atoms"])


def test_a_plan_is_for_the_time_limit_of_the_episode():
    seat = llf_teacher.teach(lambda: gymnasium.wrappers.TimeLimit(Moves(), 30), oracle="searched")
    assert next_of(seat.reset(seed=7)[1])[1] == 3
    seat.session.world.env._max_episode_steps = 2
    assert next_of(seat.reset(seed=7)[1]) is None
