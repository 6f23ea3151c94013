"""`llf list`: the environments, teachers and students that there are."""

import dataclasses
from typing import Any

import typer
from rich.console import Console
from rich.table import Table


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("list")(list_)


def list_() -> None:
    """List environments, teacher personalities and students."""
    from llf_teacher.registry import entries, supported_types
    from llf_teacher.student import STUDENTS
    from teachers.personality import PERSONALITIES

    console = Console()
    table = Table(
        "environment", "family", "turns", "instructions", "feedback", title="Environments", title_justify="left"
    )
    for id, family, _ in entries().values():
        instructions, feedback = supported_types(id)
        table.add_row(id, family.name, str(family.max_cycles), " ".join(instructions), " ".join(feedback))
    console.print(table)
    for title, catalogue in (("Teacher personalities", PERSONALITIES), ("Students", STUDENTS)):
        table = Table("spec", "what it does", title=title, title_justify="left")
        for name in catalogue.names:
            cls: Any = catalogue[name]
            parameters = ", ".join(f"{field.name}={field.default!r}" for field in dataclasses.fields(cls))
            table.add_row(f"{name}({parameters})" if parameters else name, (cls.__doc__ or "").partition("\n")[0])
        console.print(table)
