"""`llf list`: the environments, teachers and students that there are."""

import dataclasses
from typing import Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from llf_teacher.cli import say_missing


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("list")(list_)


def list_() -> None:
    """List environments, teacher personalities and students."""
    from llf_teacher.registry import entries, supported_types
    from llf_teacher.students.parsing import STUDENTS
    from pz_envs.family import all_families
    from teachers.personality import PERSONALITIES

    console = Console(highlight=False)
    console.print("[bold]Environments[/]")
    say_missing()
    for family in all_families():
        if family.missing():
            continue
        ids = [id for id, its_family, *_ in entries().values() if its_family is family]
        instructions, feedback = (" ".join(types) for types in supported_types(ids[0]))
        console.print(f"\n[bold]{family.name}[/]: {escape(family.summary)}")
        console.print(f"  {family.max_turns} turns, instructions {instructions}, feedback {feedback}")
        for id in ids:
            console.print(f"  [cyan]{id}[/]", soft_wrap=True)
    for title, catalogue in (("Teacher personalities", PERSONALITIES), ("Students", STUDENTS)):
        table = Table(box=None, show_header=False, padding=(0, 2, 0, 2))
        for name in catalogue.names:
            cls: Any = catalogue[name]
            parameters = ", ".join(f"{field.name}={field.default!r}" for field in dataclasses.fields(cls))
            spec = f"{name}({parameters})" if parameters else name
            table.add_row(f"[cyan]{escape(spec)}[/]", (cls.__doc__ or "").partition("\n")[0])
        console.print(f"\n[bold]{title}[/]", table, sep="\n")
