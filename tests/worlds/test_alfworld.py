"""ALFWorld: games from floor plans and files, and an engine that equals TextWorld's."""

import copy
import multiprocessing
import os
import pickle
import subprocess
import sys
import tempfile
import threading
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
from houses import ROOMS, STOCK, play_in_textworld, stock_rooms, stock_tasks, stock_things, written

from worlds.alfworld import Alfworld, Truth
from worlds.alfworld.exact import NOTHING, ExactEngine
from worlds.alfworld.facts import rooms, tasks, things
from worlds.alfworld.games import CHANGING, SPLITS, TASKS, parse
from worlds.alfworld.generated import make
from worlds.alfworld.house import names
from worlds.alfworld.plans import plan, plans_for
from worlds.alfworld.stock import StockEngine

RARE = ("take", "move", "open", "close", "use", "heat", "cool", "clean", "slice", "examine")


def game(seed, task="", split="all"):
    return make(np.random.default_rng(seed), task, split)


def reset(seed=0, **options):
    world = Alfworld(games="generated", **options)
    world.reset(seed=seed)
    return world


def choose(commands, rng):
    """A random command, often one of those that change more than the location; now and then one that fails."""
    rare = [command for command in commands if command.split()[0] in RARE]
    if rare and rng.random() < 0.6:
        commands = rare
    return "dance" if rng.random() < 0.03 else commands[rng.integers(len(commands))]


def walk_both(played, steps, rng):
    """Play both engines side by side, and compare all that they say and know; the number of steps."""
    own, stock = ExactEngine(played), StockEngine(played)
    assert own.intro() == stock.intro()
    for _ in range(steps):
        assert own.commands() == stock.commands()
        assert own.facts == stock.facts
        assert own.facts | played.static == stock.all_facts()
        assert own.won() == stock.won()
        if rng.random() < 0.02:
            stock.load(stock.facts)
        command = choose(own.commands(), rng)
        assert own.do(command) == stock.do(command)
    return steps


@STOCK
@pytest.mark.parametrize("task", TASKS)
def test_the_exact_engine_equals_textworld(task):
    walk_both(game(TASKS.index(task), task), 15, np.random.default_rng(0))


@STOCK
@pytest.mark.full
@pytest.mark.parametrize("seed", range(24))
def test_the_exact_engine_equals_textworld_on_ten_thousand_steps(seed):
    walk_both(game(1000 + seed, TASKS[seed % 6]), 430, np.random.default_rng(seed))


def test_games_are_those_that_were_asked_for():
    for task in TASKS:
        assert reset(task=task).truth.game.task == task
    assert {reset(seed).truth.game.task for seed in range(60)} == set(TASKS)


@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize("split", SPLITS)
def test_no_game_begins_solved_and_none_lies_wrong(task, split):
    for seed in range(4):
        played = game(seed, task, split)
        assert not ExactEngine(played).won()
        kinds = {fact[1]: fact[2] for fact in played.static if fact[0] in ("objecttype", "receptacletype")}
        lying = [fact for fact in played.start if fact[0] == "inreceptacle"]
        held = [("cancontain", kinds[where], kinds[each]) for _, each, where in lying if "desklamp" not in kinds[each]]
        assert set(held) <= played.static
        assert sum(kinds[each] == f"{played.target}type" for _, each, _ in lying) >= 1 + (task == TASKS[-1])


@pytest.mark.parametrize("task", TASKS)
def test_a_game_is_what_its_problem_says(task):
    played = game(7, task)
    words = {"obj": played.target, "recep": played.destination, "toggle": played.lamp, "mrecep": ""}
    assert parse(played.problem, task, words, played.goal) == played


def test_an_engine_takes_over_a_state_as_a_new_one_would():
    rng = np.random.default_rng(0)
    for seed in range(6):
        played = game(seed)
        engine, goes, seen = ExactEngine(played), ExactEngine(played), []
        for _ in range(60):
            goes.do(choose(goes.commands(), rng))
            seen.append(goes.facts)
        for i in rng.permutation(60).tolist():
            fresh = ExactEngine(played)
            fresh.load(seen[i])
            engine.load(seen[i])
            for each in ("facts", "location", "held", "inside"):
                assert getattr(engine, each) == getattr(fresh, each)
            assert engine.commands() == fresh.commands()
            assert [engine.do("look"), engine.won()] == [fresh.do("look"), fresh.won()]


