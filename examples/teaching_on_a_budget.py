"""Teaching on a budget: when should a teacher spend its few pieces of advice? After Torrey & Taylor 2013.

Students learn a world by tabular Q-learning in a lifetime of episodes. Teachers may advise an action a limited number
of times in that lifetime, and differ in when they do. Prints a table and draws the learning curves:

    python examples/teaching_on_a_budget.py --seeds 100 --plot docs/teaching-on-a-budget.png
"""

import argparse
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.progress import track

import llf_teacher
from llf_teacher.gym.lifetime_statistics import FIELDS
from llf_teacher.studies.analysis.statistics import mean_band, mean_interval, paired_difference
from teachers.atoms import Utterance
from teachers.teacher import Teacher

MISTAKE = FIELDS.index("mistake")
STUDENT = "q_learning(trust=1.0, forget=False, optimism=0.0, alpha={alpha}, gamma={gamma}, epsilon=0.1)"


class Setting(NamedTuple):
    """One world and what is spent in it."""

    id: str
    episodes: int
    turns: int
    budget: int
    threshold: float
    """Of importance, in units of the oracle's values."""
    student: str
    world: Mapping[str, Any] = {}
    """Its options."""
    vary: Mapping[str, Any] = {}
    """Parameters of the student that are drawn for each lifetime."""


SETTINGS = (
    Setting("llf-gridworld-v0", 60, 60, 30, 2.0, STUDENT.format(alpha=0.5, gamma=0.95)),
    Setting("llf-bandits-BanditTenArmedGaussian-v0", 40, 10, 30, 0.0, STUDENT.format(alpha=0.1, gamma=0.0)),
)
TEACHERS = {
    "no advice": "silent",
    "random": "inconsistent(likelihood=0.1, consistency=1.0) | early(budget={budget})",
    "early": "early(budget={budget})",
    "importance": "importance(budget={budget}, threshold={threshold})",
    "mistake correcting": "mistake_correcting(budget={budget}, threshold={threshold})",
    "announced mistake": "oracle",
    "predictive": "predictive(budget={budget}, threshold={threshold})",
}


BESIDE = ("no advice", "random", "early")
"""Teachers beside which all are put."""


class Announced:
    """Mistake correcting as the paper has it: the student announces its action, and is corrected before it acts."""

    def __init__(self, teacher: Teacher, threshold: float) -> None:
        self._teacher, self._threshold = teacher, threshold

    def reset(self, rng: np.random.Generator) -> None:
        """Begin a lifetime."""
        self._teacher.reset(rng)

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Utterance:
        """Advise if the announced action is a mistake in an important state; the instruction is always given."""
        said = self._teacher.act(observation, info)
        important = self._teacher.oracle.importance(info["moment"].after) >= self._threshold
        advise = observation["lifetime"][MISTAKE] and important
        return Utterance.of([atom for atom in said.atoms if advise or atom.kind is None])


def lifetime(setting: Setting, teacher: str, seed: int) -> list[float]:
    """The student's regret in each episode of a lifetime, in the family's unit."""
    env = llf_teacher.TeacherEnv(
        setting.id,
        student=setting.student,
        speech="message",
        episodes=setting.episodes,
        max_turns=setting.turns,
        budget=setting.budget,
        cost=0.0,
        teacher_reward="student_progress",
        announce=True,
        **setting.world,
    )
    spec = TEACHERS[teacher].format(budget=setting.budget, threshold=setting.threshold)
    policy = env.family.make_teacher(env.session.world, spec, feedback_type="fp")
    if teacher == "announced mistake":
        policy = Announced(policy, setting.threshold)
    policy.reset(np.random.default_rng(seed))  # once: its budget is that of the lifetime
    observation, info = env.reset(seed=seed)
    regret = [0.0]
    done = False
    while not done:
        observation, reward, terminated, truncated, info = env.step(policy.act(observation, info))
        done = terminated or truncated
        regret[-1] -= reward
        if info["moment"].turn == 0 and not done:
            regret.append(0.0)
    return regret


def main() -> None:
    """Live all lifetimes; print the table; draw the plot."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=30)
    parser.add_argument("--episodes", type=int, help="in place of what the settings say, to try it out")
    parser.add_argument("--plot", help="file for the learning curves")
    arguments = parser.parse_args()
    curves: dict[str, dict[str, np.ndarray]] = {}
    with ProcessPoolExecutor() as pool:
        for given in SETTINGS:
            setting = given._replace(episodes=arguments.episodes or given.episodes)
            lives = curves[setting.id] = {}
            for teacher in track(TEACHERS, setting.id, console=Console(emoji=False, stderr=True)):
                seeds = range(arguments.seeds)
                lives[teacher] = np.array(
                    list(pool.map(lifetime, [setting] * len(seeds), [teacher] * len(seeds), seeds))
                )
            print(f"\n{setting.id}: {setting.episodes} episodes, {setting.budget} pieces of advice\n")
            compare({teacher: each.mean(axis=1) for teacher, each in lives.items()})
    if arguments.plot:
        draw(curves, arguments.plot)


def compare(areas: Mapping[str, np.ndarray]) -> None:
    """Print regret per episode, and how much less it is than with three others."""
    print("| teacher | regret per episode |", *(f"less than with {other} |" for other in BESIDE))
    print("|---|---|" + "---|" * len(BESIDE))
    for teacher, area in areas.items():
        cells = [mean_interval(area).text()]
        for other in BESIDE:
            gain = paired_difference(areas[other], area)
            cells.append("" if other == teacher else f"{gain.estimate.text()}, p = {gain.p:.4f}")
        print(f"| {teacher} | {' | '.join(cells)} |")


def draw(curves: dict[str, dict[str, np.ndarray]], path: str) -> None:
    """Mean regret per episode, with 95 % intervals over seeds."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 4), layout="constrained")
    for axes, (id, lives) in zip(figure.subplots(1, len(curves)), curves.items(), strict=True):
        for teacher, values in lives.items():
            blocks = values.reshape(len(values), -1, 5).mean(axis=2)  # of five episodes each
            band = mean_band(blocks)
            at = 5 * np.arange(len(band.mean)) + 3
            axes.plot(at, band.mean, label=teacher)
            axes.fill_between(at, band.low, band.high, alpha=0.15)
        axes.set(title=id, xlabel="episode", ylabel="regret per episode")
    axes.legend()
    figure.savefig(path, dpi=120)


if __name__ == "__main__":
    main()
