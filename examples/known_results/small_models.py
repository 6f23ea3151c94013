"""Can small language models learn from what a teacher says? Three models, a treasure hunt and a ten-armed bandit.

Declared before the first of these seeds was played. The cells of `small_models.toml` are primary: three models, two
families, 20 seeds of 8 turns, and four teachers: silence, advice (fp), and two controls with as many words, a placebo
(truisms in place of the advice) and misaligned advice (true advice of another world).

A model's score of a seed against a control is the mean over both families of its regret with the control less that with
advice, each divided by the mean regret of the `random` student in the family. The score must be above 0.1: a tenth of
what random actions lose is the smallest effect that counts. Nine effects, three models with three controls, are tested
by two-sided sign-flip tests over seeds, with Holm's correction for all of them. A model learns from what it is told if
its three effects are found: advice must be better than silence, than words that say nothing, and than words that are
not about this world. Whether it learns to do without the teacher is another question.

Twenty seeds were fixed before a pilot of four others (`--pilot`), which decides nothing; it gave each effect a power of
1.00. The counts of what was done and said again, and of ways in houses, were chosen after the data.

The cells of `small_models_more.toml`, with two seeds or one, are exploratory: other kinds of words, words that are
always wrong, and three other families. No test is made of them.

    python examples/known_results/small_models.py --plot docs/small-models.png --rows docs/small-models.jsonl

plays what the stores lack, and goes on where it was interrupted; answers are kept beside the stores and asked only
once. `--from docs/small-models.jsonl` prints the same tables without a model.
"""

import argparse
import json
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from _shared import TENTH, Effect, cell, print_table, together, verdicts_of

from llf_teacher.registry import entry
from llf_teacher.studies import Results, Study, run
from llf_teacher.studies.analysis.power import ALPHA, power
from llf_teacher.studies.definition.study import load_study
from pz_envs.text.answer_formats import worded
from teachers.atoms import FP

FILES = (Path(__file__).with_suffix(".toml"), Path(__file__).with_name("small_models_more.toml"))
SEEDS, PILOT = 20, (2900, 2901, 2902, 2903)
ADVICE, RANDOM = "only(kinds='fp')", "random"
MISALIGNED = f"{ADVICE} | misaligned"
WAYS = ("north", "east", "south", "west")
TITLES = {"bandits": "ten-armed bandit", "gridworld": "treasure hunt"}
CONTROLS = {"silent": "silence", f"{ADVICE} | placebo": "a placebo", MISALIGNED: "misaligned advice"}
KEPT = (
    "id",
    "family",
    "teacher",
    "student",
    "seed",
    "turns",
    "regret",
    "parse_failures",
    "truncated",
    "advised",
    "followed",
    "seconds",
)
HABITS = ("again", "same_action", "same_thought")
"""Counts of an episode: turns after the first, and those with the action of the turn before, or an earlier thought."""
Rows = list[dict[str, Any]]
Cells = Mapping[tuple[str, str, str], np.ndarray]
"""Regrets by student, teacher and family, one a seed."""


def cells_of(rows: Rows) -> Cells:
    """The regrets of complete and incomplete cells, in the order of seeds."""
    found = defaultdict(list)
    for row in sorted(rows, key=lambda row: row["seed"]):
        found[row["student"], row["teacher"], row["family"]].append(row["regret"])
    return {key: np.array(each) for key, each in found.items()}


def is_model(student: str) -> bool:
    """Whether a student asks a model."""
    return student.startswith("llm(")


def effects_of(study: Study, cells: Cells) -> dict[str, list[Effect]]:
    """The declared effects of each model; none if one of its cells is incomplete."""
    families = sorted({family for _, _, family in cells})
    whole = {key for key, each in cells.items() if len(each) == len(study.seeds)}  # no seed is there twice
    effects: dict[str, list[Effect]] = {student: [] for student in study.students if is_model(student)}
    for student, mine in effects.items():
        needed = {(student, teacher, family) for teacher in (ADVICE, *CONTROLS) for family in families}
        if not needed <= whole:
            continue
        for control, name in CONTROLS.items():
            scores = [
                (cells[student, control, family] - cells[student, ADVICE, family])
                / cells[RANDOM, "silent", family].mean()
                for family in families
            ]
            seen = np.mean(scores, axis=0)
            mine.append(Effect(f"{study.named[student]}: advice against {name}", seen, np.full(len(seen), TENTH)))
    return effects


def print_regrets(study: Study, cells: Cells) -> None:
    """Print the mean regret of each cell, with its interval where the cell is complete."""
    families = sorted({family for _, _, family in cells})
    head = [f"{family}, {study.named[teacher]}" for family in families for teacher in study.teachers]
    keys = [(teacher, family) for family in families for teacher in study.teachers]
    rows = []
    for student in study.students:
        found = [cells.get((student, *key), np.array([])) for key in keys]
        rows.append([study.named[student], *(_regret(each, len(study.seeds)) for each in found)])
    print_table(["regret", *head], *rows)


