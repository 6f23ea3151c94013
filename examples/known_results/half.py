"""A teacher that knows half: does it help if it says how sure it is, and less if it is too sure? A question of ours.

The teacher knows what a walk of 20 random actions through the same world shows, with all rewards. It says what its
oracle would say in most of the worlds that agree with the walk, and hedges what it is not certain of; an overconfident
teacher multiplies the log-odds of its hedges by five. The worlds are ten-armed bandits, and houses whose plan is in the
instruction; a lesson has 12 turns. All students are `reasoner(worlds=64)`: the first trusts, the second weighs
(`trust=0.8`), the third forgets.

Declared before: beside silence the calibrated teacher saves each of the three students a tenth of the regret, and
beside the overconfident teacher it saves the one that trusts a tenth; in both families.

    python examples/known_results/half.py --plot docs/known-half.png
"""

import tempfile
from pathlib import Path

import numpy as np
from _shared import FIRST_SEED, cell, draw_bars, parsed, print_table, print_verdict, saving

from llf_teacher.studies import Study, run

FAMILIES = {"bandits": "llf-bandits-BanditTenArmedRandomFixed-v0", "gridworld": "llf-gridworld-v0"}
HALF = "partial(sees='walk', steps=20)"
TEACHERS = {
    "silence": "silent",
    "calibrated": HALF,
    "overconfident": f"{HALF} | overconfident(by=5.0)",
    "knows all": "oracle",
}
STUDENTS = {
    "trusts": "reasoner(worlds=64)",
    "weighs": "reasoner(worlds=64, trust=0.8)",
    "forgets": "reasoner(worlds=64) | forgetful(half_life=3)",
}


def regrets(seeds: int) -> dict[tuple[str, str, str], np.ndarray]:
    """Regret by family, student and teacher, one value a seed."""
    study = Study(
        ids=list(FAMILIES.values()),
        teachers=list(TEACHERS.values()),
        students=list(STUDENTS.values()),
        seeds=range(FIRST_SEED, FIRST_SEED + seeds),
        max_turns=12,
        options={FAMILIES["gridworld"]: {"map": True}},
        baseline="silent",
        names={spec: name for named in (TEACHERS, STUDENTS) for name, spec in named.items()},
    )
    with tempfile.TemporaryDirectory() as folder, run(study, Path(folder) / "half.db") as results:
        rows = sorted(results.rows(), key=lambda row: row["seed"])
    return {
        (family, student, teacher): np.array(
            [
                row["regret"]
                for row in rows
                if (row["family"], row["student"], row["teacher"]) == (family, STUDENTS[student], TEACHERS[teacher])
            ]
        )
        for family in FAMILIES
        for student in STUDENTS
        for teacher in TEACHERS
    }


def main() -> None:
    """Play the study, print the table and the verdict, draw the plot."""
    given = parsed(__doc__, seeds=48)
    found = regrets(given.seeds)
    places = [(family, student) for family in FAMILIES for student in STUDENTS]
    rows = [[*place, *(cell(found[*place, teacher]) for teacher in TEACHERS)] for place in places]
    print_table(["family", "student", *(f"regret, {teacher}" for teacher in TEACHERS)], *rows)
    effects = [
        saving(
            f"{family}: the calibrated teacher saves a student that {student} a tenth beside silence",
            found[family, student, "calibrated"],
            found[family, student, "silence"],
        )
        for family, student in places
    ]
    effects += [
        saving(
            f"{family}: the calibrated teacher saves a student that trusts a tenth beside the overconfident one",
            found[family, "trusts", "calibrated"],
            found[family, "trusts", "overconfident"],
        )
        for family in FAMILIES
    ]
    print_verdict(effects)
    if given.plot:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(8, 3.6), layout="constrained")
        panels = figure.subplots(1, len(FAMILIES))
        for axes, family in zip(panels, FAMILIES, strict=True):
            series = {each: [found[family, student, each] for student in STUDENTS] for each in TEACHERS}
            draw_bars(axes, list(STUDENTS), series)
            axes.set(title=family, ylabel="regret")
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
        figure.savefig(given.plot, dpi=120)


if __name__ == "__main__":
    main()