def test_every_floor_plan_can_be_drawn():
    numbers = [*range(1, 31), *range(201, 231), *range(301, 331), *range(401, 431)]
    assert all(len(plan(number).receptacles) > 3 for number in numbers)
    assert {number for task in TASKS for number in plans_for(task, "all")} == set(numbers)
    drawn = {game(seed).problem.split(")")[0].rpartition("_")[2] for seed in range(300)}
    assert len(drawn) > 80


def test_unseen_floor_plans_are_in_no_other_split():
    def drawn(split):
        return {game(seed, split=split).problem.split(")")[0] for seed in range(150)}

    assert not drawn("valid_unseen") & (drawn("train") | drawn("valid_seen"))


def test_observations_list_the_commands():
    world = reset(3)
    observation, _, _, _, info = world.step("look")
    assert observation.endswith(f"\n\nAdmissible commands: {', '.join(info['admissible_commands'])}")
    assert world.observation_space.contains(observation)


def test_the_reward_comes_once():
    world = reset(0, task="pick_and_place_simple")
    played = world.truth.game
    house = world._engine.house
    target = next(each for each in house.objects if house.type[each] == f"{played.target}type")
    goal = next(each for each in house.receptacles if house.type[each] == f"{played.destination}type")
    facts = frozenset(
        fact for fact in played.start if fact[0] not in ("atlocation", "holds") and target not in fact
    ) | {("atlocation", "agent1", house.place[goal]), ("holds", "agent1", target), ("holdsany", "agent1")}
    world.restore(Truth(facts | {("opened", goal)}, "", False, played))
    move = f"move {house.name[target]} to {house.name[goal]}"
    assert world.step(move)[1:4] == (1.0, True, False)
    assert world.step("look")[1:4] == (0.0, True, False)
    assert world.truth.won


@pytest.mark.parametrize("command", ["  LOOK ", "Look", "look\n", "\tlOOk"])
def test_case_and_space_do_not_matter(command):
    assert reset().legal(command) == "look"
    assert reset().step(command)[0] == reset().step("look")[0]


@pytest.mark.parametrize("command", ["", "look around", "lok", "go to", "goto cabinet 1", "look.", "é", "examine look"])
def test_all_else_comes_to_nothing(command):
    world = reset()
    before = world.truth
    observation, reward, *_ = world.step(command)
    assert observation.startswith(NOTHING)
    assert (world.truth.facts, reward) == (before.facts, 0.0)


@pytest.mark.parametrize("action", [None, 3, "x" * 501, "look\x00", ["look"]])
def test_what_is_no_text_is_refused(action):
    world = reset()
    before = world.truth
    with pytest.raises(ValueError, match="allowed: a text of at most 500 characters"):
        world.step(action)
    assert world.truth == before


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"task": "dance"}, "task must be one of '', 'pick_and_place_simple'.*, got 'dance'"),
        ({"split": "test"}, "split must be one of 'all', 'train', .*, got 'test'"),
        ({"games": "mine"}, "games must be one of 'auto', 'generated', 'official', got 'mine'"),
        ({"engine": "fast"}, "engine must be one of 'exact', 'textworld', got 'fast'"),
        ({"oracle": "all"}, "oracle must be one of 'planner', 'explorer', got 'all'"),
        ({"games": "official"}, "games='official' needs game files; ALFWORLD_DATA is ''.* run `alfworld-download`"),
    ],
)
def test_bad_options_are_named(options, message):
    with pytest.raises(ValueError, match=message):
        Alfworld(**options)


@STOCK
def test_facts_are_those_of_alfworld():
    """If the floor plans are not, `python tests/helpers/houses.py` writes them."""
    assert things() == stock_things()
    assert tasks() == stock_tasks()
    assert rooms() == stock_rooms()
    assert ROOMS.read_text("utf-8") == written(stock_rooms())


def test_games_are_played_without_alfworld():
    program = (
        "import sys, worlds.alfworld; world = worlds.alfworld.Alfworld(games='generated'); world.reset(seed=0)\n"
        "world.step(world.commands()[0]); print(*{name.partition('.')[0] for name in sys.modules})"
    )
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    loaded = set(result.stdout.split())
    assert "worlds" in loaded
    assert not loaded & {"alfworld", "textworld", "fast_downward", "jericho", "spacy"}


