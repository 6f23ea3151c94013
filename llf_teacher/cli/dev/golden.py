"""`llf dev golden`: write the golden transcripts that the tests replay."""

from pathlib import Path
from typing import Annotated

import typer

from llf_teacher.cli import draw_off_screen, print_missing


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("golden")(golden)


def golden(
    folder: Annotated[Path, typer.Argument(help="Folder to write, one file for each environment.")],
    id: Annotated[
        list[str] | None, typer.Argument(help="Environments; by default all, of a large family some.")
    ] = None,
) -> None:
    """Write a transcript of a short episode of each environment, and a hash of a picture of each family.

    Without OpenGL, the families that need it keep the hashes in the folder.
    """
    draw_off_screen()
    from llf_teacher.registry import entry
    from llf_teacher.tools import pictures
    from llf_teacher.tools.golden import write

    if not id:
        print_missing()
    ids = tuple(entry(name).id for name in id or ())
    for path in write(folder, ids):
        typer.echo(path)
    typer.echo(pictures.write(folder, ids))
