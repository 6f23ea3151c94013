"""`llf dev movies`: make catalogues of films and series."""

from pathlib import Path
from typing import Annotated

import typer

from llf_teacher.cli import Commands


def add_to(app: typer.Typer) -> None:
    """Add the command with its subcommand."""
    group = typer.Typer(
        cls=Commands, help="Make catalogues of films and series for `llf-reco-movie-v0`.", no_args_is_help=True
    )
    group.callback()(movies)
    group.command("import")(import_)
    app.add_typer(group, name="movies")


def movies() -> None:
    """Make catalogues of films and series."""


def import_(
    source: Annotated[
        Path, typer.Argument(help="IMDb's title.basics.tsv or MovieLens's movies.csv, as it is or packed with gzip.")
    ],
    target: Annotated[
        Path, typer.Argument(help="SQLite file to write; environments take it as the option `catalogue`.")
    ],
    ratings: Annotated[
        Path | None, typer.Option(help="IMDb's title.ratings.tsv, as it is or packed with gzip.")
    ] = None,
    least_votes: Annotated[int, typer.Option(min=0, help="Leave out titles with fewer votes; needs --ratings.")] = 0,
) -> None:
    """Write the catalogue TARGET from a public file of IMDb or MovieLens; on failure TARGET does not change.

    These files have no age ratings, so with such a catalogue users have no wishes about age.
    """
    from rich.progress import BarColumn, DownloadColumn, Progress, TextColumn, TimeRemainingColumn

    from teachers.terminal import error_console
    from worlds.movies.catalogue.importing import import_catalogue

    console = error_console()
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), DownloadColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console) as progress:
        task = progress.add_task(source.name, total=None)
        done = import_catalogue(
            source, target, ratings, least_votes, lambda read, size: progress.update(task, completed=read, total=size)
        )
    console.print(f"{target}: {done.taken} films and series; {done.left_out} rows were left out.")
