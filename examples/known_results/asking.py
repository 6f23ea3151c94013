"""Who should take the initiative: a teacher that always looks, or a student that asks? After Amir et al. 2016.

The paper: advice that both initiate gains nearly as much as a teacher that looks in every turn, with less attention.
Its students play Pac-Man. Here they learn a house of 20 rooms by Q-learning, in 40 episodes of at most 40 moves from
the same room; they announce what they mean to do, and take the advised move. A teacher has 20 pieces of advice, and
looks while it has any left: in every turn, or where the student asks.

Declared before: a teacher that looks where an unsure student asks, and corrects important mistakes, looks in at least a
tenth fewer turns than one that always looks; and its students waste more by at most a tenth of what students without
advice waste.

    python examples/known_results/asking.py --plot docs/known-asking.png
"""

from collections import Counter
from collections.abc import Callable
from typing import Any

from _shared import TENTH, Effect, cell, parsed, played, print_table, print_verdict

import llf_teacher
from llf_teacher.gym.lifetime_statistics import FIELDS

STUDENT = "q_learning(trust=1.0, forget=False, optimism=0.0, epsilon=0.1)"
EPISODES, TURNS, BUDGET = 40, 40, 20
CONFIDENT, KNOWN, GREATEST = 0.1, 5, 2.0
"""Difference of learned values from which a student is sure; visits after which a room is familiar; most moves that a
door can waste. The first two were chosen on other seeds."""
ADVICE, MISTAKE = 0b01000, FIELDS.index("mistake")
ASKS: dict[str, Callable[[list[float], int], bool] | None] = {
    "the teacher looks always": None,
    "asks where unsure": lambda values, _: max(values) - min(values) < CONFIDENT,
    "asks where it was seldom": lambda _, visits: visits < KNOWN,
    "asks where much is at stake": lambda values, _: max(values) - min(values) >= CONFIDENT,
}
"""Whether a student asks, by the learned values of its actions and earlier visits of the room."""
ANSWERS: dict[str, Callable[[float, bool], bool]] = {
    "always": lambda *_: True,
    "important states": lambda importance, _: importance >= GREATEST,
    "important mistakes": lambda importance, mistake: mistake and importance >= GREATEST,
    "never": lambda *_: False,
}
"""Whether a teacher that looks advises, by the moves at stake and whether a wrong one was announced."""
ALONE, WATCHED = ("the teacher looks always", "never"), ("the teacher looks always", "important mistakes")
JOINT = ("asks where unsure", "important mistakes")
SETTINGS = [(asks, answers) for asks in ASKS for answers in ANSWERS if answers != "never" or (asks, answers) == ALONE]


class Asker:
    """Learns Q-values, takes advice, and asks for it, at most once a turn."""

    reads = "atoms and reward"

    def __init__(self, learner: Any, asks: Callable[[list[float], int], bool] | None) -> None:
        self._learner, self._asks, self._question = learner, asks, learner.action_count
        self._visits = Counter[int]()
        self.reset, self.finish = learner.reset, learner.finish
        self.intend = learner.intend
        self._asked = False

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> int:
        """Ask, or act like the learner."""
        self._learner.intend(observation, info)  # learns from the last turn
        room = str(observation["state"])
        if not self._asked and self._asks and self._asks(self._learner.worth(), self._visits[room]):
            self._asked = True
            return self._question
        self._asked = False
        self._visits[room] += 1
        return self._learner.act(observation, info)


def measure(asks: str, answers: str, seed: int) -> tuple[float, float, float]:
    """Moves wasted per episode, turns in which the teacher looked, and pieces of advice."""
    env = llf_teacher.TeacherEnv(
        "llf-gridworld-v0",
        student=lambda _: Asker(env.seat(STUDENT), ASKS[asks]),
        episodes=EPISODES,
        max_turns=TURNS,
        feedback_type="fp",
        budget=BUDGET,
        cost=0.0,
        ask_cost=0.0,
        announce=True,
        teacher_reward="student_progress",
    )
    observation, _ = env.reset(seed=seed)
    wasted, looked, said, done = 0.0, 0, 0, False
    while not done:
        importance, left, over = observation["features"][2:5].tolist()
        looks = left > 0 and not over and (ASKS[asks] is None or bool(observation["asked"][0]))
        speaks = looks and ANSWERS[answers](importance, bool(observation["lifetime"][MISTAKE]))
        speaks = speaks and bool(observation["action_mask"][ADVICE])
        observation, reward, terminated, truncated, _ = env.step(ADVICE if speaks else 0)
        wasted, looked, said, done = wasted - reward, looked + looks, said + speaks, terminated or truncated
    return wasted / EPISODES, looked, said


def main() -> None:
    """Teach all students, print the table and the verdict, draw the plot."""
    given = parsed(__doc__, seeds=75)
    found = played(measure, SETTINGS, given.seeds)
    heads = ["the student", "the teacher advises", "moves wasted per episode", "turns it looked", "pieces of advice"]
    print_table(heads, *([*setting, *map(cell, values.T)] for setting, values in found.items()))
    alone, watched, joint = (found[setting].T for setting in (ALONE, WATCHED, JOINT))
    print_verdict(
        [
            Effect("a teacher that looks only when asked looks less", watched[1] - joint[1], TENTH * watched[1]),
            Effect("its students waste hardly more", watched[0] - joint[0], -TENTH * alone[0]),
        ]
    )
    if given.plot:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(7, 3.6), layout="constrained")
        axes = figure.subplots()
        markers = dict(zip(ANSWERS, "os^", strict=False))
        for number, asks in enumerate(ASKS):
            means = [(marker, found[asks, answers].mean(axis=0)) for answers, marker in markers.items()]
            axes.plot([mean[1] for _, mean in means], [mean[0] for _, mean in means], color=f"C{number}", label=asks)
            for marker, mean in means:
                axes.plot(mean[1], mean[0], color=f"C{number}", marker=marker)
        for answers, marker in markers.items():
            axes.plot([], [], color="gray", linestyle="", marker=marker, label=f"advises {answers}")
        axes.axhline(alone[0].mean(), color="gray", linestyle="--", label="no advice")
        axes.set(xlabel="turns in which the teacher looked", ylabel="moves wasted per episode", ylim=(0, None))
        figure.legend(loc="outside right center", fontsize="small")
        figure.savefig(given.plot, dpi=120)


if __name__ == "__main__":
    main()
