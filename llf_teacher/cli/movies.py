"""`llf catalogue`: larger catalogues of films and series."""

from pathlib import Path
from typing import Annotated

import typer


def add_to(app: typer.Typer) -> None:
    """Add the command with its subcommand."""
    group = typer.Typer(help="Make catalogues of films and series, to recommend from.", no_args_is_help=True)
    group.callback()(catalogue)
    group.command("import")(import_)
    app.add_typer(group, name="catalogue")


def catalogue() -> None:
    """Make catalogues of films and series, to recommend from."""


def import_(
    source: Annotated[
        Path, typer.Argument(help="IMDb's title.basics.tsv, or MovieLens's table of titles; packed with gzip or not.")
    ],
    target: Annotated[Path, typer.Argument(help="SQLite file to write, for the option `catalogue` of an environment.")],
    ratings: Annotated[Path | None, typer.Option(help="IMDb's title.ratings.tsv, packed with gzip or not.")] = None,
    least_votes: Annotated[int, typer.Option(min=0, help="Leave out what has fewer votes; needs --ratings.")] = 0,
) -> None:
    """Make the catalogue TARGET of a public file of IMDb or MovieLens; TARGET stays as it was if that fails.

    These files tell no age ratings: with such a catalogue, users have no age wishes.
    """
    from rich.console import Console
    from rich.progress import BarColumn, DownloadColumn, Progress, TextColumn, TimeRemainingColumn

    from worlds.movies.catalogue.importing import import_catalogue

    console = Console(stderr=True, markup=False)
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), DownloadColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console) as progress:
        task = progress.add_task(source.name, total=None)
        done = import_catalogue(
            source, target, ratings, least_votes, lambda read, size: progress.update(task, completed=read, total=size)
        )
    console.print(f"{target}: {done.taken} films and series; {done.left_out} rows were left out.")
