"""Measure small models in the teacher's seat: what they say, whether it is true, and what it is worth.

The aim: an `obedient` student taught by a model that is shown the oracle's claims (`llm_teacher(model=...)`) loses less
regret than in silence and than with a placebo, in each family and for each model; at least 90 % of the model's claims
are true; and no answer is cut.

The table, written down before the runs. Two models, each with the oracle's claims of the turn before it and, in
gridworld and bandits, with nothing but what the student sees (`knows='nothing'`). Four families: gridworld, ten-armed
bandits, ALFWorld and optimization. The kinds of feedback are all. Seeds 0 and on, six turns; all teachers have the same
lessons. A line for each model, knowledge and family has

- `claims`, those made, and by kind `said` and `true`: whether the simulator confirms them;
- of the turns in which the model answered, `advises`: turns with a claim of what to do or avoid next; `repeats`: turns
  whose answer only repeats what the student sees; `nothing`: turns without feedback; `cut`: answers cut at the limit;
- `unbuilt`, claims of an answer that cannot be made or checked;
- `regret`, the mean over the episodes, beside that in silence, with a placebo and with the oracle's own words;
- `seconds` and `output` tokens, the mean of an answer.

    python examples/model_teachers.py FOLDER local:smollm2-135m --seeds 3 --turns 6

writes one study for each model and knowledge into FOLDER, with the cache of answers, and the table's lines as JSON.
"""

import argparse
import json
import os
import re
from collections import Counter, defaultdict
from pathlib import Path
from typing import Any

import numpy as np

FAMILIES = (
    "llf-gridworld-v0",
    "llf-bandits-BanditTenArmedRandomFixed-v0",
    "llf-alfworld-v0",
    "llf-optimization-McCormick-v0",
)
BLIND = FAMILIES[:2]
"""Where the models are asked without the oracle's claims, too."""
OTHERS = ("silent", "placebo", "oracle")


def spec_of(model: str, knows: str, options: str = "") -> str:
    """The teacher."""
    return f"llm_teacher(model={model!r}{'' if knows == 'claims' else f', knows={knows!r}'}{options})"


def measure(folder: Path, model: str, knows: str, args: argparse.Namespace) -> list[dict[str, Any]]:
    """Play the lessons, unless they were played, and return their lines of the table."""
    from llf_teacher.studies import Study, run

    ids = args.ids or (FAMILIES if knows == "claims" else BLIND)
    study = Study(
        ids=ids,
        teachers=[spec_of(model, knows, args.options), *OTHERS],
        students=["obedient"],
        seeds=args.seeds,
        max_turns=args.turns,
    )
    name = re.sub(r"\W+", "-", f"{model}-{knows}{args.options}")
    results = run(study, folder / f"{name}.db", workers=args.workers)
    regrets: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    for row in results.rows():
        teacher = row["teacher"] if row["teacher"] in OTHERS else "model"
        regrets[row["id"]][teacher].append(row["regret"])
        if teacher == "model":
            counts[row["id"]].update(count(results.turns(row["key"])))
    return [line(model, knows, id, counts[id], regrets[id]) for id in ids]


def count(turns: list[dict[str, Any]]) -> Counter[str]:
    """What the model said in an episode, before the first action, too."""
    found: Counter[str] = Counter()
    for turn in turns:
        reply = turn["reply"]
        if reply is None:
            continue
        kinds = [atom["kind"] for atom in turn["atoms"] if atom["kind"]]
        found["answers"] += 1
        found["advises"] += bool({"fp", "fn"} & {*kinds})
        found["nothing"] += not turn["feedback"]
        found.update(reply["faults"])
        found["unbuilt"] += turn["unbuilt"] or 0
        found["tokens"] += (turn["paid"] or {}).get("output_tokens") or 0
        found["milliseconds"] += round(1000 * reply["seconds"])
        for atom in turn["atoms"]:
            if atom["kind"]:
                found[f"said {atom['kind']}"] += 1
                found[f"true {atom['kind']}"] += atom["label"] != "distorted"
    return found


def line(model: str, knows: str, id: str, found: Counter[str], regrets: dict[str, list[float]]) -> dict[str, Any]:
    """A line of the table."""
    answers = max(found["answers"], 1)
    kinds = [kind for kind in ("r", "hp", "hn", "fp", "fn") if found[f"said {kind}"]]
    return {
        "model": model,
        "knows": knows,
        "id": id,
        "claims": sum(found[f"said {kind}"] for kind in kinds),
        "kinds": {kind: [found[f"true {kind}"], found[f"said {kind}"]] for kind in kinds},
        **{name: found[name] for name in ("answers", "advises", "repeats", "nothing", "cut", "unbuilt")},
        "regret": {teacher: round(float(np.mean(values)), 3) for teacher, values in sorted(regrets.items())},
        "episodes": len(regrets["model"]),
        "seconds": round(found["milliseconds"] / answers / 1000, 2),
        "output": round(found["tokens"] / answers, 1),
    }


def main() -> None:
    """Measure each model and print the table as JSON lines."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("models", nargs="+")
    parser.add_argument("--ids", nargs="+")
    parser.add_argument("--knows", nargs="+", default=["claims", "nothing"])
    parser.add_argument("--options", default="", help="further parameters of the teacher, as in ', history=0'")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--turns", type=int, default=6)
    parser.add_argument("--workers", type=int, default=1)
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    os.environ.setdefault("LLF_LLM_CACHE", str(args.folder / "answers.db"))
    for model in args.models:
        for knows in args.knows:
            for each in measure(args.folder, model, knows, args):
                print(json.dumps(each), flush=True)
                with (args.folder / "table.jsonl").open("a") as file:
                    file.write(json.dumps(each) + "\n")


if __name__ == "__main__":
    main()
