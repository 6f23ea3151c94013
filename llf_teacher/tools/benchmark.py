"""Benchmarks: all that is compared is measured in the same run, in turns, and the medians are shown."""

import multiprocessing
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import gymnasium
import numpy as np
import pettingzoo
from gymnasium.spaces import Discrete
from rich.table import Table

from llf_teacher.gym import TeacherEnv, make
from llf_teacher.registry import PREFIX, entry
from pz_envs.family import Family, all_families
from pz_envs.seats import TEACHER
from pz_envs.teacher_seat import SUBSETS

_ROUNDS = 7
_STEPS = 3000
_STEPS_OF_SLOW = 100
_CLASSES = (1, 8, 64)
_CLASS = "ClassroomEnv({})"
_TICTACTOE = "tictactoe-v3"


def _measure(runs: dict[str, Callable[[], float]]) -> dict[str, float]:
    """Median seconds of each run; the runs take turns, so that they share the machine's moods."""
    for run in runs.values():
        run()
    times: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(_ROUNDS):
        for name, run in runs.items():
            times[name].append(run())
    return {name: statistics.median(each) for name, each in times.items()}


def _stepping(env: gymnasium.Env, actions: list[Any], steps: int = _STEPS) -> Callable[[], float]:
    """Seconds per step; resets are not counted."""

    def run() -> float:
        env.reset(seed=0)
        spent = 0.0
        done = 0
        while done < steps:
            begin = time.perf_counter()
            for action in actions:
                _, _, terminated, truncated, _ = env.step(action)
                done += 1
                if terminated or truncated:
                    break
            spent += time.perf_counter() - begin
            env.reset(seed=0)
        return spent / done

    return run


def _turns(env: Any, choose: Callable[[dict[str, Any], str], int], most: int = _STEPS) -> Callable[[], float]:
    """Seconds per turn of an AEC environment, resets included, as its users run it."""

    def run() -> float:
        env.reset(seed=0)
        begin = time.perf_counter()
        turns = 0
        while turns < most:
            env.reset()
            for agent in env.agent_iter():
                observation, _, terminated, truncated, _ = env.last()
                env.step(None if terminated or truncated else choose(observation, agent))
                turns += 1
        return (time.perf_counter() - begin) / turns

    return run


def _actions(family: Family, count: int = 40) -> list[Any]:
    world = family.make_world(**family.environments[family.showcase[0]])
    world.reset(seed=0)  # so that the actions can be those that are possible
    rng = np.random.default_rng(0)
    return [world.sample_action(rng) for _ in range(count)]


def steps() -> Table:
    """Microseconds per step of `make(...)` with all feedback, of the bare world, and of FrozenLake.

    Where the world does the work of another package's environment, the last column is its time over that one's.
    """
    lake = gymnasium.make("FrozenLake-v1")
    runs = {"FrozenLake-v1": _stepping(lake, [0, 1, 2, 3] * 10)}
    for family in all_families():
        name = family.showcase[0]
        actions = _actions(family)
        steps = _STEPS_OF_SLOW if family.slow else _STEPS
        world = family.make_world(**family.environments[name])
        runs[name] = _stepping(make(PREFIX + name), actions, steps)
        runs[f"{name} (world)"] = _stepping(world, actions, steps)
        if original := world.original(actions):
            runs[f"{name} (original)"] = _stepping(original, actions, len(actions))  # it may be slow
    seconds = _measure(runs)
    table = _table("Steps", "environment", "step, us", "bare world, us", "step / FrozenLake", "world / original")
    table.add_row("FrozenLake-v1", f"{seconds['FrozenLake-v1'] * 1e6:.1f}", "", "1.00", "")
    for family in all_families():
        name = family.showcase[0]
        ratio = seconds[name] / seconds["FrozenLake-v1"]
        bare = seconds[f"{name} (world)"]
        other = seconds.get(f"{name} (original)")
        row = f"{seconds[name] * 1e6:.1f}", f"{bare * 1e6:.1f}", f"{ratio:.2f}", f"{bare / other:.2f}" if other else ""
        table.add_row(PREFIX + name, *row)
    return table


def _alone(function: Callable[..., Any], *arguments: Any) -> Any:
    """The result of a function in a fresh process, so that what others left in memory does not slow it."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        return pool.submit(function, *arguments).result()


def seats() -> Table:
    """Turns per second of the bare AEC environments with `speech="kinds"`, each beside PettingZoo's tictactoe."""
    table = _table('Seats, speech="kinds"', "raw_env", "turns/s", "of tictactoe's")
    for family in all_families():
        name = family.showcase[0]
        seconds = _alone(_seat, name)
        table.add_row(name, f"{1 / seconds[name]:,.0f}", f"{seconds[_TICTACTOE] / seconds[name]:.2f}")
    return table


def _seat(name: str) -> dict[str, float]:
    family = entry(PREFIX + name).family
    env = pettingzoo.make("aec", f"llf/{name}", speech="kinds").unwrapped
    steps = _STEPS_OF_SLOW if family.slow else _STEPS
    return _measure({_TICTACTOE: _tictactoe(), name: _turns(env, _all_kinds(_actions(family)), steps)})


