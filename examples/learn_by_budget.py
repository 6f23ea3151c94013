"""A teacher that learned, at several budgets: trainings of `learn_to_teach.py`, beside rules with the same information.

Each training ends on a line of a file, which a second run goes on with. Prints tables of what the file has. Needs the
extra `learn`:

    python examples/learn_by_budget.py --trainings 3 --store docs/learn-to-teach.jsonl
    python examples/learn_by_budget.py --trainings 3 --store docs/learn-to-teach.jsonl --budgets 8 --without way
"""

import argparse
import json
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from _teacher_seats import SETTING, TRIAL, Policy, accompanied, near_mistakes
from learn_to_teach import learner, policy_of, torch, train  # says what to install if torch is missing
from teaching_on_a_budget import Setting

from llf_teacher.gym.lifetime_statistics import FIELDS
from llf_teacher.studies.analysis.statistics import mean_interval, paired_difference

BUDGETS = (2, 4, 8, 16, 32)
FRESH = 3_000_000
"""First seed of the lifetimes that all are compared on; nothing was chosen on them."""
ROWS = 256
WITHIN = tuple(range(1, 9))
"""Moves to the treasure within which a rule may correct mistakes; on other lifetimes the best is chosen."""
ALL, NEAR, LEARNED, LAST = "announced mistake", "near mistakes", "learned", "last iterate"
Line = dict[str, Any]
"""What a training or the rules came to."""


def trained(setting: Setting, seed: int, without: Sequence[str], steps: int, lifetimes: int) -> Line:
    """A training, and the regret of each lifetime with the best of its stages and with the last one."""
    model, blank = learner(seed), [5 + FIELDS.index(name) for name in without]
    began = time.process_time()
    stages = train(model, setting, steps, seed, ROWS, blank)
    spent = time.process_time() - began
    acts = policy_of(model, without=blank)
    best = min(stages, key=lambda stage: stage.regret)
    line = {"budget": setting.budget, "seed": seed, "without": list(without), "seconds": round(spent)}
    line |= {"decisions": best.decisions, LEARNED: lived(acts, setting, lifetimes)}
    model.policy.load_state_dict(stages[-1].weights)
    return line | {LAST: lived(acts, setting, lifetimes)}


def ruled(setting: Setting, lifetimes: int) -> Line:
    """The rules that see what the learned teacher sees."""
    trial = range(TRIAL, TRIAL + lifetimes)
    moves = min(WITHIN, key=lambda each: accompanied(near_mistakes(moves=each), setting, trial).mean())
    rules = {ALL: near_mistakes(others=1.0), NEAR: near_mistakes(moves=moves)}
    return {"budget": setting.budget, "moves": moves} | {
        name: lived(rule, setting, lifetimes) for name, rule in rules.items()
    }


def lived(policy: Policy, setting: Setting, lifetimes: int) -> list[float]:
    """The student's regret per episode in each of the lifetimes."""
    regrets = accompanied(policy, setting, range(FRESH, FRESH + lifetimes))
    return [round(float(regret), 2) for regret in regrets]


def read(path: Path) -> list[Line]:
    """What there is."""
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()] if path.exists() else []


def table(lines: Iterable[Line]) -> list[str]:
    """Regret per episode by budget, with intervals over lifetimes, of the mean of all trainings."""
    lines = list(lines)
    rows = ["| budget | teacher | regret per episode | less than announced mistake | than near mistakes | trainings |"]
    rows.append("|---|---|---|---|---|---|")
    for rules in sorted((line for line in lines if ALL in line), key=lambda line: line["budget"]):
        budget, found = rules["budget"], {ALL: [rules[ALL]], f"{NEAR} (within {rules['moves']})": [rules[NEAR]]}
        for line in lines:
            if line["budget"] == budget and LEARNED in line:
                blind = f", without {', '.join(line['without'])}" if line["without"] else ""
                for name in (LEARNED, LAST):
                    found.setdefault(name + blind, []).append(line[name])
        for name, lives in found.items():
            mean = np.mean(lives, axis=0)
            gains = [paired_difference(rules[rule], mean).estimate for rule in (ALL, NEAR)]
            cells = [each.text() for each in (mean_interval(mean), *gains)]
            single = ", ".join(f"{np.mean(each):.2f}" for each in lives) if name.startswith((LEARNED, LAST)) else ""
            rows.append(f"| {budget} | {name} | {' | '.join(cells)} | {single} |")
    return rows


def main() -> None:
    """Train what the file lacks; print what it has."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--budgets", type=int, nargs="+", default=BUDGETS)
    parser.add_argument("--trainings", type=int, default=3, help="of each budget")
    parser.add_argument("--without", nargs="*", default=(), choices=FIELDS, help="numbers that the teacher cannot see")
    parser.add_argument("--steps", type=int, default=800_000, help="decisions to learn from")
    parser.add_argument("--lifetimes", type=int, default=200, help="to compare on")
    parser.add_argument("--store", type=Path, required=True, help="file of JSON lines")
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    for seed in range(arguments.trainings):
        for budget in arguments.budgets:
            setting, there = SETTING._replace(budget=budget), read(arguments.store)
            lines = []
            if not any(ALL in line and line["budget"] == budget for line in there):
                lines.append(ruled(setting, arguments.lifetimes))
            wanted = (budget, seed, list(arguments.without))
            if wanted not in [(line["budget"], line.get("seed"), line.get("without")) for line in there]:
                lines.append(trained(setting, seed, arguments.without, arguments.steps, arguments.lifetimes))
            with arguments.store.open("a", encoding="utf-8") as file:
                file.writelines(f"{json.dumps(line)}\n" for line in lines)
    print("\n".join(table(read(arguments.store))))


if __name__ == "__main__":
    main()
