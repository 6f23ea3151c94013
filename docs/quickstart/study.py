# ---
# jupytext:
#   text_representation:
#     format_name: percent
# ---

# %% [markdown]
# # A study, to pandas and a figure
#
# What costs a student more: advice that comes two turns late, or advice that is wrong in three cases of ten? Both
# teachers teach the same student in the same worlds, and what the student wastes is counted.
#
# This file is a notebook and a program: open it in VS Code or Jupyter, or run `python docs/quickstart/study.py`. It takes a
# quarter of a minute. You need README's first command with one extra:
# `pip install -e ".[all,notebook]" -c constraints.txt`.

# %%
import os
import tempfile
from pathlib import Path

from llf_teacher.studies import Study, run

SEEDS = int(os.environ.get("LLF_QUICKSTART_SEEDS", "20"))  # the tests play fewer

study = Study(
    ids=["llf-gridworld-v0", "llf-bandits-BanditTenArmedRandomFixed-v0"],
    teachers=["oracle", "mistake(eps=0.3)", "delayed(turns=2)", "silent"],
    students=["text_only"],  # it reads the words, and believes them
    seeds=SEEDS,
)
results = run(study, Path(tempfile.mkdtemp()) / "study.db", workers=1)
print(results)

# %% [markdown]
# Each teacher is a name with parameters. `oracle` says all that is true; `mistake(eps=0.3)` replaces three claims of ten by
# plausible false ones; `delayed(turns=2)` says everything two turns later; `silent` says nothing. A *seed* is a world: all
# four teachers teach in the same twenty houses and at the same twenty bandits.
#
# ## The table
#
# `episodes` is a data frame with a row an episode. `regret` is what the student lost beside the best it could have done:
# wasted moves in the gridworld, lost expected reward in the bandits.

# %%
episodes = results.episodes
table = episodes.pivot_table(
    index="teacher", columns="family", values=["regret", "success"]
).round(2)
print(table)

# %% [markdown]
# The table also has how many claims were true, late or wrong (`distorted`): every claim was checked as it was said.

# %%
claims = episodes.groupby("teacher")[["claims", "truthful", "late", "distorted"]].sum()
print(claims)

# %% [markdown]
# ## The figure
#
# The same seed is the same world, so differences are paired by seed. `paired_difference` gives the mean with its 95 %
# interval, or says why there is none that would cover.

# %%
import matplotlib.pyplot as plt

from llf_teacher.studies.analysis.statistics import paired_difference

regret = episodes.set_index(["family", "teacher", "seed"]).regret.sort_index()
figure, axes = plt.subplots(1, 2, figsize=(9, 2.2), sharey=True, layout="constrained")
units = {"gridworld": "moves", "bandits": "expected reward"}
for axis, (family, unit) in zip(axes, units.items(), strict=True):
    for teacher in ("delayed(turns=2)", "mistake(eps=0.3)", "oracle"):
        silent, taught = regret[family, "silent"], regret[family, teacher]
        saved = paired_difference(silent, taught).estimate
        print(f"{family:10} {teacher:17} saves {saved.text(1)} {unit}")
        if not saved.why:
            axis.plot([saved.low, saved.high], [teacher, teacher], color="tab:blue")
        axis.plot(saved.mean, teacher, "o", color="tab:blue")
    axis.set(title=family, xlabel=f"{unit} saved against silence, an episode")
    axis.set(xlim=(0, None), ylim=(-0.5, 2.5))
file = Path("quickstart-study.png").resolve()
figure.savefig(file, dpi=150)
print(f"Figure: {file}")
plt.show()

# %% [markdown]
# ## The report
#
# `results.report()` shows the whole report in a notebook: findings with a test that was declared before, tables with
# intervals, and transcripts in which each sentence is marked true or false. Here it goes to a file, beside the figure.

# %%
report = Path("quickstart-study.html").resolve()
report.write_text(results.report().html, encoding="utf-8")
print(f"Report: {report}")

# %% [markdown]
# The same study as a file for the command line is ten lines of TOML: see [A study](../studies.md).
# Next: [a teacher that learns](learning.py), [an agent that is taught](agent.py).
