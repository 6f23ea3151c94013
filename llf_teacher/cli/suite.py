"""`llf suite`: what a student can do with feedback, as a card."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from llf_teacher.cli import complete_student, search_here

STORE = Path("llf-suite.db")


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("suite")(suite)


def suite(
    student: Annotated[
        str, typer.Option(help="Spec of a student, or `module:factory` of your agent.", autocompletion=complete_student)
    ],
    card: Annotated[
        list[Path] | None, typer.Option(help="File to write: .json, .md, .svg or .html; repeat it for several.")
    ] = None,
    only: Annotated[list[str] | None, typer.Option(help="Experiment to take; repeat it for several.")] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Take the four experiments that tell most, with fewer seeds.")
    ] = False,
    key: Annotated[str, typer.Option(help="Text from which other seeds are drawn.")] = "",
    store: Annotated[Path, typer.Option(help="SQLite file for the episodes; an interrupted suite is resumed.")] = STORE,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Parallel processes; by default one for each core.")
    ] = None,
) -> None:
    """Take the suite: score what a student does with feedback, one ability an experiment.

    A score is what a student saves in regret beside a control, in the unit of a reference: 0 if it takes no notice.
    """
    from llf_teacher.suite import take

    search_here()
    console = Console(emoji=False, stderr=True, markup=False)
    with Progress(console=console, transient=True) as progress:
        task = progress.add_task("episodes", total=None)
        found = take(
            student,
            store,
            only or (),
            quick,
            key,
            workers,
            lambda done, total: progress.update(task, completed=done, total=total),
        )
    table = Table("ability", "score", "p", title=found.student)
    for each in found.lines:
        table.add_row(each.ability, each.words, each.chance)
    console.print(table)
    for sentence in found.sentences():
        console.print(f"- {sentence}")
    console.print(found.settings())
    for path in card or ():
        found.write(path)
        console.print(f"Card: {path.resolve()}")
