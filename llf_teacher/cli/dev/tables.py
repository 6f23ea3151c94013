"""`llf dev tables`: write the tables of families and personalities in the documents."""

from pathlib import Path
from typing import Annotated

import typer

from llf_teacher.cli import print_missing


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("tables")(tables)


def tables(
    file: Annotated[Path | None, typer.Argument(help="Markdown file with markers for tables.")] = None,
) -> None:
    """Write the tables of families and personalities in FILE, or in every document of the working directory.

    The documents are `*.md` and `docs/*.md`. A table stands between `<!-- llf dev tables: NAME -->` and `<!-- end -->`.
    If no document has such markers, the tables are printed.
    """
    from llf_teacher.tools.tables import TABLES, documents, write

    print_missing()
    found = documents(Path()) if file is None else [file]
    for path in found:
        write(path)
        typer.echo(path)
    if not found:
        typer.echo("\n".join(table() for table in TABLES.values()))
