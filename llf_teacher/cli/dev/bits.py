"""`llf dev bits`: measure how much claims of each class say."""

from pathlib import Path
from typing import Annotated

import typer


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("bits")(bits)


def bits(
    file: Annotated[Path, typer.Argument(help="Markdown file with markers.", exists=True)],
    families: Annotated[
        list[str] | None, typer.Argument(metavar="FAMILY", help="Families; by default all that have a posterior.")
    ] = None,
    teacher: Annotated[
        list[str] | None, typer.Option(help="Spec of a personality; repeat it for several. By default oracle.")
    ] = None,
    turns: Annotated[int, typer.Option(min=2, help="Turns with each teacher.")] = 60,
    worlds: Annotated[int, typer.Option(min=1, help="Number of worlds by which a claim is measured.")] = 256,
) -> None:
    """Measure how much claims of each class say after a basic instruction, and which regret they save.

    The table of a family stands between `<!-- llf dev bits: FAMILY -->` and `<!-- end -->`.
    """
    from rich.progress import track

    from llf_teacher.tools import bits as tool
    from llf_teacher.tools.markdown import rewrite
    from teachers.terminal import error_console

    chosen = tool.families(families).items()
    for name, family in track(chosen, "measuring", console=error_console(), transient=True):
        rewrite(file, "llf dev bits", {name: tool.measured(family, teacher or ["oracle"], turns, worlds)})
