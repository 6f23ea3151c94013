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
    from rich.console import Console
    from rich.progress import track

    from llf_teacher.tools import bits as tool
    from llf_teacher.tools.markdown import update
    from teachers.spec import unknown

    able = tool.families()
    for name in families or ():
        if name not in able:
            raise typer.BadParameter(unknown("family with a posterior", name, able))
    for name in track(families or list(able), "measuring", console=Console(emoji=False, stderr=True), transient=True):
        text = tool.measured(able[name], teacher or ["oracle"], turns, worlds)
        file.write_text(update(file.read_text(encoding="utf-8"), "llf dev bits", {name: text}), encoding="utf-8")
