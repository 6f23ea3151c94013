"""`llf dev calibration`: measure how often the statistics of studies are right."""

from pathlib import Path
from typing import Annotated

import typer

NAMES = ("errors", "powers", "coverage", "binary", "bootstrap")


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("calibration")(calibration)


def calibration(
    file: Annotated[
        Path | None,
        typer.Argument(help="Markdown file with markers for the tables; without it they are printed.", exists=True),
    ] = None,
    only: Annotated[list[str] | None, typer.Option(help=f"A table; one of {', '.join(NAMES)}. By default all.")] = None,
    store: Annotated[
        Path, typer.Option(help="Store of the episodes that studies are dealt from; it gets those that it lacks.")
    ] = Path("llf-calibration.db"),
    worlds: Annotated[int, typer.Option(min=20, help="Seeds of these episodes.")] = 120,
    studies: Annotated[int, typer.Option(min=1, help="Studies per row of error rates and power.")] = 1000,
    draws: Annotated[int, typer.Option(min=10, help="Draws per cell of coverage.")] = 4000,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all that is drawn.")] = 0,
) -> None:
    """Measure error rates of studies without an effect, power, and how often intervals cover, as tables.

    A table stands between `<!-- llf dev calibration: NAME -->` and `<!-- end -->`.
    """
    from rich.progress import Progress

    from llf_teacher.studies.execution.progress import StudyProgress
    from llf_teacher.tools import calibration as measured
    from llf_teacher.tools.markdown import rewrite
    from teachers.spec import unknown
    from teachers.terminal import error_console

    for name in only or ():
        if name not in NAMES:
            raise typer.BadParameter(unknown("table", name, NAMES))
    extent = measured.Extent(studies, draws, seed)
    console = error_console()
    names = [name for name in NAMES if name in (only or NAMES)]
    pool: measured.Pool = {}
    if {"errors", "powers"} & {*names}:
        with StudyProgress(console) as playing:
            pool = measured.read_pool(store, worlds, playing)
    with Progress(console=console) as progress:
        tasks = {name: progress.add_task(name, total=measured.steps(extent)[name]) for name in names}
        for name, text in measured.tables(extent, names, pool, lambda name: lambda: progress.advance(tasks[name])):
            if file is None:
                typer.echo(f"{name}\n\n{text}")
            else:
                rewrite(file, "llf dev calibration", {name: text})
