"""How many bits should the next claim say? A teacher that learned it, beside teachers that always say as many.

A student that reasons looks for a treasure in a house whose map it has. A teacher has one bit for the lesson. Its
action is a level, silence or a number of bits; then the claim is said that is nearest to it, as `informative` says it,
among those for which there are bits left. The learned teacher weighs what it sees, and takes the level of the greatest
sum; CMA-ES (Hansen 2016) finds the weights, beginning with the best constant level. The rule of the verdict is that of
`beside_a_rule.py`. Needs the extra `learn`, of it `cma` alone:

    python examples/choose_bits.py --store docs/choose-bits.json
"""

import argparse
import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from _teacher_seats import TRIAL
from beside_a_rule import FINAL, LIFETIMES, judge

import llf_teacher
from llf_teacher.studies.analysis.statistics import mean_interval
from teachers.oracle import POSTERIOR
from teachers.personality import Claims, Personality, Stage, View

try:
    import cma
except ModuleNotFoundError as error:
    raise SystemExit(f'{error}; install it by: pip install -e ".[learn]" -c constraints-learn.txt') from None

LEVELS = (0.0, 0.25, 0.5, 1.0)
"""Bits; 0: silence."""
WORLDS, TURNS = 32, 40
"""By which bits are measured and the student reasons, and turns of a lesson."""
BUDGET = 1.0
"""Bits for a lesson."""
NUMBERS = 5
"""A constant, share of the turns, share of the budget left, bits of the claim that says most, importance."""
FIRST = 70_000_000
"""First seed of the lessons to learn from."""
LEAST = 0.05  # bits
BEST, LEARNED = "best constant level", "learned"
CANDIDATES, LESSONS, SPREAD, TRIALS = 10, 20, 0.5, 100


class _Turn(Stage["Levels"]):
    def begin(self) -> None:
        self.left = BUDGET

    def speak(self, claims: Claims, view: View) -> Claims:
        if view.moment.over or self.left < LEAST:
            return ()
        offers = [(found.bits, claim) for claim, found in view.weigh_all(claims, WORLDS) if found.bits]
        most = max((bits for bits, _ in offers), default=0.0)
        numbers = 1.0, view.turn / TURNS, self.left / BUDGET, most / 5, view.importance()
        level = LEVELS[int(np.argmax(np.reshape(self.spec.weights, (len(LEVELS), NUMBERS)) @ numbers))]
        offers = [(bits, claim) for bits, claim in offers if bits <= self.left + LEAST]
        if not level or not offers:
            return ()
        bits, said = min(offers, key=lambda each: abs(each[0] - level))
        self.left -= bits
        return (said,)


@dataclass(frozen=True)
class Levels(Personality):
    """Says the claim that is nearest to a level, which is that of the greatest weighted sum of what it sees."""

    weights: tuple[float, ...] = ()
    """Of each level in turn those of the numbers."""
    stage = _Turn

    @property
    def needs(self) -> frozenset[str]:
        """What it asks the oracle for."""
        return frozenset((POSTERIOR, "importance", "clues"))


def always(level: float) -> np.ndarray:
    """The weights with which it always says so many bits, as long as there are any left."""
    weights = np.zeros((len(LEVELS), NUMBERS))
    weights[LEVELS.index(level), 0] = 1
    return weights.ravel()


def taught(weights: np.ndarray, seeds: Iterable[int]) -> np.ndarray:
    """The student's regret in each lesson, in moves."""
    env = llf_teacher.make(
        "llf-gridworld-v0",
        teacher=Levels(tuple(weights.tolist())),
        until_success=True,
        max_turns=TURNS,
        options={"map": True},
    )
    student, regrets = env.seat(f"reasoner(worlds={WORLDS})"), []
    for seed in seeds:
        env.reset(seed=seed)
        student.reset(np.random.default_rng(seed))
        regrets.append(0.0)
        while (values := env.values()) is not None:
            action = student.act(*env.seen_by(student))
            regrets[-1] += max(values) - values[action]
            env.step(action)
    return np.array(regrets)


def learn(weights: np.ndarray, generations: int, seed: int = 0) -> np.ndarray:
    """Better weights than these."""
    search = cma.CMAEvolutionStrategy(weights, SPREAD, {"popsize": CANDIDATES, "verbose": -9, "seed": seed + 1})
    for generation in range(generations):
        first = FIRST + (seed * 1000 + generation) * LESSONS
        drawn = search.ask()
        search.tell(drawn, [taught(each, range(first, first + LESSONS)).mean() for each in drawn])
    return np.round(search.mean, 2)


def main() -> None:
    """Learn, compare and print; what was compared is kept."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--generations", type=int, default=6)
    parser.add_argument("--lessons", type=int, default=LIFETIMES, help="to compare on")
    parser.add_argument("--store", type=Path, required=True, help="JSON file of what was compared")
    arguments = parser.parse_args()
    if not arguments.store.exists():
        trials = range(TRIAL, TRIAL + min(TRIALS, arguments.lessons))
        tried = {level: float(taught(always(level), trials).mean()) for level in LEVELS[1:]}
        best = min(tried, key=tried.__getitem__)
        learned = learn(always(best), arguments.generations)
        final = range(FINAL, FINAL + arguments.lessons)
        regrets = {
            name: taught(each, final).round(2).tolist() for name, each in ((BEST, always(best)), (LEARNED, learned))
        }
        found = {"trial": tried, "best": best, "weights": learned.tolist(), **regrets}
        arguments.store.write_text(json.dumps(found) + "\n", encoding="utf-8")
    found = json.loads(arguments.store.read_text(encoding="utf-8"))
    tried = ", ".join(f"{regret:.2f} with {level} bits" for level, regret in found["trial"].items())
    print(f"Regret in a lesson on trial by constant level: {tried}\n")
    best, learned = np.array(found[BEST]), np.array(found[LEARNED])
    ((gain, p, verdict),) = judge([best - learned])
    print(f"| {BEST} | {LEARNED} | less with the learned one | p | verdict |\n|---|---|---|---|---|")
    cells = [f"{mean_interval(best).text()} ({found['best']:g} bits)", mean_interval(learned).text()]
    print(f"| {' | '.join([*cells, gain.estimate.text(), f'{p:.4f}', verdict])} |")


if __name__ == "__main__":
    main()
