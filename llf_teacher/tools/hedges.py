"""How often hedged claims hold, beside the probability with which they are said: a table and a picture."""

from collections.abc import Mapping

from llf_teacher.registry import PREFIX
from llf_teacher.tools.audit import audit
from llf_teacher.tools.markdown import table
from pz_envs.family import Family
from teachers.reliability import Reliability

__all__ = ["measured", "plot", "table_of"]


def measured(family: Family, teacher: str, worlds: int, turns: int) -> Reliability:
    """The hedges of a teacher in the family's first environment, each world with one lesson of a random student."""
    id = f"{PREFIX}{family.showcase[0]}"
    settings = {"students": ("random",), "instruction_types": "b", "max_turns": turns}
    return audit(id, teacher, turns=worlds * turns, **settings).hedges  # type: ignore[arg-type]  # of several types


def table_of(found: Mapping[str, Reliability]) -> str:
    """A Markdown table with rows for each family."""
    rows = []
    for name, each in found.items():
        for group in each.bins:
            ends = " to ".join(f"{end:.0%}" for end in each.interval(group))
            said = f"{group.low:.0%} to {group.low + 0.09:.0%}"
            rows.append((name, said, f"{group.sentences:,}", f"{group.said:.1%}", f"{group.held:.1%} ({ends})"))
        scores = f"Brier score {each.brier:.3f}, calibration error {each.error:.3f}"
        verdict = f"{each.verdict} (p = {each.p_value:.2g})"
        rows.append((name, f"all, in {len(each.episodes):,} lessons", f"{each.sentences:,}", scores, verdict))
    return table(("family", "said", "sentences", "mean", "hold"), rows)


def plot(found: Mapping[str, Reliability], file: str) -> None:
    """Draw a panel for each family, with a dot and its 95 % interval for each ten of per cent.

    On the diagonal as many hedged claims hold as they say.
    """
    import matplotlib.style
    from matplotlib.figure import Figure
    from matplotlib.ticker import PercentFormatter

    from llf_teacher.studies.report.plots import SERIES, STYLE
    from llf_teacher.theme import SHADES

    with matplotlib.style.context([STYLE]):
        figure = Figure(figsize=(3 * len(found), 3))
        panels = figure.subplots(1, len(found), sharey=True, squeeze=False)[0]
        for axes, (name, each) in zip(panels, found.items(), strict=True):
            axes.plot((0.5, 1), (0.5, 1), color=SHADES["muted"].light, linewidth=0.8)
            for group in each.bins:
                axes.plot((group.said, group.said), each.interval(group), color=SERIES[0])
                axes.plot(group.said, group.held, "o", color=SERIES[0])
            axes.set_title(f"{name}: {each.sentences:,} sentences, {len(each.episodes):,} lessons", fontsize=8)
            axes.set(xlim=(0.5, 1), ylim=(0, 1.03), xlabel="probability that is said")
            axes.xaxis.set_major_formatter(PercentFormatter(1))
            axes.yaxis.set_major_formatter(PercentFormatter(1))
        panels[0].set_ylabel("share that holds")
        figure.savefig(file)
