"""`llf dev hedges`: write and draw how often hedged claims hold."""

from pathlib import Path
from typing import Annotated

import typer


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("hedges")(hedges)


def hedges(
    file: Annotated[Path, typer.Argument(help="Markdown file with markers.", exists=True)],
    plot: Annotated[Path | None, typer.Option(help="Picture to write, such as hedges.png.")] = None,
    teacher: Annotated[str, typer.Option(help="Spec of a personality that hedges.")] = "partial(worlds=16)",
    worlds: Annotated[int, typer.Option(min=1, help="Worlds of each family, with a lesson in each.")] = 200,
    turns: Annotated[int, typer.Option(min=1, help="Turns of a lesson.")] = 6,
) -> None:
    """Measure how often hedged claims hold, in each family with a posterior.

    The table stands between `<!-- llf dev hedges: reliability -->` and `<!-- end -->`.
    """
    from rich.progress import track

    from llf_teacher.tools import hedges as tool
    from llf_teacher.tools.bits import families
    from llf_teacher.tools.markdown import rewrite
    from teachers.terminal import error_console

    each = track(families().items(), "measuring", console=error_console(), transient=True)
    found = {name: tool.measured(family, teacher, worlds, turns) for name, family in each}
    rewrite(file, "llf dev hedges", {"reliability": tool.table_of(found)})
    if plot is not None:
        tool.plot(found, str(plot))
