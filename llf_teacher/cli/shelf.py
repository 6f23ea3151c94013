"""`llf shelf`: the tables of personalities."""

from pathlib import Path
from typing import Annotated

import typer


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("shelf")(shelf)


def shelf(
    file: Annotated[Path | None, typer.Argument(help="A Markdown file whose tables are to be made anew.")] = None,
) -> None:
    """Print every personality, and which family serves which; or update these tables in a document."""
    from llf_teacher.tools.shelf import TABLES, write

    if file is not None:
        write(file)
    else:
        typer.echo("\n".join(table() for table in TABLES.values()))
