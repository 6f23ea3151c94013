"""`llf dev compare`: compare the behaviour of two installations."""

from typing import Annotated

import typer

from llf_teacher.cli import print_missing


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("compare")(compare)


def compare(
    other: Annotated[str, typer.Argument(help="A revision of this repository, or a folder with the packages.")],
    id: Annotated[list[str] | None, typer.Argument(help="Environments; by default the first of each family.")] = None,
    teacher: Annotated[
        list[str] | None, typer.Option(help="Spec of a personality; repeat it for several. By default oracle.")
    ] = None,
    episodes: Annotated[int, typer.Option(min=1, help="Episodes of each environment and teacher.")] = 100,
    turns: Annotated[int, typer.Option(min=1, help="Most turns of an episode.")] = 20,
) -> None:
    """Play the same fresh episodes here and in another installation, and compare every word and action.

    Half of the episodes have random actions, half advised ones. Floats are compared to the last bit. The exit status
    is 1 if an episode differs.
    """
    from rich.console import Console
    from rich.table import Table

    from llf_teacher.registry import PREFIX, entry
    from llf_teacher.tools.benchmark import equality
    from pz_envs.family import all_families
    from teachers.personality import parse_personality
    from teachers.terminal import Waiting

    if not id:
        print_missing()
    ids = [entry(name).id for name in id or ()] or [
        PREFIX + family.showcase[0] for family in all_families() if not family.missing()
    ]
    teachers = [str(parse_personality(spec)) for spec in teacher or ["oracle"]]
    table = Table("environment", "teacher", "episodes", "turns", "differ", box=None, padding=(0, 2, 0, 0))
    found = []
    with Waiting() as waiting:
        try:
            for each in equality.compare(ids, teachers, other, episodes, turns, waiting.say):
                found.append(each)
                table.add_row(each.id, each.teacher, *(f"{n:,}" for n in (each.episodes, each.turns, each.differing)))
        except ValueError as error:
            raise typer.BadParameter(str(error)) from None
    Console(emoji=False, width=max(Console(emoji=False).width, 120)).print(table)
    for each in found:
        if each.first:
            typer.echo(f"\n{each.id}, {each.teacher}, seed {each.first.seed}, turn {each.first.turn}")
            typer.echo(f"  here:  ...{each.first.here}\n  there: ...{each.first.there}")
    if any(each.differing for each in found):
        raise typer.Exit(1)
