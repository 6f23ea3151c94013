"""`llf golden`: write the golden transcripts that the tests replay."""

from pathlib import Path
from typing import Annotated

import typer

from llf_teacher.cli import draw_off_screen, say_missing


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("golden")(golden)


def golden(
    folder: Annotated[Path, typer.Argument(help="Where the transcripts go, one file an environment.")],
    id: Annotated[list[str] | None, typer.Argument(help="Environments; by default all, or a family's samples.")] = None,
) -> None:
    """Write a transcript of a short episode of each environment, as text, and hashes of a picture of each family.

    Simulators that draw by OpenGL keep the hashes that they had where there is none.
    """
    draw_off_screen()
    from llf_teacher.registry import entry
    from llf_teacher.tools import pictures
    from llf_teacher.tools.golden import write

    if not id:
        say_missing()
    ids = tuple(entry(name).id for name in id or ())
    for path in write(folder, ids):
        typer.echo(path)
    typer.echo(pictures.write(folder, ids))
