"""The table of environments that planned teachers teach: what is known of each, how fast they are, and how true."""

import itertools
import os
import statistics
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from llf_teacher.episodes.loop import play_turns
from llf_teacher.gym import StudentEnv
from llf_teacher.students.parsing import parse_student
from llf_teacher.tools import markdown
from llf_teacher.tools.audit import audit
from pz_envs.registered import Registered, RegisteredLesson, registered
from pz_envs.settings import Settings
from teachers.atoms import Label
from teachers.planning.cache import FOLDER

__all__ = ["ROWS", "PlannedCase", "measure", "update"]

COMMAND, TABLE = "llf dev planned", "environments"
_TIMED = 5  # turns are timed for each that is audited
_LIAR = "mistake(eps=1)"
_HEAD = (
    "environment",
    "tier",
    "by",
    "size",
    "first turn, s",
    "again, s",
    "turn, µs: mean (median)",
    "bare step, µs",
    "episodes, turns",
    "success: obedient, random",
    "return: obedient, random",
    "claims",
    "false",
    "false of a liar's",
)


@dataclass(frozen=True)
class PlannedCase:
    """An environment of the table."""

    id: str
    options: Mapping[str, Any] = field(default_factory=dict)
    """Of its world."""
    turns: int = 2000
    """Turns of an audit."""
    episodes: int = 200
    """Episodes of each student."""

    @property
    def name(self) -> str:
        """The id with the options."""
        given = ", ".join(f"{name}={value!r}" for name, value in self.options.items())
        return f"`{self.id}`" + (f", `{given}`" if given else "")


ROWS = (
    PlannedCase("gym:FrozenLake-v1", {"map_name": "8x8"}),
    PlannedCase("gym:Taxi"),
    PlannedCase("gym:CliffWalking"),
    PlannedCase("gym:Blackjack-v1", episodes=2000),
    PlannedCase("gym:MiniGrid-DoorKey-5x5-v0", turns=500, episodes=50),
    PlannedCase("gym:MiniGrid-MultiRoom-N2-S4-v0", {"oracle": "searched"}, turns=100, episodes=20),
    PlannedCase("gym:MountainCar-v0", turns=20, episodes=5),
    PlannedCase("gym:CartPole-v1", turns=50, episodes=10),
    PlannedCase("gym:Acrobot-v1", turns=50, episodes=20),
    PlannedCase("gym:BabyAI-GoToLocal-v0", {"oracle": "expert"}, turns=20, episodes=20),
    PlannedCase("gym:LunarLander-v3", turns=5, episodes=3),
    PlannedCase("gym:highway-fast-v0", turns=2, episodes=2),
    PlannedCase("gym:worlds.wrapped.coin_collector:CoinCollector", turns=5, episodes=10),
)
"""The environments of the table; each is a line. Where a turn is slow, fewer of them are played."""


def update(text: str, rows: list[dict[str, str]]) -> str:
    """The text with these rows in the table between the markers `<!-- llf dev planned: environments -->` and `end`.

    Rows of other environments stay.

    Raises:
        ValueError: there are no markers.
    """
    if TABLE not in markdown.marked(text, COMMAND):
        raise ValueError(f"the document must have the markers `<!-- {COMMAND}: {TABLE} -->` and `<!-- end -->`")
    before = [dict(zip(_HEAD, cells, strict=True)) for cells in markdown.rows(text, COMMAND, TABLE)]
    found = {row[_HEAD[0]]: row for row in (*before, *rows)}  # a new row stands where the old one did
    return markdown.update(text, COMMAND, {TABLE: table(list(found.values()))})


def table(rows: list[dict[str, str]]) -> str:
    """The rows as Markdown."""
    return markdown.table(_HEAD, (row.values() for row in rows))


