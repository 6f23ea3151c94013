"""`llf new`: begin a family, a personality, a student or a trait with files that work."""

from pathlib import Path
from typing import Annotated

import typer

_NEXT = {
    "family": (
        "Change them into what you want, file by file; CONTRIBUTING.md says what each must have. Then run:",
        "pytest -n0 tests/worlds/test_{name}.py",
        "llf play llf-{id}-v0",
        "llf dev golden tests/golden llf-{id}-v0",
        "llf dev tables",
        "pytest -n0 tests/repository/test_public.py",
    ),
    "personality": (
        "Change it into what you want; CONTRIBUTING.md says what it may do. Then run:",
        "pytest -n0 tests/teachers/test_{name}.py",
        "llf play llf-gridworld-v0 --teacher {name}",
        "llf dev tables",
        "pytest -n0 tests/repository/test_public.py",
    ),
    "student": (
        "Change it into what you want; CONTRIBUTING.md says what it may do. Then run:",
        "pytest -n0 tests/llf_teacher/test_{name}.py",
        "llf play llf-gridworld-v0 --seat teacher --student {name}",
        "pytest -n0 tests/repository/test_public.py",
    ),
    "trait": (
        "Change it into what you want; CONTRIBUTING.md says what it may do. Then run:",
        "pytest -n0 tests/llf_teacher/test_{name}.py",
        "llf play llf-gridworld-v0 --seat teacher --student 'obedient | {name}'",
    ),
}
"""The next step for each kind: a sentence, and commands."""


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("new")(new)


def new(
    kind: Annotated[str, typer.Argument(help="What to begin: family, personality, student or trait.")],
    name: Annotated[str, typer.Argument(help="Its name, a Python identifier in lower case.")],
    folder: Annotated[Path, typer.Option(help="A clone of the repository.")] = Path(),
) -> None:
    """Begin a family, a personality, a student or a trait of your own: small files that work and pass their checks.

    Existing files stay unchanged.
    """
    from llf_teacher.tools.scaffold import id_of, write

    for path in write(kind, name, folder):
        typer.echo(f"wrote {path}")
    what, *commands = _NEXT[kind]
    typer.echo(f"\n{what}\n")
    for command in commands:
        typer.echo(f"    {command.format(name=name, id=id_of(name))}")
