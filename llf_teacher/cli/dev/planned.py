"""`llf dev planned`: measure what planned teachers teach, and write the table of the documents."""

from pathlib import Path
from typing import Annotated

import typer


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("planned")(planned)


def planned(
    file: Annotated[Path | None, typer.Argument(help="Markdown file with markers for the table.")] = None,
    id: Annotated[
        list[str] | None,
        typer.Option(help="Measure only this environment of the table, such as gym:Taxi; repeat it for several."),
    ] = None,
) -> None:
    """Measure the environments that planned teachers teach, and write the table in FILE, or print it.

    The table stands between `<!-- llf dev planned: environments -->` and `<!-- end -->`. Rows of environments that are
    not installed are left out, with a message. Rows that are not measured stay. It takes some minutes.
    """
    from llf_teacher.tools.planned import ROWS, measure, table, update
    from teachers.spec import unknown
    from teachers.terminal import Waiting, error_console

    ids = [row.id for row in ROWS]
    if wrong := [name for name in id or () if name not in ids]:
        raise ValueError(unknown("environment of the table", wrong[0], ids))
    console = error_console()
    rows = []
    with Waiting() as waiting:
        for row in ROWS:
            if id and row.id not in id:
                continue
            try:
                rows.append(measure(row, waiting.say))
            except (ValueError, ModuleNotFoundError) as error:
                console.print(f"left out: {error}")
    if not rows:
        raise ValueError("none of the environments could be measured")
    if file is None:
        typer.echo(table(rows))
    else:
        file.write_text(update(file.read_text(encoding="utf-8"), rows), encoding="utf-8")
        typer.echo(file)
