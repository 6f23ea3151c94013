"""The pages of known results: a table of verdicts, and for each row a page with its protocol, rule, values and plot."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from llf_teacher.reproductions.row import FIRST_SEED, OURS, QUICK, Row, Values, describe, digest
from llf_teacher.reproductions.rule import NO, OPEN, YES, Judged, judge, verdict
from llf_teacher.studies.analysis.statistics import mean_interval, p_words

HEAD = """# Known results

Claims of papers about teaching, and questions of our own, tried with our worlds, teachers and students. The rule of a
row was written before its seeds were played: what is compared, in which direction, and the smallest effect that counts.
Each comparison is tested against that effect by a two-sided sign-flip test over seeds, with Holm's correction for all
comparisons of the row.

- **yes**: every effect is significantly greater than the smallest that counts;
- **no**: at least one is significantly smaller, so that the claim does not hold here as it is stated;
- **open**: neither; the seeds do not decide it.

A verdict is about our worlds and students, not about the paper's.
"""
FOOT = """
`llf reproduce` plays all rows and writes these pages; `llf reproduce --only NAME` plays one row and keeps the others;
`--quick` plays a few seeds of each as a trial, too few for any verdict but open. Measurements are stored as they end,
so that an interrupted run continues. Rows that train networks need the extra `learn`, and are left out without it.
"""
NOTE = """Intervals are 95 % intervals of means over seeds ([statistics](../statistics.md)); a star stands where none
would cover, since the values are skewed, mostly 0 or all equal."""


def write(rows: Mapping[str, Row], values: Mapping[str, Values], path: Path) -> None:
    """Write the page, and beside it a folder of its name with a page, a plot and the measurements of each row.

    Args:
        rows: by name.
        values: by the same names.
        path: the page, a Markdown file; it is replaced.
    """
    folder = path.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    heads = ("claim", "source", "verdict", "picture")
    papers, ours = [heads], [heads]
    for name, row in rows.items():
        plot(row, values[name], folder / f"{name}.png")
        (folder / f"{name}.json").write_text(raw(row, values[name]), encoding="utf-8")
        judged = judge(row.rule, values[name], row.measures)
        own = row_page(name, row, values[name], judged, path.name)
        (folder / f"{name}.md").write_text("\n".join(own) + "\n", encoding="utf-8")
        picture = f"![Plot]({folder.name}/{name}.png)"
        link = f"[{row.claim}]({folder.name}/{name}.md)"
        (ours if row.source == OURS else papers).append((link, row.source, f"**{verdict(judged)}**", picture))
    together = sum(values[name].seconds for name in rows)
    quick = sum(values[name].seconds * min(1, QUICK / values[name].seeds) for name in rows)
    cost = f"All of it takes {together / 120:.0f} minutes of 2 cores, {quick / 120:.1f} with `--quick`."
    own_questions = ["", "Questions of our own:", "", *table(ours)] if len(ours) > 1 else []
    lines = [HEAD, *table(papers), *own_questions, f"{FOOT}\n{cost}"]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def raw(row: Row, values: Values) -> str:
    """Measurements as JSON: one line per setting, with a list of its measures for each seed."""
    lines = []
    for setting in row.settings:
        table = [[float(f"{number:.10g}") for number in numbers] for numbers in values(**setting).tolist()]
        lines.append(json.dumps({"setting": setting, "values": table}))
    head = f'"measures": {json.dumps(list(row.measures))}, "first_seed": {FIRST_SEED}, "seconds": {values.seconds:.0f}'
    return "{" + head + ', "results": [\n' + ",\n".join(lines) + "\n]}\n"


def stored(row: Row, path: Path) -> Values | None:
    """Measurements that `raw` has written; None if they have other settings or measures.

    Args:
        row: that was measured.
        path: the file, which may be missing.
    """
    if not path.exists():
        return None
    kept = json.loads(path.read_text(encoding="utf-8"))
    tables = {digest(each["setting"]): np.array(each["values"]) for each in kept["results"]}
    if kept["measures"] != list(row.measures) or tables.keys() != {digest(each) for each in row.settings}:
        return None
    return Values(tables, kept["seconds"])


def row_page(name: str, row: Row, values: Values, judged: Sequence[Judged], index: str) -> list[str]:
    """The lines of the page of a row.

    Args:
        name: of the row.
        row: that was measured.
        values: its measurements.
        judged: the outcomes of its rule.
        index: the file of the page that lists all rows, in the folder above.
    """
    finding = row.read(values)
    cost = f"`llf reproduce --only {name}`, {values.seconds / 120:.1f} minutes of 2 cores"
    lines = [
        f"# {row.claim}",
        "",
        f"{row.source}; one of the [known results](../{index}). Played by {cost}.",
        "",
        f"**{verdict(judged).capitalize()}**: {counted(judged)}",
        "",
        f"![{row.claim}]({name}.png)",
        "",
        finding.ours,
        *(["", finding.why] if finding.why else []),
        "",
        "## What was played",
        "",
        row.protocol,
        "",
        "## The rule and its outcome",
        "",
        *table(rule_table(judged)),
        "",
    ]
    if finding.table:
        lines += ["## What was measured", "", *table(finding.table), ""]
    return [*lines, f"{NOTE} [Measurements]({name}.json) by seed: {', '.join(row.measures)}."]


def counted(judged: Sequence[Judged]) -> str:
    """How many comparisons have which verdict, in a sentence."""
    found, seeds = [each.verdict for each in judged], len(judged[0].effects)
    return (
        f"significantly greater than the smallest that counts: {found.count(YES)} of {len(judged)} expected effects; "
        f"significantly smaller: {found.count(NO)}; neither: {found.count(OPEN)} ({seeds} seeds)."
    )


def rule_table(judged: Sequence[Judged]) -> list[list[str]]:
    """The comparisons of a rule with their outcomes: heads, then a row each."""
    rows = [["expected", "measure", "smallest effect that counts", "effect seen", "p after Holm", "verdict"]]
    for each in judged:
        share = f" ({each.expectation.least:.0%})" if each.expectation.share_of is not None else ""
        p = p_words(each.p)
        seen = describe(mean_interval(each.effects))
        rows.append(
            [each.expectation.expects, each.expectation.measure, f"{each.least:.2f}{share}", seen, p, each.verdict]
        )
    return rows


def table(rows: Sequence[Sequence[str]]) -> list[str]:
    """A table in Markdown; the first row has the heads."""
    cells = [f"| {' | '.join(row)} |" for row in rows]
    return cells and [cells[0], "|---" * len(rows[0]) + "|", *cells[1:]]


def plot(row: Row, values: Values, path: Path) -> None:
    """Draw a row's plot in the style of reports: with colours and markers that differ in grey, dashed after six."""
    from cycler import cycler
    from matplotlib import style
    from matplotlib.figure import Figure

    from llf_teacher.studies.report.plots import MARKERS, SERIES, STYLE

    series = cycler(color=SERIES) + cycler(marker=list(MARKERS))
    looks = {"axes.prop_cycle": cycler(linestyle=["-", "--"]) * series, "text.parse_math": True}
    with style.context([STYLE, looks]):
        figure = Figure(figsize=(9, 4), layout="constrained")
        row.draw(values, figure)
        figure.savefig(path, dpi=80)
