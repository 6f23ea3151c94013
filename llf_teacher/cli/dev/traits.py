"""`llf dev traits`: measure how well the strengths of students' traits are recovered from transcripts."""

from pathlib import Path
from typing import Annotated

import typer


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("traits")(traits)


def traits(
    file: Annotated[
        Path | None, typer.Argument(help="Markdown file with markers; without it the table is printed.", exists=True)
    ] = None,
    runs: Annotated[int, typer.Option(min=2, help="Estimates for each trait and environment.")] = 200,
    episodes: Annotated[int, typer.Option(min=1, help="Episodes for each estimate.")] = 10,
) -> None:
    """Estimate each trait's strength from the transcripts of many runs, and count intervals that hold the truth.

    The table stands between `<!-- llf dev traits: recovery -->` and `<!-- end -->`.
    """
    from rich.progress import Progress

    from llf_teacher.tools.markdown import rewrite
    from llf_teacher.tools.recovery import as_table, places, recoverable, recoveries
    from teachers.terminal import error_console

    with Progress(console=error_console()) as progress:
        task = progress.add_task("runs", total=runs * sum(len(places(trait)) for trait in recoverable()))
        text = as_table(list(recoveries(runs, episodes, lambda: progress.advance(task))))
    if file is None:
        typer.echo(text)
    else:
        rewrite(file, "llf dev traits", {"recovery": text})
