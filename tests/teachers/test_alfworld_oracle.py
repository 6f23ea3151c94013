"""ALFWorld's oracle: plans are shortest, advice leads to the goal, and an explorer knows only what was seen."""

import numpy as np
import pytest
from houses import STOCK, plan_by_downward

import llf_teacher
from llf_teacher.students.parsing import parse_student
from teachers.atoms import Moment
from teachers.oracles.alfworld import AlfworldOracle, Planner
from teachers.oracles.alfworld.claims import Do, DoAbout, DoVerb, seen
from teachers.oracles.alfworld.search import distance
from teachers.testing import CHECKS, Pupil
from worlds.alfworld import Alfworld, Truth
from worlds.alfworld.exact import ExactEngine
from worlds.alfworld.games import TASKS
from worlds.alfworld.generated import make


def episode(task, seed, wander=0, **options):
    """An obedient student's episode whose first actions are random: whether it succeeded, in how many turns."""
    env = llf_teacher.make("llf-alfworld-v0", task=task, games="generated", **options)
    rng = np.random.default_rng(seed)
    student = parse_student("obedient").seat(env.family, env.session.world)
    student.reset(rng)
    observation, _ = env.reset(seed=seed)
    for turn in range(1, 101):
        action = student.act(observation, env.student_view.info_for(student))
        if turn <= wander:
            action = env.session.world.sample_action(rng)
        observation, _, terminated, truncated, info = env.step(action)
        if terminated or truncated:
            break
    return info["success"], turn


@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize("wander", [0, 10])
def test_the_obedient_always_succeed(task, wander):
    results = [episode(task, seed, wander) for seed in range(20)]
    assert [success for success, _ in results] == [True] * 20
    assert max(turns for _, turns in results) <= 16 + wander


@pytest.mark.parametrize("task", TASKS)
def test_the_obedient_of_an_explorer_succeed(task):
    assert all(episode(task, seed, oracle="explorer")[0] for seed in range(5))


def states(task, seed, steps):
    """A game, and states of random play, now and then along the plan."""
    played = make(np.random.default_rng(seed), task, "all")
    engine, planner, rng = ExactEngine(played), Planner(played), np.random.default_rng(seed)
    for _ in range(steps):
        plan = planner.plan(engine.facts)
        yield played, planner, engine.facts
        if engine.won():
            break
        commands = engine.commands()
        engine.do(plan[0] if rng.random() < 0.3 else commands[rng.integers(len(commands))])


@pytest.mark.parametrize("task", TASKS)
def test_plans_are_as_short_as_search_finds_them(task):
    for seed in range(4):
        for played, planner, facts in states(task, 300 + seed, 12):
            assert len(planner.plan(facts)) == distance(Truth(facts, "", False, played))


@pytest.mark.parametrize("task", TASKS)
def test_what_is_left_is_the_length_of_the_plan(task):
    """From where the student is, and after each command, which is not always carried out to know it."""
    for played, planner, facts in states(task, 320, 12):
        assert planner.left(facts) == len(planner.plan(facts))
        engine = ExactEngine(played)
        engine.load(facts)
        for command in engine.commands():
            engine.load(facts)
            engine.do(command)
            assert planner.left_after(facts, command) == len(Planner(played).plan(engine.facts))


def test_a_plan_table_serves_while_the_student_does_nothing_that_matters(monkeypatch):
    looked = []
    look = Planner._make_table
    monkeypatch.setattr(Planner, "_make_table", lambda self, facts: looked.append(facts) or look(self, facts))
    played = make(np.random.default_rng(0), TASKS[0], "all")
    engine, planner = ExactEngine(played), Planner(played)
    for command in ("look", "inventory", *[each for each in engine.commands() if each.startswith("go to ")]):
        engine.do(command)
        planner.plan(engine.facts)
    assert len(looked) == 1
    opened = next(each for each in engine.house.receptacles if each in engine.house.openable)
    planner.plan(engine.facts | {("opened", opened)})
    assert len(looked) == 2


def test_a_planner_remembers_a_few_plan_tables():
    world = Alfworld()
    world.reset(seed=0)
    planner, rng, most = Planner(world.truth.game), np.random.default_rng(0), 0
    for _ in range(3000):
        world.step(world.sample_action(rng))
        planner.left(world.truth.facts)
        most = max(most, len(planner._tables))
    assert most == 64


def downward(played):
    """The length of an optimal plan, by Fast Downward's search on TextWorld's translation; None if it takes long."""
    import multiprocessing

    context = multiprocessing.get_context("spawn")
    queue = context.Queue()
    process = context.Process(target=plan_by_downward, args=(played, queue))
    process.start()
    try:
        return queue.get(timeout=90)
    except Exception:
        return None
    finally:
        process.kill()
        process.join()


@STOCK
@pytest.mark.full
def test_plans_are_no_longer_than_fast_downwards():
    compared = 0
    for seed in range(120):
        played = make(np.random.default_rng(7000 + seed), TASKS[seed % 6], "all")
        length = downward(played)
        if length:
            assert len(Planner(played).plan(played.start)) <= length
            compared += 1
        if compared == 50:
            break
    assert compared == 50


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_the_explorer_passes_the_kit(check):
    family = llf_teacher.make("llf-alfworld-v0").family
    check(Pupil(lambda: family.make_world(oracle="explorer"), family.make_teacher, max_turns=100, turns=200))


def test_the_explorer_does_not_look_at_what_is_hidden():
    """What lies in places that were not looked into makes no difference to what it says."""
    world = Alfworld(oracle="explorer")
    rng = np.random.default_rng(0)
    for seed in range(6):
        world.reset(seed=seed)
        oracle = AlfworldOracle(world.scratch)
        oracle.start(world.truth)
        for turn in range(12):
            truth = world.truth
            known = seen(truth, world._engine.house)
            facts = frozenset(fact for fact in truth.facts if fact[0] != "inreceptacle" or fact[2] in known)
            bare = truth._replace(facts=facts)
            assert oracle.plan(truth, 1) == AlfworldOracle.plan(oracle, bare, 1)
            world.step(world.sample_action(rng) if turn % 2 else oracle.plan(truth, 1)[0])
            if world.truth.won:
                break


def test_hints_are_implied_by_the_advice():
    world = Alfworld()
    world.reset(seed=1)
    oracle = AlfworldOracle(world.scratch)
    oracle.start(world.truth)
    moment = Moment.opening(world.truth)
    while not world.truth.won:
        (advice,) = (claim for claim in oracle.judge(moment) if isinstance(claim, Do))
        hints = advice.coarser(moment, oracle.lab)
        assert [type(hint) for hint in hints] == [DoVerb, DoAbout]
        assert all(hint.holds(moment, oracle.lab) for hint in hints)
        false = [claim for hint in hints for claim in hint.counterparts(moment, oracle.lab)]
        assert any(not claim.holds(moment, oracle.lab) for claim in false)
        world.step(advice.action)
        moment = Moment.opening(world.truth)


def test_instructions_tell_a_route_that_wins():
    for seed in range(6):
        world = Alfworld()
        world.reset(seed=seed)
        oracle = AlfworldOracle(world.scratch)
        oracle.start(world.truth)
        route = oracle.brief(world.truth, "c")[-1]
        assert [world.step(action)[4]["success"] for action in route.actions][-1]
