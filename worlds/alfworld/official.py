"""Games in ALFWorld's own files, which `alfworld-download` downloads."""

import json
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np

from worlds.alfworld.games import SPLITS, TASKS, Game, parse, uncommented
from worlds.alfworld.shipped import rules

_WORDS = {"obj": "object", "recep": "parent", "toggle": "toggle", "mrecep": "mrecep"}


@cache
def files(folder: str, task: str, split: str) -> tuple[Path, ...]:
    """The official game files below a folder, sorted; names of folders give split and task.

    Tasks with movable or sliced objects are left out, as in ALFWorld.
    """
    splits = SPLITS[1:] if split == "all" else (split,)
    found = [
        path
        for each in splits
        for path in Path(folder).glob(f"json_*/{each}/*/*/game.tw-pddl")
        if _task_of(path) in ((task,) if task else TASKS) and "Sliced" not in path.parts[-3]
    ]
    return tuple(sorted(found))


def _task_of(path: Path) -> str:
    return path.parts[-3].partition("-")[0]


def read(path: Path) -> Game | None:
    """Read the game of an official file, with `traj_data.json` beside it; None if it is marked as unsolvable.

    Raises:
        ValueError: it is not such a file, or its rules differ from those of the installed package.
        ModuleNotFoundError: the package is not installed.
    """
    domain, grammar = rules()
    try:
        game = json.loads(path.read_text(encoding="utf-8"))
        trial = json.loads((path.parent / "traj_data.json").read_text(encoding="utf-8"))
        if not game.get("solvable", True):
            return None
        params = trial["pddl_params"]
        words = {key: params[f"{long}_target"] for key, long in _WORDS.items()}
        task = re.search(r"Your task is to: (.*?)\.\"", game["grammar"])
        if task is None or _bare(game["grammar"].replace(task[1], "UNKNOWN GOAL")) != _bare(grammar):
            raise ValueError("its grammar is not that of the installed alfworld package")
        if _bare(game["pddl_domain"]) != _bare(domain):
            raise ValueError("its domain is not that of the installed alfworld package")
        return parse(game["pddl_problem"], trial["task_type"], words, task[1])
    except (OSError, KeyError, TypeError, AttributeError, ValueError) as error:
        raise ValueError(
            f"{path} is not a game of the installed alfworld: {error!r}; allowed: game.tw-pddl with traj_data.json"
            " beside it, as `alfworld-download` of the installed version downloads them"
        ) from error


def _bare(code: str) -> list[str]:
    """Code without comments, space and case."""
    return uncommented(code).lower().split()


def drawn(rng: np.random.Generator, paths: tuple[Path, ...]) -> Game:
    """Draw a game of these files.

    Raises:
        ValueError: none of them can be played.
    """
    for path in _shuffled(rng, paths):
        game = read(path)
        if game is not None:
            return game
    raise ValueError(f"none of the {len(paths)} game files can be solved, the first being {paths[0]}")


def _shuffled(rng: np.random.Generator, paths: tuple[Path, ...]) -> Iterator[Path]:
    yield paths[rng.integers(len(paths))]
    for i in rng.permutation(len(paths)).tolist():
        yield paths[i]
