"""`llf benchmark`: what a step costs, beside what it costs elsewhere."""

import typer


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("benchmark")(benchmark)


def benchmark() -> None:
    """Measure steps of families beside their worlds, FrozenLake and the originals, and seats beside tictactoe."""
    from rich.console import Console

    from llf_teacher.tools.benchmark import forms, imports, seats, steps

    console = Console()
    console.print(steps())
    console.print(seats())
    console.print(forms())
    console.print(imports())
