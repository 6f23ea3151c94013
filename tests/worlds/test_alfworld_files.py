"""ALFWorld: games from files in the official format, and what is missing without its package."""

import json
import os
import sys
from pathlib import Path

import numpy as np
import pytest
from houses import STOCK

from worlds.alfworld import Alfworld
from worlds.alfworld.games import SPLITS, TASKS
from worlds.alfworld.generated import make
from worlds.alfworld.shipped import package, rules


@pytest.fixture
def bare(monkeypatch):
    """As if the `alfworld` package were not installed."""
    package.cache_clear()
    rules.cache_clear()
    monkeypatch.setitem(sys.modules, "alfworld", None)


@pytest.fixture
def official(tmp_path, monkeypatch):
    """A folder of small game files in the official format: per split one game, and one that cannot be solved."""
    domain, grammar = rules()

    def write(split, number, solvable=True):
        played = make(np.random.default_rng(number), TASKS[number % 6], "all")
        name = f"{played.task}-{played.target.title()}-None-{played.destination.title() or played.lamp}-{number}"
        folder = tmp_path / "json_2.1.1" / split / name / "trial_T1"
        folder.mkdir(parents=True)
        typed = {each.lower(): each for each in played.problem.replace("Type", " ").split()}
        params = {
            "object_target": typed[played.target],
            "parent_target": typed.get(played.destination, ""),
            "toggle_target": "DeskLamp" if played.lamp else "",
            "mrecep_target": "",
        }
        trial = {"task_type": played.task, "pddl_params": params}
        text = grammar.replace("UNKNOWN GOAL", played.goal)
        files = {"pddl_domain": domain, "grammar": text, "pddl_problem": played.problem, "solvable": solvable}
        (folder / "traj_data.json").write_text(json.dumps(trial))
        (folder / "game.tw-pddl").write_text(json.dumps(files))
        return played, folder / "game.tw-pddl"

    written = {split: write(split, i) for i, split in enumerate(SPLITS[1:])}
    write("train", 9, solvable=False)
    monkeypatch.setenv("ALFWORLD_DATA", str(tmp_path))
    return written


def test_what_needs_alfworld_says_so(bare, tmp_path, monkeypatch):
    folder = tmp_path / "json_2.1.1" / "train" / f"{TASKS[0]}-Mug-None-Bed-1" / "trial_T1"
    folder.mkdir(parents=True)
    (folder / "game.tw-pddl").touch()
    needs = r"need the package 'alfworld', which is not installed; run: pip install 'llf-teacher\[alfworld\]'"
    with pytest.raises(ModuleNotFoundError, match=needs):
        Alfworld(games="generated", engine="textworld").reset(seed=0)
    monkeypatch.setenv("ALFWORLD_DATA", str(tmp_path))
    for games in ("auto", "official"):
        with pytest.raises(ModuleNotFoundError, match=needs):
            Alfworld(games=games)
    world = Alfworld(games="generated")
    with pytest.raises(ModuleNotFoundError, match=needs):
        world.reset(options={"game": folder / "game.tw-pddl"})
    assert world.original([], 0) is None


@STOCK
@pytest.mark.parametrize("split", SPLITS[1:])
def test_official_files_are_played_where_there_are_any(official, split):
    played, path = official[split]
    for options in ({"split": split}, {"task": played.task, "games": "official"}):
        world = Alfworld(**options)
        for seed in range(5):
            world.reset(seed=seed)
            assert world.truth.game == played
    other = Alfworld(games="generated")
    other.reset(seed=0, options={"game": path})
    assert other.truth.game == played


@STOCK
def test_all_splits_are_drawn_from(official):
    world = Alfworld()
    goals = {(world.reset(seed=seed), world.truth.game.goal)[1] for seed in range(40)}
    assert goals == {played.goal for played, _ in official.values()}


@STOCK
@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"pddl_domain": "(define (domain other))"}, "its domain is not that of the installed alfworld package"),
        ({"grammar": "grammar :: nothing"}, "its grammar is not that of the installed alfworld package"),
        ({"pddl_problem": "(define)"}, "a PDDL problem must have :objects, :init and :goal"),
    ],
)
def test_files_of_other_rules_are_refused(official, change, reason):
    _, path = official["train"]
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(ValueError, match=rf"not a game of the installed alfworld: .*{reason}.* allowed: game.tw-pddl"):
        Alfworld().reset(seed=0, options={"game": path})


@STOCK
@pytest.mark.parametrize("text", ["", "{", "[]", "{}"])
def test_broken_files_are_named(official, text):
    _, path = official["train"]
    path.write_text(text)
    with pytest.raises(ValueError, match=r"game\.tw-pddl is not a game of the installed alfworld"):
        Alfworld().reset(seed=0, options={"game": path})
    with pytest.raises(ValueError, match="is not a game of the installed alfworld"):
        Alfworld().reset(seed=0, options={"game": path.parent / "missing"})


@STOCK
def test_unsolvable_games_are_never_drawn(official):
    for path in Path(os.environ["ALFWORLD_DATA"]).rglob("game.tw-pddl"):
        path.write_text(json.dumps(json.loads(path.read_text()) | {"solvable": False}))
    with pytest.raises(ValueError, match="none of the 4 game files can be solved"):
        Alfworld().reset(seed=0)
    with pytest.raises(ValueError, match="must be a file whose game can be solved"):
        Alfworld().reset(seed=0, options={"game": official["train"][1]})
