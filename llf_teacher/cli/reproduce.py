"""`llf reproduce`: reproduce known results of the field."""

from pathlib import Path
from typing import Annotated

import typer


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("reproduce")(reproduce)


def reproduce(
    only: Annotated[
        list[str] | None, typer.Option(help="Name of a result; repeat it for several. By default all.")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Use only a few seeds, as a trial.")] = False,
    store: Annotated[Path, typer.Option(help="File of measurements; those that it has are not repeated.")] = Path(
        "known-results.jsonl"
    ),
    page: Annotated[
        Path,
        typer.Option(
            help="Markdown page to write, with pages and plots in a folder of its name; results not played stay."
        ),
    ] = Path("known-results.md"),
) -> None:
    """Reproduce known results of the field, and write pages that compare them with their sources."""
    from rich.console import Console
    from rich.progress import Progress

    from llf_teacher.cli import errors
    from llf_teacher.reproductions.page import stored, write
    from llf_teacher.reproductions.play import play
    from llf_teacher.reproductions.row import all_rows, some_rows
    from llf_teacher.reproductions.rule import judge, verdict

    rows = some_rows(only or ())
    for name in [name for name, row in rows.items() if row.missing()]:
        errors.print(f"left out: the row {name} {rows.pop(name).missing()}")
    with Progress(console=Console(emoji=False, stderr=True)) as progress:
        bars = {name: progress.add_task(name, total=None) for name in rows}
        values = play(
            rows, store, quick, lambda name, done, total: progress.update(bars[name], completed=done, total=total)
        )
    there = {name: stored(row, page.with_suffix("") / f"{name}.json") for name, row in all_rows().items()}
    values = {name: found for name, each in there.items() if (found := values.get(name, each))}
    write({name: row for name, row in all_rows().items() if name in values}, values, page)
    for name, row in rows.items():
        typer.echo(f"{name}: {verdict(judge(row.rule, values[name], row.measures))}")
    typer.echo(f"Written to {page}; measurements are in {store}.")
