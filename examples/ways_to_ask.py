"""Compare ways to ask a small model for an action: how often it answers with one, copies the prompt, and learns.

The aim: in gridworld and bandits at least 99 % of the answers are actions, none copies the prompt, and the regret with
advice (fp) is at most a tenth of the regret in silence.

The rule of choice, written down before the runs. The ways are the folders beside this file, with a thought of at most
200 characters before the action, and without a thought where the name ends with `-`. Two models choose,
SmolLM2-135M-Instruct and Qwen2.5-Coder-0.5B-Instruct; a third model, which no choice saw, confirms.

1. A way that fails 99 % actions or has copies, on either model in gridworld or bandits, is out; if all are out, the
   ways with the fewest such answers remain.
2. Of these the way with the least sum over models and families of (regret with advice) / (regret in silence) is chosen;
   a ratio is at most 1.5 in the sum, and 1 where the regret in silence is 0.
3. Within 0.1 of the least sum, the way with the fewest words is chosen, and of equal ones the one that says least of
   what to make of the teacher: `why`, `says`, `advises`.

An answer copies if it shares five successive words with the prompt around the task: the system message and the question
without instruction, feedback and observation, with the example if there is one.

    python examples/ways_to_ask.py FOLDER local:smollm2-135m --ways why why- says advises --seeds 3 --turns 6

writes one study for each way into FOLDER, with the cache of answers, and a line of the table for each environment.
"""

import argparse
import json
import os
import re
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

WAYS = Path(__file__).with_suffix("")
FEW = ("llf-gridworld-v0", "llf-bandits-BanditTenArmedRandomFixed-v0")
RUN = 5
"""Successive words of the prompt that make an answer a copy."""


def spec_of(model: str, way: str, form: str) -> str:
    """The student; `shipped-text` and `shipped-json` are the prompts of the package with that form of answer."""
    if way.startswith("shipped-"):
        return f"llm(model={model!r}, history=4, max_tokens=120, answer={way.removeprefix('shipped-')!r})"
    thought = ", thought=0" if way.endswith("-") else ""
    prompts = "" if way.rstrip("-") == "default" else f", prompts={str(WAYS / way.rstrip('-'))!r}"
    return f"llm(model={model!r}, history=4, answer={form!r}{prompts}{thought})"


def runs(text: str) -> set[tuple[str, ...]]:
    """All successive words of a text, five at a time."""
    words = re.findall(r"\w+", text.lower())
    return {tuple(words[at : at + RUN]) for at in range(len(words) - RUN + 1)}


def form_of(student: Any, id: str) -> set[tuple[str, ...]]:
    """The words around the task in the first question to a student."""
    from llf_teacher.registry import entry

    world = entry(id).family.make_world()
    spoken = student.conversation(world, np.random.default_rng(0))
    messages = spoken.ask({"instruction": " ", "feedback": "", "observation": ""}, 5)
    return runs(" ".join(f"{message['content']}" for message in messages))


def measure(folder: Path, model: str, way: str, args: argparse.Namespace) -> list[dict[str, Any]]:
    """Play a way, unless it was played, and return its lines of the table."""
    from llf_teacher.students.parsing import parse_student
    from llf_teacher.studies import Study, run

    spec = spec_of(model, way, args.form)
    name = re.sub(r"\W+", "-", f"{model}-{way}{'b' if way.endswith('-') else ''}-{args.form}")
    study = Study(
        ids=args.ids,
        teachers=args.teachers,
        students=[spec],
        feedback_types=args.types,
        seeds=args.seeds,
        max_turns=args.turns,
    )
    store = run(study, folder / f"{name}.db", workers=args.workers)
    student = parse_student(spec)
    found: dict[str, dict[str, Any]] = {}
    regrets: dict[tuple[str, str], list[float]] = defaultdict(list)
    for row in store.rows():
        line = found.setdefault(row["id"], {"answers": 0, "actions": 0, "copies": 0, "cut": 0, "seconds": 0.0})
        form = form_of(student, row["id"])
        regrets[row["id"], row["teacher"]].append(row["regret"])
        for turn in store.turns(row["key"]):
            if turn["answer"] is None:
                continue
            line["answers"] += 1
            line["actions"] += turn["parse_failure"] is None
            said = runs(f"{turn['thought'] or ''}\n{turn['answer']}")
            line["copies"] += not said.isdisjoint(form)
            line["cut"] += turn["finish"] == "length"
            line["seconds"] += turn["seconds"] or 0.0
    for (id, teacher), values in regrets.items():
        found[id][f"regret {teacher}"] = round(float(np.mean(values)), 3)
    return [{"model": model, "way": way, "id": id, **line} for id, line in found.items()]


def main() -> None:
    """Measure each way and print the table as JSON lines."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("model")
    parser.add_argument("--ways", nargs="+", default=["why", "why-", "says", "advises"])
    parser.add_argument("--ids", nargs="+", default=list(FEW))
    parser.add_argument("--teachers", nargs="+", default=["oracle", "silent"])
    parser.add_argument("--types", nargs="+", default=["fp"])
    parser.add_argument("--form", default="json")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--turns", type=int, default=6)
    parser.add_argument("--workers", type=int, default=2)
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    os.environ.setdefault("LLF_LLM_CACHE", str(args.folder / "answers.db"))
    for way in args.ways:
        for line in measure(args.folder, args.model, way, args):
            print(json.dumps(line), flush=True)
            with (args.folder / "table.jsonl").open("a") as file:
                file.write(json.dumps(line) + "\n")


if __name__ == "__main__":
    main()
