"""`llf dev benchmark`: measure the time of steps, worlds and seats."""

from typing import Annotated

import typer

from llf_teacher.cli import print_missing

_WIDTH = 200
"""Width of the widest table, in characters."""


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("benchmark")(benchmark)


def benchmark(
    families: Annotated[
        list[str] | None, typer.Argument(metavar="FAMILY", help="Families; by default all that are installed.")
    ] = None,
    against: Annotated[
        str | None, typer.Option(help="Only compare with a revision of this repository, or a folder with the packages.")
    ] = None,
    everything: Annotated[
        bool, typer.Option("--all", help="With --against, compare raw_env, TeacherEnv and a study, too.")
    ] = False,
    limit: Annotated[
        float | None, typer.Option(min=1.0, help="With --against, the ratio of times above which work is slower; 1.25.")
    ] = None,
    batch: Annotated[bool, typer.Option("--batch", help="Only measure lessons in arrays.")] = False,
    runs: Annotated[int | None, typer.Option(min=1, help="Runs of the tables, of which medians are shown; 5.")] = None,
) -> None:
    """Measure steps beside FrozenLake's, worlds beside the originals, seats beside tictactoe, all on fresh episodes.

    A figure is the median of the runs; the brackets contain the lowest and the highest, if processes differ.
    With --against, the exit status is 1 if the lower end of a ratio's 95 % interval is above the limit in two runs.
    """
    from rich.console import Console
    from rich.table import Table

    from llf_teacher.tools import benchmark
    from pz_envs.family import all_families
    from teachers.terminal import Waiting

    if everything and against is None:
        raise typer.BadParameter("--all needs --against; add it, or leave out --all")
    if runs is not None and against is not None:
        raise typer.BadParameter("--runs is for the tables, which --against does not make; leave out one of them")
    if limit is not None and against is None:
        raise typer.BadParameter("--limit needs --against; add it, or leave out --limit")
    runs, limit = runs or benchmark.RUNS, limit or benchmark.ALLOWED
    known = {family.name: family for family in all_families()}
    if unknown := [name for name in families or () if name not in known]:
        raise typer.BadParameter(f"there is no family {', '.join(unknown)}; allowed: {', '.join(known)}")
    if not families:
        print_missing()
    chosen = [known[name] for name in families or known if not known[name].missing()]
    console = Console(emoji=False, width=max(Console(emoji=False).width, _WIDTH))
    with Waiting() as waiting:
        if batch:
            from llf_teacher.tools.throughput import throughput

            console.print(throughput(waiting.say, runs=runs))
            return
        if against is None:
            tables = [
                benchmark.steps(chosen, waiting.say, runs),
                benchmark.worlds(chosen, waiting.say, runs),
                benchmark.seats(chosen, waiting.say, runs),
            ]
            if not families:
                tables += [benchmark.forms(waiting.say, runs), benchmark.imports(waiting.say)]
            for table in tables:
                console.print(table)
            return
        try:
            found = list(benchmark.compare_speed(chosen, against, waiting.say, everything, limit))
        except ValueError as error:
            raise typer.BadParameter(str(error)) from None
    table = Table("environment", "work", "this / other", "95 % interval", box=None, padding=(0, 2, 0, 0))
    for each in found:
        low, high = f"{each.ratio.low:.2f}", f"{each.ratio.high:.2f}"
        table.add_row(each.id, each.work, f"{each.ratio.mean:.2f}", f"{low} to {high}" + " SLOWER" * each.slower)
    console.print(table)
    if any(each.slower for each in found):
        raise typer.Exit(1)
