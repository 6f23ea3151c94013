"""The world of ALFWorld: a house, and commands in it."""

import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from worlds.alfworld.exact import ExactEngine
from worlds.alfworld.games import SPLITS, TASKS, Fact, Game
from worlds.alfworld.generated import draw_law, make
from worlds.alfworld.official import drawn, files, read
from worlds.alfworld.shipped import installed, package
from worlds.alfworld.stock import StockEngine
from worlds.extras import pip_install
from worlds.spaces import Prose
from worlds.towns import town_stream
from worlds.world import World, illegal

ENGINES = {"exact": ExactEngine, "textworld": StockEngine}
ORACLES = ("planner", "explorer")
SOURCES = ("auto", "generated", "official")
MAX_LENGTH = 500
_CONTROL = re.compile(r"[\x00-\x08\x0e-\x1f\x7f-\x9f]").search  # all but white space
_THING = "[a-z]+ [0-9]+"
_COMMAND = re.compile(
    rf"look|inventory|help|(?:go to|open|close|examine|use) {_THING}|take {_THING} from {_THING}"
    rf"|move {_THING} to {_THING}|(?:heat|clean|cool|slice) {_THING} with {_THING}"
)
_LISTED = "\n\nAdmissible commands: "
_THINGS = ("apple", "bowl", "book", "creditcard", "cup", "egg", "knife", "mug", "pen", "pillow", "plate", "soapbar")
_PLACES = ("bed", "cabinet", "countertop", "desk", "drawer", "fridge", "garbagecan", "microwave", "shelf", "sinkbasin")
_TRIED = ("go to {1}", "open {1}", "take {0} from {1}", "move {0} to {1}", "examine {1}", "look", "inventory")
_ASTRAY = 0.1  # share of random commands that may have no effect


class Truth(NamedTuple):
    """The state of a house, and the last answer."""

    facts: frozenset[Fact]
    """The true facts that actions may change, and those that have become false, as `not_...`."""
    feedback: str
    """The answer to the last command, or the introduction."""
    won: bool
    """Whether the task has been completed in this episode."""
    game: Game