def print_means(study: Study, cells: Cells) -> None:
    """Print the mean regret of each student and teacher in each family, however few the seeds."""
    families = sorted({family for _, _, family in cells})
    rows = [
        [study.named[student], study.named[teacher], *(_mean(cells.get((student, teacher, each))) for each in families)]
        for student in study.students
        for teacher in study.teachers
    ]
    print_table(["student", "teacher", *families], *rows)


def _mean(values: np.ndarray | None) -> str:
    return "-" if values is None else f"{values.mean():.2f}"


def _regret(values: np.ndarray, seeds: int) -> str:
    if len(values) == seeds:
        return cell(values)
    return f"{values.mean():.2f} ({len(values)} of {seeds} seeds)" if len(values) else "not played"


def print_power(effects: Mapping[str, list[Effect]]) -> None:
    """Print what a pilot says of the power of the test at the first and strictest step of Holm's method."""
    every = [each for mine in effects.values() for each in mine]
    rows = []
    for effect in every:
        excess = effect.seen - effect.least
        mean, spread = excess.mean(), max(excess.std(ddof=1), 1e-9)
        chance = power(SEEDS, mean, spread, ALPHA / len(every))
        rows.append([effect.expects, f"{effect.seen.mean():.2f}", f"{spread:.2f}", f"{chance:.2f}"])
    print_table(["effect", "seen", "standard deviation", f"power with {SEEDS} seeds"], *rows)


def print_answers(study: Study, rows: Rows) -> None:
    """Print how the models answered: no actions, cut answers, advice that was followed, what was done or said again."""
    lines = []
    for student in filter(is_model, study.students):
        for family in sorted({row["family"] for row in rows}):
            mine = [row for row in rows if (row["student"], row["family"]) == (student, family)]
            if not mine:
                continue
            total = {name: sum(row[name] or 0 for row in mine) for name in (*KEPT[5:], *HABITS)}
            followed = [_followed([row for row in mine if row["teacher"] == each]) for each in (ADVICE, MISALIGNED)]
            lines.append(
                [
                    study.named[student],
                    family,
                    f"{total['turns']}",
                    f"{total['parse_failures'] / total['turns']:.1%}",
                    f"{total['truncated'] / total['turns']:.1%}",
                    *followed,
                    *(f"{total[name] / max(1, total['again']):.0%}" for name in HABITS[1:]),
                    f"{total['seconds'] / total['turns']:.1f}",
                ]
            )
    counts = ["turns", "no action", "cut", "advice followed", "misaligned advice followed"]
    print_table(["model", "family", *counts, "same action", "same thought", "seconds a turn"], *lines)


def print_ways(study: Study, rows: Rows) -> None:
    """Print, for houses, how often the models went where they were advised to go: at first, and then by direction."""
    lines = []
    for student in filter(is_model, study.students):
        mine = [row for row in rows if row["student"] == student and row["family"] == "gridworld"]
        for teacher in (ADVICE, MISALIGNED):
            pairs = [pair for row in mine if row["teacher"] == teacher for pair in row["pairs"]]
            first = [done == way for turn, way, done in pairs if turn == 1]
            later = [[done == way for turn, way, done in pairs if turn > 1 and way == each] for each in WAYS]
            counts = (f"{sum(each)} of {len(each)}" for each in (first, *later))
            lines.append([study.named[student], study.named[teacher], *counts])
    print_table(["model, where advised to go", "teacher", "first turn", *(f"later {each}" for each in WAYS)], *lines)


def _followed(rows: Rows) -> str:
    advised = sum(row["advised"] or 0 for row in rows)
    return f"{sum(row['followed'] or 0 for row in rows) / advised:.0%}" if advised else "-"


def draw(study: Study, cells: Cells, path: Path) -> None:
    """Draw the mean regret of each student with each teacher, as a share of the random student's."""
    from matplotlib.figure import Figure

    families = sorted({family for _, _, family in cells})
    students = [student for student in study.students if student != RANDOM]
    figure = Figure(figsize=(8, 3.6), layout="constrained")
    colours = ("0.7", "#0b62a4", "#c9a227", "#b3541e")
    for axes, family in zip(figure.subplots(1, len(families), sharey=True), families, strict=True):
        unit = cells[RANDOM, "silent", family].mean()
        for number, (teacher, colour) in enumerate(zip(study.teachers, colours, strict=True)):
            shares = [cells.get((student, teacher, family), np.array([np.nan])) / unit for student in students]
            places = np.arange(len(students)) + (number - 1.5) / 5
            axes.bar(places, [each.mean() for each in shares], 0.2, color=colour, label=study.named[teacher])
            for place, each in zip(places, shares, strict=True):
                axes.plot(np.full(len(each), place), each, ".", color="0.2", markersize=2, alpha=0.4)
        axes.axhline(1, color="0.2", linewidth=0.8, linestyle=":")
        names = [study.named[student].replace("-", "-\n").replace(" ", "\n") for student in students]
        axes.set(xticks=range(len(students)), xticklabels=names, title=TITLES[family])
        axes.tick_params(labelsize=8)
        axes.spines[["top", "right"]].set_visible(False)
    figure.axes[0].set_ylabel("regret, 1: random actions")
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=4, frameon=False)
    figure.savefig(path, dpi=140)


