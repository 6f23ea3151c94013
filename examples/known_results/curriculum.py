"""Does practice that begins near the goal learn rare rewards with less experience? After Florensa et al. 2017.

The paper: starts that begin near the goal and move away from it, as fast as they are mastered, teach robots what random
starts do not. Here a student learns a house of 20 rooms by Q-learning from rewards alone; the treasure is at least 6
moves from the task's own start. The teacher is silent and chooses the room where an episode of practice begins: the
task's own start, any room, or a room at a distance that grows by a move when the treasure was found twice in a row in
at most twice as many moves. After the practice come five episodes of at most 40 moves from the task's own start.

Declared before: after 50, 100, 200, 400 and 800 moves of practice from near to far, at least a tenth fewer moves are
wasted in an episode of the test than after practice from the task's own start, and than after practice from anywhere.

    python examples/known_results/curriculum.py --plot docs/known-curriculum.png
"""

import numpy as np
from _shared import cell, draw_line, parsed, played, print_table, print_verdict, saving

import llf_teacher
from worlds.gridworld import distances_from

OWN, ANYWHERE, OUTWARDS = STARTS = ("the task's own", "anywhere", "from near to far")
PRACTICE = (50, 100, 200, 400, 800)
TURNS, TESTS, READY = 40, 5, 2
"""Most moves of an episode; episodes of the test; mastered episodes in a row before the next distance."""
STUDENT = "q_learning(forget=False, optimism=0.0, epsilon=0.1)"


class School:
    """A student in one house, in which an episode can begin in any room."""

    def __init__(self, seed: int) -> None:
        house = {"min_goal_dist": 6}
        self.env = llf_teacher.make(
            "llf-gridworld-v0", teacher="silent", until_success=True, max_turns=TURNS, options=house
        )
        self.env.reset(seed=seed)
        self.start = self.env.moment.after
        layout = self.start.layout
        self.distances = np.array(distances_from(layout.treasure, layout.doors))
        """Moves to the treasure, by room."""
        self.student, self.rng = self.env.seat(STUDENT), np.random.default_rng(seed)

    def episode(self, room: int, turns: int) -> tuple[int, float, bool]:
        """Play an episode from a room: its moves, its wasted moves, and whether the treasure was found."""
        env, student = self.env, self.student
        env.start_next_episode(self.start._replace(room=room))
        student.reset(self.rng)
        wasted = 0.0
        while (values := env.values()) is not None and env.moment.turn < turns:
            action = student.act(*env.seen_by(student))
            env.step(action)
            wasted += max(values) - values[action]
        student.finish(*env.seen_by(student), env.moment.success)
        return env.moment.turn, wasted, env.moment.success


def measure(starts: str, practice: int, seed: int) -> list[float]:
    """Moves wasted in an episode of the test."""
    school = School(seed)
    own, far, mastered, left = school.start.room, 1, 0, practice
    while left > 0:
        rooms = school.distances == far if starts == OUTWARDS else school.distances > 0
        from_own = starts == OWN or far >= school.distances[own]
        room = own if from_own else int(school.rng.choice(np.flatnonzero(rooms)))
        moves, _, found = school.episode(room, left)
        left -= moves
        mastered = mastered + 1 if found and moves <= 2 * far else 0
        if starts == OUTWARDS and mastered == READY:
            far, mastered = far + 1, 0
    return [float(np.mean([school.episode(own, TURNS)[1] for _ in range(TESTS)]))]


def main() -> None:
    """Practise and test, print the table and the verdict, draw the plot."""
    given = parsed(__doc__, seeds=100)
    found = played(measure, [(starts, moves) for starts in STARTS for moves in PRACTICE], given.seeds)
    wasted = {setting: values[:, 0] for setting, values in found.items()}
    heads = ["start of practice", *(f"wasted after {moves} moves" for moves in PRACTICE)]
    print_table(heads, *([starts, *(cell(wasted[starts, moves], 1) for moves in PRACTICE)] for starts in STARTS))
    print_verdict(
        [
            saving(f"less than from {other}, {moves} moves", wasted[OUTWARDS, moves], wasted[other, moves])
            for other in (OWN, ANYWHERE)
            for moves in PRACTICE
        ]
    )
    if given.plot:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(6, 3.6), layout="constrained")
        axes = figure.subplots()
        for starts in STARTS:
            draw_line(axes, PRACTICE, np.column_stack([wasted[starts, moves] for moves in PRACTICE]), starts)
        axes.set(xlabel="moves of practice", ylabel="moves wasted per episode of the test", xscale="log")
        axes.set_xticks(PRACTICE, map(str, PRACTICE))
        axes.minorticks_off()
        axes.legend(title="practice begins", fontsize="small")
        figure.savefig(given.plot, dpi=120)


if __name__ == "__main__":
    main()