def measure(row: PlannedCase, progress: Callable[[str], object] = str) -> dict[str, str]:
    """The cells of a row, by the names of the columns.

    All times are those of the process: up to the first turn with an empty cache, and again with what that has stored;
    of turns and of bare steps, which take turns, in random play of episodes with new seeds.

    Raises:
        ValueError: no tier serves the environment, or it is not installed.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of ids without a version
        subject = registered(row.id)
    with _cache():
        progress(f"{row.id}: planning")
        cold, lesson = _first_turn(subject, row.options)
        warm, _ = _first_turn(subject, row.options)
        progress(f"{row.id}: turns")
        turns, steps = _times(lesson, subject, row)
        played = {}
        for student in ("obedient", "random"):
            progress(f"{row.id}: {student}")
            played[student] = _played(lesson, student, row.episodes)
        progress(f"{row.id}: audit")
        honest, liar = (audit(subject.id, teacher, turns=row.turns, **row.options) for teacher in ("oracle", _LIAR))
    plan = lesson.planned
    if plan is None:
        raise ValueError(f"{row.id}: no planner was used; leave the option oracle='rewards' out")
    said = sum(number for (kind, _), number in liar.claims.items() if kind is not None)
    cells = (
        PlannedCase(subject.id, row.options).name,
        plan.tier,
        plan.why,
        plan.size,
        f"{cold:.2f}",
        f"{warm:.2f}",
        f"{1e6 * statistics.fmean(turns):.0f} ({1e6 * statistics.median(turns):.0f})",
        f"{1e6 * statistics.fmean(steps):.0f} ({1e6 * statistics.median(steps):.0f})",
        f"{row.episodes:,}, {row.turns:,}",
        ", ".join(f"{100 * success:.0f} %" for success, _ in played.values()),
        ", ".join(f"{earned:.3g}" for _, earned in played.values()),
        f"{honest.checked:,}",
        f"{honest.count(Label.DISTORTED):,}",
        f"{liar.count(Label.DISTORTED):,} of {said:,}",
    )
    return dict(zip(_HEAD, cells, strict=True))


@contextmanager
def _cache() -> Iterator[None]:
    """An empty folder as the cache."""
    before = os.environ.get(FOLDER)
    with tempfile.TemporaryDirectory() as folder:
        os.environ[FOLDER] = folder
        try:
            yield
        finally:
            os.environ.pop(FOLDER)
            if before is not None:
                os.environ[FOLDER] = before


def _first_turn(subject: Registered, options: Mapping[str, Any]) -> tuple[float, RegisteredLesson]:
    """Seconds up to the opening of the first episode, where nothing was planned in this process."""
    anew = Registered(subject.spec, subject.module)
    begun = time.process_time()
    with closing(StudentEnv(anew, **options)) as env:
        env.reset(seed=0)
    seconds = time.process_time() - begun
    return seconds, anew.for_lesson(Settings(options=options))


def _times(lesson: RegisteredLesson, subject: Registered, row: PlannedCase) -> tuple[list[float], ...]:
    """Seconds of each turn and of each step of the environment itself, in turns, so that both find the same caches."""
    world = subject.make_world(**row.options)
    with closing(StudentEnv(lesson)) as taught, closing(subject.make(row.options)) as bare:
        pairs = zip(_steps(taught, world.sample_action), _steps(bare, world.sample_action), strict=False)
        return tuple(map(list, zip(*itertools.islice(pairs, _TIMED * row.turns), strict=True)))


def _steps(env: Any, sample: Callable[[np.random.Generator], Any]) -> Iterator[float]:
    rng = np.random.default_rng(0)
    for seed in itertools.count():
        env.reset(seed=seed)
        over = False
        while not over:
            action = sample(rng)
            begun = time.process_time()
            _, _, terminated, truncated, _ = env.step(action)
            yield time.process_time() - begun
            over = terminated or truncated


def _played(lesson: RegisteredLesson, student: str, episodes: int) -> tuple[float, float]:
    """The share of episodes that succeed, and the mean return, where the teacher gives nothing but advice."""
    player = parse_student(student)
    solved, earned = 0, 0.0
    with closing(StudentEnv(lesson, text=player.text, feedback_type="fp")) as env:
        policy = player.seat(env.family, env.session.world)
        for seed in range(episodes):
            success = False
            for turn in play_turns(env, policy, seed):
                earned += turn.moment.reward
                success = turn.moment.success
            solved += success
    return solved / episodes, earned / episodes
