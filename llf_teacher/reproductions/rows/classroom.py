"""Attention for a class of learners: which one to advise in each round (after Torrey & Taylor 2013)."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from llf_teacher.registry import entry
from llf_teacher.reproductions.drawing import bars
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.reproductions.rule import Rule, saves
from llf_teacher.students.builtin.q_learning import QLearning
from llf_teacher.studies.analysis.statistics import mean_interval, paired_difference
from pz_envs.parallel_seats import ParallelSeats
from pz_envs.seats import TEACHER

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PUPILS, ATTENTION, EPISODES, TURNS = 8, (1, 2), 20, 40
LEARNER = QLearning(trust=1.0, forget=False, optimism=0.0, epsilon=0.1)
_ADVICE, _IMPORTANCE = 0b01000, 2  # fp among the kinds; the column of `students`


class Class(NamedTuple):
    """What a teacher observes when it distributes its attention, one value per student."""

    importance: NDArray[np.float64]
    """Moves between the best and the worst next action."""
    heard: NDArray[np.float64]
    """The round of the last advice to the student; 0: never."""
    wasted: NDArray[np.float64]
    """Moves that the student has wasted in its lifetime."""
    chance: NDArray[np.float64]
    """Uniform random number."""


RULES: dict[str, Callable[[Class], NDArray[np.float64]] | None] = {
    "nobody": None,
    "at random": lambda seen: seen.chance,
    "who waited longest": lambda seen: -seen.heard + 1e-6 * seen.chance,
    "most at stake": lambda seen: seen.importance + 1e-6 * seen.chance,
    "who wasted most": lambda seen: seen.wasted + 1e-6 * seen.chance,
    "who wasted least": lambda seen: -seen.wasted + 1e-6 * seen.chance,
}
"""Gives ranks; the student with the greatest rank is advised, ties are broken at random."""
REGRET, STAKE = "regret per student and episode", "most at stake"


def measure(rule: str, attention: int, seed: int) -> Sequence[float]:
    """Moves wasted per episode: the mean over students, and the greatest of a student."""
    rank, rng = RULES[rule], np.random.default_rng(seed)
    family = entry("llf-gridworld-v0").family
    seated: dict[str, Any] = {"seating": "classroom", "students": PUPILS, "attention": attention}
    lifetimes = family.raw_env(speech="kinds", feedback_type="fp", episodes=EPISODES, max_cycles=TURNS, **seated)
    room: Any = lifetimes.unwrapped
    env = ParallelSeats(lifetimes, {name: LEARNER.seat(family, room.sessions[0].world) for name in room.students})
    observations, infos = env.reset(seed=seed)
    advice = [room.address(i, _ADVICE) for i in range(PUPILS)]
    oracles, last = [session.teacher.oracle for session in room.sessions], infos[TEACHER]["moments"]
    heard, wasted, rounds = np.zeros(PUPILS), np.zeros(PUPILS), 0
    while env.agents:
        seen, moments = observations[TEACHER], infos[TEACHER]["moments"]
        for i, (now, before) in enumerate(zip(moments, last, strict=True)):
            if now is not before and now.turn:
                wasted[i] += oracles[i].regret(now)
        may, last = seen["action_mask"][advice] > 0, moments
        rounds += 1
        action = 0
        if rank is not None and may.any():
            known = Class(seen["students"][:, _IMPORTANCE], heard, wasted, rng.random(PUPILS))
            student = int(np.where(may, rank(known), -np.inf).argmax())
            heard[student], action = rounds, advice[student]
        observations, _, _, _, infos = env.step({TEACHER: action})
    env.close()
    return [float(wasted.mean()) / EPISODES, float(wasted.max()) / EPISODES]


def _worded(rule: str) -> str:
    return "attention at random" if rule == "at random" else f"attention to the one {rule}"


def _lost(values: Values, rule: str, column: int) -> list[NDArray[np.float64]]:
    return [values(rule=rule, attention=attention)[:, column] for attention in ATTENTION]


def read(values: Values) -> Reading:
    """Regret of all and of the last of the class, and what each rule saves beside turns in order."""
    heads = [f"{whose}, attention for {n}" for whose in ("all", "the last of the class") for n in ATTENTION]
    table = [["who is advised", *heads]]
    for rule in RULES:
        table.append(
            [rule, *(describe(mean_interval(each)) for column in (0, 1) for each in _lost(values, rule, column))]
        )

    def saved(rule: str, than: str, column: int) -> list[str]:
        pairs = zip(_lost(values, than, column), _lost(values, rule, column), strict=True)
        return [describe(paired_difference(other, mine).estimate) for other, mine in pairs]

    turns = "who waited longest"
    gains = [
        paired_difference(other, mine).estimate
        for other, mine in zip(_lost(values, turns, 0), _lost(values, "most at stake", 0), strict=True)
    ]
    ours = (
        f"Attention where most is at stake saves {' and '.join(map(describe, gains))} moves an episode beside turns in "
        f"order, with attention for {' and '.join(map(str, ATTENTION))} of {PUPILS}. Attention to the student that "
        "wasted least, beside that to the one that wasted most, saves "
        f"{' and '.join(saved('who wasted least', 'who wasted most', 0))}; the last of the class then wastes "
        f"{' and '.join(saved('who wasted most', 'who wasted least', 1))} more."
    )
    why = (
        "What is at stake in the next move does not tell how long a student will profit. The best rule depends on the "
        "aim, too: a student that has reached the treasure needs no more attention, so that "
        "favouring good students improves the mean, and favouring poor ones improves the last of the class."
    )
    return Reading(ours, why, table)


def draw(values: Values, figure: "Figure") -> None:
    """Regret of all, and of the last of the class."""
    panels = figure.subplots(1, 2)
    for column, (axes, title) in enumerate(zip(panels, ("all", "the last of the class"), strict=True)):
        found = {
            rule: [mean_interval(each) for each in _lost(values, rule, column)] for rule in RULES if rule != "nobody"
        }
        bars(axes, [f"attention for {n}" for n in ATTENTION], found)
        axes.set(title=title, ylabel="regret per episode")
    panels[0].legend(fontsize="small")


ROW = Row(
    claim="Attention is worth most where most is at stake, in a class as with one student",
    source="Torrey & Taylor 2013, carried over to a class",
    protocol=(
        f"{PUPILS} students, each with Q-learning in a house of 20 rooms of its own, {EPISODES} episodes of at most "
        f"{TURNS} moves from the same room. In each round the teacher advises one or two of them, which take the "
        "advised action for the turn; a student that has found the treasure is out of the round. It chooses by a rule, "
        "and breaks ties at random. "
        "Figures are moves wasted per student and episode, and those of the student that wasted most. The paper has "
        "one student; that a class is alike is tried here."
    ),
    rule=Rule(
        seeds=40,
        comparisons=tuple(
            saves(
                f"where most is at stake, attention for {attention} of {PUPILS} wastes less than {_worded(rule)}",
                {"rule": STAKE, "attention": attention},
                {"rule": rule, "attention": attention},
                REGRET,
            )
            for attention in ATTENTION
            for rule in RULES
            if rule not in ("nobody", STAKE)
        ),
    ),
    settings=tuple({"rule": rule, "attention": attention} for attention in ATTENTION for rule in RULES),
    measure=measure,
    measures=(REGRET, "of the one with most"),
    read=read,
    draw=draw,
)