class Alfworld(World[Truth, str, str]):
    """A house with a household task.

    Observation: Prose, the answer to the last command and a list of the commands that can be carried out now, which
    is also in the info, as `admissible_commands`.
    Action: Prose, a command, regardless of case and space. The answer to a command that cannot be carried out is
    "Nothing happens.".
    Reward: 1 when the task is completed, which terminates, else 0. Success: the task was completed in this episode.

    Args:
        task: type of the tasks, one of `TASKS`; empty: all of them.
        split: `train`, `valid_seen`, `valid_unseen`, or `all`. Generated games of `valid_unseen` have 24 of the 120
            floor plans; the other splits share the rest.
        games: `official`: the files of `alfworld-download` in the folder of the environment variable ALFWORLD_DATA;
            `generated`: made from a seed and the shipped floor plans; `auto`: official if there are such files.
        oracle: facts that the teacher's oracle uses: `planner`, all of them, or `explorer`, those that were observed.
        engine: `exact`, or `textworld`, the original, which is equal and about a thousand times slower.
        town: number of a town, at least 0; for generated games. Each house of a town keeps objects of one type in
            receptacles of one type, if it has such receptacles. None: objects are anywhere.

    Official games and TextWorld's engine require the extra `alfworld`.

    Raises:
        ValueError: an argument is not allowed, or there are no official games.
        ModuleNotFoundError: the package `alfworld` is needed and not installed.
    """

    reward_range = (0.0, 1.0)
    actions_key = "admissible_commands"
    reset_options = ("game",)
    verbatim = False
    action_syntax = f"one command such as `go to desk 1`, of at most {MAX_LENGTH} characters without control characters"

    _feedback: str
    _won: bool

    def __init__(
        self,
        task: str = "",
        split: str = "all",
        games: str = "auto",
        oracle: str = "planner",
        engine: str = "exact",
        *,
        town: int | None = None,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(
            render_mode=render_mode, task=task, split=split, games=games, oracle=oracle, engine=engine, town=town
        )
        _check("task", task, ("", *TASKS))
        _check("split", split, SPLITS)
        _check("games", games, SOURCES)
        _check("oracle", oracle, ORACLES)
        _check("engine", engine, tuple(ENGINES))
        folder = os.environ.get("ALFWORLD_DATA", "") if games != "generated" else ""
        self._files = files(folder, task, split) if folder else ()
        if games == "official" and not self._files:
            raise ValueError(
                f"games='official' needs game files; ALFWORLD_DATA is {folder!r} and has none for task {task!r}, split"
                f" {split!r}; run `alfworld-download`, after {pip_install('alfworld')}, or allow games='generated'"
            )
        rng = town_stream("alfworld", town)
        if rng and self._files:
            raise ValueError(f"town must be None for official games, got {town!r}; towns need games='generated'")
        self.law = draw_law(rng) if rng else {}
        """For each type of object, the type of receptacle where the town keeps it; empty without a town."""
        if self._files or engine == "textworld":
            package()
        self.observation_space = Prose(max_length=16_384)
        self.action_space = Prose(max_length=MAX_LENGTH)
        self._engine: Any = None  # one of `ENGINES`, once an episode has begun

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[str, dict[str, Any]]:
        """Begin a game.

        Args:
            seed: seed of the world's random stream.
            options: `{"game": path}` plays a game file, with `traj_data.json` beside it.

        Raises:
            ValueError: the file is not a game that can be played.
        """
        self.check_reset(options)
        given = self._given((options or {}).get("game"))
        super().reset(seed=seed, options=options)
        game = given or self._draw()
        self._load(Truth(game.start, "", False, game))
        self._feedback = self._engine.intro()
        return self._observation_and_info()

    @property
    def official(self) -> bool:
        """Whether its games are ALFWorld's own."""
        return bool(self._files)

    @property
    def truth(self) -> Truth:
        """The facts, the last answer, whether the task is completed, and the game."""
        return Truth(self._engine.facts, self._feedback, self._won, self._engine.game)

    def legal(self, action: Any) -> str:
        """The command in lower case with single spaces."""
        if not self.action_space.contains(action) or _CONTROL(action):
            raise illegal(action, f"a text of at most {MAX_LENGTH} characters without control characters")
        return " ".join(action.lower().split())

    def read(self, text: str) -> str | None:
        """The command in a text, executable now or not; None if the text does not have the form of a command."""
        command = " ".join(text.lower().split()) if len(text) <= MAX_LENGTH else ""
        return command if _COMMAND.fullmatch(command) else None

    def advance(self, action: str) -> tuple[str, float, bool, bool, dict[str, Any]]:
        """Carry out a command."""
        self._feedback = self._engine.do(action)
        first = not self._won and self._engine.won()
        if first:
            self._won = True
        observation, info = self._observation_and_info()
        return observation, 1.0 if first else 0.0, self._won, False, info

    def observe(self) -> str:
        """The last answer and the commands that can be carried out now."""
        return self._observation_and_info()[0]

    def describe(self, observation: str) -> str:
        """The observation, which is text."""
        return observation

    def commands(self) -> list[str]:
        """The commands that can be carried out now, sorted."""
        found: list[str] = self._engine.commands()
        return found

    def sample_action(self, rng: np.random.Generator) -> str:
        """A random command, mostly one that can be carried out."""
        if self._engine is not None and rng.random() > _ASTRAY:
            commands = self.commands()
            return commands[rng.integers(len(commands))]
        pattern, thing, place = (each[rng.integers(len(each))] for each in (_TRIED, _THINGS, _PLACES))
        return pattern.format(f"{thing} {rng.integers(1, 4)}", f"{place} {rng.integers(1, 4)}")

    def original(self, actions: Sequence[Any], seed: int) -> "Alfworld | None":
        """The same world on TextWorld's engine, if that is installed."""
        return type(self)(**self.options | {"engine": "textworld"}) if installed() else None

    def __getstate__(self) -> dict[str, Any]:
        state = self.__dict__ | {"_engine": None}
        return state if self._engine is None else state | {"_kept": self.truth}

    def __setstate__(self, state: dict[str, Any]) -> None:
        kept = state.pop("_kept", None)
        self.__dict__.update(state)
        if kept is not None:
            self._load(kept)

    def draw_options(self, rng: np.random.Generator) -> dict[str, Any]:
        """Any type of tasks, and either oracle."""
        tasks = ("", *TASKS)
        return self.options | {
            "task": tasks[rng.integers(len(tasks))],
            "oracle": ORACLES[rng.integers(len(ORACLES))],
        }

    def _load(self, truth: Truth) -> None:
        if self._engine is None or self._engine.game is not truth.game:
            self._engine = ENGINES[self.options["engine"]](truth.game)
        self._engine.load(truth.facts)
        self._feedback, self._won = truth.feedback, truth.won

    def _observation_and_info(self) -> tuple[str, dict[str, Any]]:
        """The observation and the info."""
        commands = self._engine.commands()
        info = {"success": self._won, self.actions_key: commands}
        return f"{self._feedback}{_LISTED}{', '.join(commands)}", info

    def _given(self, path: str | os.PathLike[str] | None) -> Game | None:
        """The game of a file; None without a path."""
        if path is None:
            return None
        if self.law:
            raise ValueError("option 'game' must be None in a town, whose games are generated")
        if not isinstance(path, str | os.PathLike):
            raise ValueError(f"option 'game' must be the path of a game file, got {path!r}")
        game = read(Path(path))
        if game is None:
            raise ValueError(f"option 'game' must be a file whose game can be solved, got {str(path)!r}")
        return game

    def _draw(self) -> Game:
        if self._files:
            return drawn(self.np_random, self._files)
        return make(self.np_random, self.options["task"], self.options["split"], self.law)


def _check(name: str, value: Any, allowed: tuple[str, ...]) -> None:
    if value not in allowed:
        raise ValueError(f"{name} must be one of {', '.join(map(repr, allowed))}, got {value!r}")