def kept(study: Study, results: Results) -> Rows:
    """What the tables need of the rows of a study in its store."""
    own = {spec.key for spec in study.episodes()}
    rows = [row for row in results.rows() if row["key"] in own]
    worlds = {id: entry(id).family.make_world() for id in {row["id"] for row in rows}}
    return [{name: row[name] for name in KEPT} | habits(results.turns(row["key"]), worlds[row["id"]]) for row in rows]


def habits(turns: Rows, world: Any) -> dict[str, Any]:
    """The counts of `HABITS`, and `pairs`: of each turn with advice, in words, the advised action and the action."""
    actions, thoughts = ([turn[name] for turn in turns[1:]] for name in ("action_words", "thought"))
    advised = [[atom["action"] for atom in turn["atoms"] if atom["kind"] == FP] for turn in turns]
    return {
        "again": len(actions) - 1,
        "same_action": sum(now is not None and now == before for before, now in pairwise(actions)),
        "same_thought": sum(now is not None and now in thoughts[:place] for place, now in enumerate(thoughts)),
        "pairs": [
            [turn, worded(world, some[0]), done]
            for turn, (some, done) in enumerate(zip(advised, actions, strict=False), 1)
            if some and some[0] is not None
        ],
    }


def checked(path: Path, studies: list[Study]) -> list[Rows]:
    """The rows of a file, one list for each study.

    Raises:
        SystemExit: a row is none, is there twice, or belongs to no study.
    """
    parts: list[Rows] = [[] for _ in studies]
    seen = set()
    for number, line in enumerate(path.read_text("utf-8").splitlines(), 1):
        try:
            row = json.loads(line)
            key = row["student"], row["teacher"], row["family"], row["seed"]
            place = next(place for place, study in enumerate(studies) if row["seed"] in study.seeds)
            whole = np.isfinite(row["regret"]) and key not in seen and {*KEPT, *HABITS, "pairs"} <= {*row}
        except (ValueError, TypeError, KeyError, StopIteration):
            whole = False
        if not whole:
            raise SystemExit(
                f"{path}, line {number}: must be a row of an episode of these studies, as --rows writes it, once only "
                f"and with a finite regret, got {line:.80}"
            )
        seen.add(key)
        parts[place].append(row)
    if not seen:
        raise SystemExit(f"{path} must hold rows, as --rows writes them, and is empty")
    return parts


def main() -> None:
    """Play what the stores lack, print the tables and the verdict, draw the plot."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=Path(), help="folder of the stores; by default this one")
    parser.add_argument("--workers", type=int, default=2, help="episodes at once; by default 2")
    parser.add_argument("--pilot", action="store_true", help="play four other seeds, and print the power of twenty")
    parser.add_argument("--no-play", action="store_true", help="print what is there")
    parser.add_argument("--rows", type=Path, help="file to write the rows to")
    parser.add_argument("--from", dest="given", type=Path, help="file of rows, in place of stores")
    parser.add_argument("--plot", type=Path, help="file to draw to")
    given = parser.parse_args()
    studies = [load_study(file) for file in FILES]
    if given.pilot:
        pilot = replace(studies[0], seeds=PILOT)
        print_power(effects_of(pilot, cells_of(_played(pilot, given.folder / "small_models_pilot.db", given))))
        return
    if given.given:
        parts = checked(given.given, studies)
    else:
        parts = []
        for file, study in zip(FILES, studies, strict=True):
            store = given.folder / f"{file.stem}.db"
            parts.append(_played(study, store, given))
    if given.rows:
        given.rows.write_text("".join(f"{json.dumps(row)}\n" for rows in parts for row in rows))
    for number, (study, rows) in enumerate(zip(studies, parts, strict=True)):
        if not rows:
            continue
        cells = cells_of(rows)
        if number:
            print_means(study, cells)
            print_answers(study, rows)
            continue
        print_regrets(study, cells)
        print_answers(study, rows)
        print_ways(study, rows)
        effects = effects_of(study, cells)
        models = list(filter(is_model, study.students))
        found = verdicts_of([each for mine in effects.values() for each in mine], len(models) * len(CONTROLS))
        for student in models:
            mine, found = found[: len(effects[student])], found[len(effects[student]) :]
            verdict = together(mine) if mine else "not decided, its cells are not whole"
            print(f"{study.named[student]} learns from what it is told: {verdict}")
        print()
        if given.plot:
            draw(study, cells, given.plot)


def _played(study: Study, store: Path, given: argparse.Namespace) -> Rows:
    if given.no_play:
        if not store.exists():
            return []
        with Results(store) as results:
            return kept(study, results)

    def show(done: int, total: int) -> None:
        print(f"\r{store.name}: {done} of {total} episodes", end="", flush=True)

    with run(study, store, workers=given.workers, progress=show) as results:
        print()
        return kept(study, results)


if __name__ == "__main__":
    main()