@STOCK
def test_names_are_those_of_alfworld():
    from types import SimpleNamespace

    from alfworld.agents.utils.misc import Demangler

    ids = [id for id, _ in game(5).kinds]
    demangler = Demangler(game_infos={id: SimpleNamespace(id=id) for id in ids})
    assert names(ids) == {id: demangler.demangle_alfred_name(id) for id in ids}


def test_a_problem_must_have_its_tasks_goal():
    played = game(0, TASKS[0])
    words = {"obj": "Mug", "recep": "Bed", "toggle": "", "mrecep": ""}
    with pytest.raises(ValueError, match="goal is not the goal of the task 'pick_and_place_simple'"):
        parse(played.problem, TASKS[0], words, "")


@STOCK
def test_engines_interleave_and_leave_no_trace():
    """Many engines in one process: argv, stdout and temporary files are as before."""
    argv, stdout = list(sys.argv), sys.stdout
    before = set(os.listdir(tempfile.gettempdir()))
    worlds = [reset(seed, engine=engine) for seed in (1, 2) for engine in ("exact", "textworld")]
    rng = np.random.default_rng(0)
    for _ in range(6):
        for own, stock in (worlds[:2], worlds[2:]):
            command = choose(own.commands(), rng)
            assert own.step(command) == stock.step(command)
            assert own.truth == stock.truth
    assert (sys.argv, sys.stdout) == (argv, stdout)
    assert not {name for name in set(os.listdir(tempfile.gettempdir())) - before if "downward" in name}


@STOCK
@pytest.mark.parametrize("copied", [copy.deepcopy, lambda world: pickle.loads(pickle.dumps(world))])
def test_textworlds_state_is_saved_and_copied(copied):
    world = reset(4, engine="textworld")
    for command in ("go to fridge 1", "look"):
        world.step(command)
    saved, twin = world.save(), copied(world)
    commands = [*world.commands()[:3], "dance"]
    first = [world.step(command) for command in commands]
    assert [twin.step(command) for command in commands] == first
    world.restore(saved)
    assert [world.step(command) for command in commands] == first


@STOCK
def test_textworld_in_threads_and_processes():
    expected = [play_in_textworld(seed) for seed in (1, 2)]
    found = {}
    threads = [threading.Thread(target=lambda s=seed: found.__setitem__(s, play_in_textworld(s))) for seed in (1, 2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [found[1], found[2]] == expected
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        assert list(pool.map(play_in_textworld, [1, 2])) == expected


@STOCK
def test_importing_alfworld_touches_neither_environment_nor_home(tmp_path):
    program = (
        "import os, sys; from worlds.alfworld import Alfworld; Alfworld(engine='textworld').reset(seed=0)\n"
        "assert 'alfworld' in sys.modules; print(os.environ.get('ALFWORLD_DATA'), os.listdir(os.environ['HOME']))"
    )
    environment = os.environ | {"HOME": str(tmp_path)}
    result = subprocess.run(
        [sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True
    )
    assert result.stdout.split() == ["None", "[]"]


def test_truths_hold_what_actions_change():
    for seed in range(3):
        world = reset(seed)
        rng = np.random.default_rng(seed)
        for _ in range(40):
            world.step(choose(world.commands(), rng))
            assert {fact[0].removeprefix("not_") for fact in world.truth.facts} <= CHANGING
            assert not {fact for fact in world.truth.facts if (f"not_{fact[0]}", *fact[1:]) in world.truth.facts}


@pytest.mark.full
@pytest.mark.parametrize(("engine", "commands"), [("exact", 50), pytest.param("textworld", 2, marks=STOCK)])
def test_memory_is_bounded(engine, commands):
    """300 games in one process."""
    import resource

    world = Alfworld(games="generated", engine=engine)
    rng = np.random.default_rng(0)
    sizes = []
    for seed in range(300):
        world.reset(seed=seed)
        for _ in range(commands):
            world.step(choose(world.commands(), rng))
        sizes.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    print(f"{engine}: {sizes[0]} KiB after the first game, {sizes[50]} after 50, {sizes[-1]} after 300")
    assert sizes[-1] - sizes[50] < 20_000
