"""`llf shelf`: the tables of families and personalities."""

from pathlib import Path
from typing import Annotated

import typer

from llf_teacher.cli import say_missing


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("shelf")(shelf)


def shelf(
    file: Annotated[Path | None, typer.Argument(help="A Markdown file whose tables are to be made anew.")] = None,
) -> None:
    """Make the tables of families and personalities anew: in a file, or in all documents of this folder that have
    places for them, `*.md` and `docs/*.md`; where there are none, print them.
    """  # noqa: D205
    from llf_teacher.tools.shelf import TABLES, documents, write

    say_missing()
    found = documents(Path()) if file is None else [file]
    for path in found:
        write(path)
        typer.echo(path)
    if not found:
        typer.echo("\n".join(table() for table in TABLES.values()))
