"""`llf dev posteriors`: check that posteriors are calibrated, and measure what they and turns by them cost."""

from pathlib import Path
from typing import Annotated

import typer


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("posteriors")(posteriors)


def posteriors(
    families: Annotated[
        list[str] | None, typer.Argument(metavar="FAMILY", help="Families; by default all that have a posterior.")
    ] = None,
    histories: Annotated[int, typer.Option(min=20, help="Untaught histories for each environment.")] = 1000,
    plot: Annotated[
        Path | None, typer.Option(help="Picture of the distributions of ranks to write, such as ranks.svg.")
    ] = None,
    worlds: Annotated[
        int,
        typer.Option(min=0, help="Measure turns of the student reasoner and of the teacher informative by so many."),
    ] = 0,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the histories.")] = 0,
) -> None:
    """Rank the true world among drawn ones (simulation-based calibration), and compare a draw with a reset.

    The exit status is 1 if ranks are less even than those of one right posterior in 100,000.
    """
    from rich.console import Console
    from rich.progress import track

    from llf_teacher.registry import entries
    from llf_teacher.tools import posteriors as measured
    from llf_teacher.tools.bits import families as able
    from teachers.terminal import error_console
    from worlds.posteriors.testing import THRESHOLD

    names = able(families)
    chosen = [entry for entry in entries().values() if entry.family.name in names]
    console = error_console()
    found = [
        measured.measure(entry, histories, seed) for entry in track(chosen, "ranking", console=console, transient=True)
    ]
    if plot is not None:
        measured.plot(found, str(plot))
    output = Console(emoji=False)
    output.width = max(output.width, 130)
    output.print(measured.table(found))
    if worlds:
        turns = [
            measured.costs(entry, seed, worlds)
            for entry in track(chosen, "taking times", console=console, transient=True)
        ]
        output.print(measured.table_of_costs(turns))
    if any(each.p < THRESHOLD for one in found for each in one.calibration.values()):
        raise typer.Exit(1)
