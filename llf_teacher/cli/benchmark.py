"""`llf benchmark`: what a step costs, beside what it costs elsewhere."""

from typing import Annotated

import typer

from llf_teacher.cli import say_missing

_WIDTH = 160
"""Characters that the widest table needs."""


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("benchmark")(benchmark)


def benchmark(
    families: Annotated[
        list[str] | None, typer.Argument(metavar="FAMILY", help="Families; all that are installed by default.")
    ] = None,
    against: Annotated[
        str | None, typer.Option(help="Compare with a revision, or a folder of an installation, and nothing else.")
    ] = None,
    batch: Annotated[bool, typer.Option("--batch", help="Time lessons in arrays, and nothing else.")] = False,
) -> None:
    """Time fresh work: steps beside FrozenLake's, worlds beside the originals, seats beside tictactoe.

    With --against, exit status 1 where the lower end of a ratio's 95 % interval is above 1.25, twice in succession.
    """
    from rich.console import Console
    from rich.table import Table

    from llf_teacher.tools import benchmark
    from pz_envs.family import all_families

    known = {family.name: family for family in all_families()}
    if unknown := [name for name in families or () if name not in known]:
        raise typer.BadParameter(f"there is no family {', '.join(unknown)}; allowed: {', '.join(known)}")
    if not families:
        say_missing()
    chosen = [known[name] for name in families or known if not known[name].missing()]
    console = Console(width=max(Console().width, _WIDTH))
    status = Console(stderr=True).status("")
    with status:
        if batch:
            from llf_teacher.tools.throughput import throughput

            console.print(throughput(progress=status.update))
            return
        if against is None:
            tables = [
                benchmark.steps(chosen, status.update),
                benchmark.worlds(chosen, status.update),
                benchmark.seats(chosen, status.update),
            ]
            if not families:
                tables += [benchmark.forms(status.update), benchmark.imports(status.update)]
            for table in tables:
                console.print(table)
            return
        try:
            found = list(benchmark.compare(chosen, against, status.update))
        except ValueError as error:
            raise typer.BadParameter(str(error)) from None
    table = Table("environment", "work", "this / other", "95 % interval", box=None, padding=(0, 2, 0, 0))
    for each in found:
        low, high = f"{each.ratio.low:.2f}", f"{each.ratio.high:.2f}"
        table.add_row(each.id, each.work, f"{each.ratio.mean:.2f}", f"{low} to {high}" + " SLOWER" * each.slower)
    console.print(table)
    if any(each.slower for each in found):
        raise typer.Exit(1)
