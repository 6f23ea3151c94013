"""Rules against advice in a town: which saves more, in the first of its worlds and over all? A question of ours.

The worlds of a town share a law: the look of a bandit's arms tells what they pay, or treasures lie in rooms of one
kind. `ruler` teaches in the first of sixteen worlds and says what holds in all of them; after that it is silent. The
other teacher advises actions, from the first world on, until it has used as many words. The student is
`reasoner(worlds=64, forget=False)`, which keeps the rules that it hears. A world has 12 turns, and a seed is a town.

Declared before: as many words of advice save more than rules in the first world, by a tenth of the regret without words
there; and rules save more over all sixteen, by a tenth of the regret without words over all; in both families.

    python examples/known_results/rules.py --plot docs/known-rules.png
"""

from typing import Any

import numpy as np
from _shared import TENTH, Effect, cell, draw_line, parsed, played, print_table, print_verdict

import llf_teacher
from teachers.atoms import Utterance

FAMILIES: dict[str, dict[str, Any]] = {
    "bandits": {"id": "llf-bandits-BanditTenArmedGaussian-v0"},
    "gridworld": {"id": "llf-gridworld-v0", "map": True},  # the plan of the house is in the instruction
}
SILENCE, RULES, ADVICE = TEACHERS = ("silence", "rules", "advice, as many words")
WORLDS, TURNS = 16, 12
AFTER = (1, 2, 4, 8, 16)
STUDENT = "reasoner(worlds=64, forget=False)"


class Frugal:
    """Gives advice until its words are used up; the instruction is always given."""

    words = 0
    """Words that are left."""

    def __init__(self, family: str) -> None:
        env = llf_teacher.make(**FAMILIES[family])
        self._teacher = env.family.make_teacher(env.session.world, "only(kinds='fp')")
        self.reset = self._teacher.reset

    def act(self, observation: Any, info: dict[str, Any]) -> Utterance:
        """The instruction, and advice while words are left."""
        said = self._teacher.act(observation, info)
        return said if self.words > 0 else Utterance.of([atom for atom in said.atoms if atom.kind is None])


class Town:
    """A student in the worlds of a town."""

    def __init__(self, family: str, seed: int) -> None:
        self.frugal = Frugal(family)
        teachers = {"silent": "silent", "ruler": "ruler", "frugal": self.frugal}
        self.envs = {
            name: llf_teacher.make(**FAMILIES[family], teacher=teacher, max_turns=TURNS, town=seed)
            for name, teacher in teachers.items()
        }
        self.student, self.seed = self.envs["silent"].seat(STUDENT), seed

    def lesson(self, world: int, teacher: str) -> tuple[float, int]:
        """The regret of a lesson, and the words of feedback in it."""
        env, student = self.envs[teacher], self.student
        student.reset(np.random.default_rng([self.seed, world]))
        observation, _ = env.reset(seed=WORLDS * self.seed + world)
        regret, words = 0.0, 0
        while True:
            spent = len(observation["feedback"].split())
            words += spent
            self.frugal.words -= spent
            if (values := env.values()) is None:
                break
            action = student.act(*env.seen_by(student))
            observation, *_ = env.step(action)
            regret += max(values) - values[action]
        student.finish(*env.seen_by(student), env.moment.success)
        return regret, words


def measure(family: str, teacher: str, seed: int) -> list[float]:
    """The regret after each number of worlds in `AFTER`."""
    town, says = Town(family, seed), {SILENCE: "silent", RULES: "ruler", ADVICE: "frugal"}[teacher]
    if teacher == ADVICE:
        town.frugal.words = Town(family, seed).lesson(0, "ruler")[1]
    lost = [town.lesson(world, "silent" if teacher == RULES and world else says)[0] for world in range(WORLDS)]
    return [sum(lost[:worlds]) for worlds in AFTER]


def main() -> None:
    """Teach in all towns, print the table and the verdict, draw the plot."""
    given = parsed(__doc__, seeds=16)
    found = played(measure, [(family, teacher) for family in FAMILIES for teacher in TEACHERS], given.seeds)
    heads = ["family", "teacher", *(f"regret after {worlds} world{'s' * (worlds > 1)}" for worlds in AFTER)]
    print_table(heads, *([*setting, *map(cell, values.T)] for setting, values in found.items()))
    effects = []
    for family in FAMILIES:
        silence, rules, advice = (found[family, teacher] for teacher in TEACHERS)
        first, last = TENTH * silence[:, 0], TENTH * silence[:, -1]
        effects.append(Effect(f"{family}: advice saves more in the first world", (rules - advice)[:, 0], first))
        effects.append(Effect(f"{family}: rules save more over all worlds", (advice - rules)[:, -1], last))
    print_verdict(effects)
    if given.plot:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(8, 3.4), layout="constrained")
        for axes, family in zip(figure.subplots(1, len(FAMILIES)), FAMILIES, strict=True):
            for teacher in TEACHERS:
                draw_line(axes, AFTER, found[family, teacher], teacher)
            axes.set(title=family, xlabel="worlds of the town", ylabel="regret so far")
            axes.set_xscale("log", base=2)
            axes.set_xticks(AFTER, map(str, AFTER))
        axes.legend(fontsize="small")
        figure.savefig(given.plot, dpi=120)


if __name__ == "__main__":
    main()
