"""A silent teacher that chooses the starts of episodes, from near the goal to far from it (Florensa et al. 2017)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from llf_teacher.registry import entry
from llf_teacher.reproductions.drawing import line, name_lines
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.reproductions.rule import Rule, saves
from llf_teacher.students.builtin.q_learning import QLearning
from llf_teacher.studies.analysis.statistics import paired_difference
from pz_envs.assembly import assemble
from pz_envs.settings import Settings
from worlds.gridworld import Truth, distances_from

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STARTS = ("the task's own", "anywhere", "from near to far")
PRACTICE = (50, 100, 200, 400, 800)
"""Moves of practice."""
TURNS, TESTS, LEAST, READY = 40, 5, 6, 2
"""Greatest number of moves of an episode; episodes of the test; least distance of the task's own start; successive
mastered episodes before the next distance."""
REGRET = "regret per episode of the test"
LEARNER = QLearning(forget=False, optimism=0.0, epsilon=0.1)


class _Practice:
    """A learner in one house, which can start in any room."""

    def __init__(self, seed: int) -> None:
        family = entry("llf-gridworld-v0").family
        settings = Settings(speech="kinds", max_turns=TURNS, until_success=True, options={"min_goal_dist": LEAST})
        self.session, self.view, _ = assemble(family, settings)
        self.session.open(seed)
        self.task: Truth = self.session.moment.after
        self.steps = distances_from(self.task.layout.treasure, self.task.layout.doors)
        """Moves to the treasure, by room."""
        self.pupil: Any = LEARNER.seat(family, self.session.world)
        self.rng = np.random.default_rng(seed)

    def episode(self, room: int, turns: int) -> tuple[int, float, bool]:
        """Play an episode from a room; gives its moves, its wasted moves, and whether the treasure was found."""
        session, view, pupil = self.session, self.view, self.pupil
        session.start_next_episode(self.task._replace(room=room))
        pupil.reset(self.rng)
        wasted = 0.0
        while not session.over and session.moment.turn < turns:
            session.say_kinds(0)
            session.act(pupil.act(view.observe(), view.info_for(pupil)))
            wasted += session.teacher.oracle.regret(session.moment)
        pupil.finish(view.observe(), view.info_for(pupil), session.terminated)
        return session.moment.turn, wasted, session.moment.success


def measure(starts: str, practice: int, seed: int) -> Sequence[float]:
    """Moves wasted per episode of a test after practice, and the share of episodes with success."""
    school = _Practice(seed)
    steps, own = np.array(school.steps), school.task.room
    far, mastered, left = 1, 0, practice
    while left > 0:
        away = steps == far if starts == "from near to far" else steps > 0
        room = own if starts == STARTS[0] or far >= steps[own] else int(school.rng.choice(np.flatnonzero(away)))
        turns, _, found = school.episode(room, left)
        left -= turns
        mastered = mastered + 1 if found and turns <= 2 * far else 0
        if starts == "from near to far" and mastered == READY:
            far, mastered = far + 1, 0
    tests = [school.episode(own, TURNS) for _ in range(TESTS)]
    school.session.world.close()
    return [float(np.mean([wasted for _, wasted, _ in tests])), float(np.mean([found for *_, found in tests]))]


def read(values: Values) -> Reading:
    """Regret in the test, and what the curriculum saves by the moves of practice."""
    table = [["start of practice", *(f"{moves} moves" for moves in PRACTICE)]]
    for starts in STARTS:
        table.append([starts, *(describe(values.means(starts=starts, practice=n)[0], 1) for n in PRACTICE)])
    beside = {
        other: [
            paired_difference(
                values(starts=other, practice=n)[:, 0], values(starts="from near to far", practice=n)[:, 0]
            ).estimate
            for n in PRACTICE
        ]
        for other in STARTS[:2]
    }
    names = ("the own start", "anywhere")
    parts = [
        f"{', '.join(describe(each, 1) for each in found)} moves an episode beside practice from {name}"
        for name, found in zip(names, beside.values(), strict=True)
    ]
    ours = (
        f"With {', '.join(map(str, PRACTICE))} moves, practice that begins near the treasure and moves away from it "
        f"saves {', and '.join(parts)}."
    )
    why = (
        "In a house practice from anywhere often finds the treasure, too, since some rooms are always near it; for the "
        "paper's robots a random start is as hopeless as the task's own."
    )
    return Reading(ours, why, table)


def draw(values: Values, figure: "Figure") -> None:
    """Regret in the test by the moves of practice."""
    axes = figure.subplots()
    for starts in STARTS:
        found = [values.means(starts=starts, practice=n)[0] for n in PRACTICE]
        line(axes, PRACTICE, found, starts)
    axes.set(xlabel="moves of practice", ylabel="moves wasted in an episode of the test", xscale="log")
    name_lines(figure)


ROW = Row(
    claim="Practice that begins near the goal and moves away from it learns rare rewards with less experience",
    source="Florensa et al. 2017",
    protocol=(
        f"Houses of 20 rooms with the treasure at least {LEAST} moves from the start, rewards only, Q-learning. The "
        "teacher is silent and chooses the room in which an episode of practice begins: the task's own start, any "
        "room, or one at a distance that grows by a move when the treasure was found twice in a row in at most twice "
        f"as many moves. After {PRACTICE[0]} to {PRACTICE[-1]} moves of practice come {TESTS} episodes of at most "
        f"{TURNS} moves from the own start. Figures are moves wasted in each of them. The paper has robots and "
        "policy gradients."
    ),
    rule=Rule(
        seeds=100,
        comparisons=tuple(
            saves(
                f"practice from near to far wastes less than practice from {start}, after {moves} moves",
                {"starts": STARTS[2], "practice": moves},
                {"starts": start, "practice": moves},
                REGRET,
            )
            for start in STARTS[:2]
            for moves in PRACTICE
        ),
    ),
    settings=tuple({"starts": starts, "practice": moves} for starts in STARTS for moves in PRACTICE),
    measure=measure,
    measures=(REGRET, "share of them with success"),
    read=read,
    draw=draw,
)