def simple_families() -> list[Family]:
    """Families whose first environment has finitely many actions."""
    spaces = ((f, f.make_world(**f.environments[f.showcase[0]]).action_space) for f in all_families() if not f.slow)
    return [family for family, space in spaces if isinstance(space, Discrete)]


def forms() -> Table:
    """Turns per second of every form of the seats with `speech="kinds"`, where the worlds cost least.

    These are the first environments of families with finitely many actions. A turn is one of a teacher or of a student.
    In a classroom the teacher speaks to every student in every round, and `per student` is what a student's turn and
    the words to it cost together, relative to a class of one.
    """
    table = _table('Forms of the seats, speech="kinds"', "form", "turns/s", "of tictactoe's", "per student")
    for family in simple_families():
        seconds = _alone(_forms_of, family.showcase[0])
        for form, each in seconds.items():
            if form != _TICTACTOE:
                per_student = f"{each / seconds[_CLASS.format(_CLASSES[0])]:.2f}" if "Classroom" in form else ""
                ratio = f"{seconds[_TICTACTOE] / each:.2f}"
                table.add_row(f"{family.showcase[0]} {form}", f"{1 / each:,.0f}", ratio, per_student)
    return table


def _forms_of(name: str) -> dict[str, float]:
    _, family, options, _ = entry(PREFIX + name)
    actions = _actions(family)
    runs = {_TICTACTOE: _tictactoe()}
    for form, env in (
        ("raw_env", family.raw_env(speech="kinds", **options)),
        ("env", family.env(speech="kinds", **options)),
    ):
        runs[form] = _turns(env, _all_kinds(actions))
    runs["StudentEnv"] = _gymnasium(make(PREFIX + name), actions)
    runs["TeacherEnv"] = _gymnasium(TeacherEnv(PREFIX + name, student=_Player(actions)), [SUBSETS - 1])
    for students in _CLASSES:
        room = family.raw_env(
            seating="classroom", students=students, attention=students, until_success=False, **options
        )
        runs[_CLASS.format(students)] = _turns(room, _everybody(actions))
    return _measure(runs)


def _tictactoe() -> Callable[[], float]:
    """Seconds per turn of PettingZoo's tictactoe."""
    env = pettingzoo.make("aec", "classic/tictactoe-v3").unwrapped
    return _turns(env, lambda observation, _: int(observation["action_mask"].argmax()))


def _gymnasium(env: gymnasium.Env, actions: list[Any]) -> Callable[[], float]:
    """Seconds per turn of a Gymnasium environment, whose step is a turn of each of both seats; resets included."""

    def run() -> float:
        env.reset(seed=0)
        begin = time.perf_counter()
        turns = done = 0
        while turns < _STEPS:
            env.reset()
            over = False
            while not over:
                _, _, terminated, truncated, _ = env.step(actions[done % len(actions)])
                over = terminated or truncated
                done += 1
                turns += 2
        return (time.perf_counter() - begin) / turns

    return run


class _Player:
    """A student that goes through the given actions."""

    def __init__(self, actions: list[Any]) -> None:
        self._actions, self._turn = actions, 0

    def reset(self, rng: np.random.Generator) -> None:
        """Go on where it was."""

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """The next action."""
        self._turn += 1
        return self._actions[self._turn % len(self._actions)]


def _everybody(actions: list[Any]) -> Callable[[dict[str, Any], str], Any]:
    """A teacher that says everything to one student after the other, and students that go through the actions."""
    turn = 0

    def choose(observation: dict[str, Any], agent: str) -> Any:
        nonlocal turn
        turn += 1
        if agent != TEACHER:
            return actions[turn % len(actions)]
        mask = observation["action_mask"]
        return len(mask) - 1 - int(mask[::-1].argmax())  # the most that can be said to the last who has not heard

    return choose


def _table(title: str, name: str, *figures: str) -> Table:
    table = Table(title=title, title_justify="left", box=None, padding=(0, 2, 0, 0))
    table.add_column(name, no_wrap=True)
    for figure in figures:
        table.add_column(figure, justify="right")
    return table


def _all_kinds(actions: list[Any]) -> Callable[[dict[str, Any], str], Any]:
    """A teacher that says everything, and a student that goes through the given actions."""
    turn = 0

    def choose(observation: dict[str, Any], agent: str) -> Any:
        nonlocal turn
        turn += 1
        return SUBSETS - 1 if agent == TEACHER else actions[turn % len(actions)]

    return choose


def imports() -> Table:
    """Seconds to import this package in a fresh interpreter, beside what it is built on."""
    programs = {"gymnasium, pettingzoo": "import gymnasium, pettingzoo", "llf_teacher": "import llf_teacher"}

    def importing(program: str) -> Callable[[], float]:
        def run() -> float:
            begin = time.perf_counter()
            subprocess.run([sys.executable, "-c", program], check=True)  # noqa: S603
            return time.perf_counter() - begin

        return run

    seconds = _measure({name: importing(program) for name, program in programs.items()})
    table = _table("Imports", "import", "seconds", "ratio")
    for name, each in seconds.items():
        table.add_row(name, f"{each:.2f}", f"{each / seconds['gymnasium, pettingzoo']:.2f}")
    return table
