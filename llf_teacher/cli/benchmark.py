"""`llf benchmark`: what a step costs, beside what it costs elsewhere."""

import typer


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("benchmark")(benchmark)


def benchmark() -> None:
    """Measure steps of each family beside the bare world and FrozenLake, and seats beside PettingZoo's tictactoe."""
    from rich.console import Console

    from llf_teacher.benchmark import imports, seats, steps

    console = Console()
    console.print(steps())
    console.print(seats())
    console.print(imports())
