"""`llf dev reading`: measure how well the sentences of others are read."""

from pathlib import Path
from typing import Annotated

import typer


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("reading")(reading)


def reading(
    sentences: Annotated[
        Path, typer.Argument(help="Labelled sentences; the head of the file says how.", exists=True, dir_okay=False)
    ] = Path("tests/reading/sentences.txt"),
    families: Annotated[list[str] | None, typer.Option("--family", help="A family; by default all.")] = None,
) -> None:
    """Read labelled sentences, and each phrase of all voices by a reader that does not know it; show what is wrong."""
    from rich.console import Console

    from llf_teacher.registry import family
    from llf_teacher.tools import reading as measured
    from pz_envs.family import own_families

    chosen = {each.name: each for each in (map(family, families) if families else own_families())}
    results = list(measured.read_sentences(measured.labelled(sentences), chosen))
    for each in chosen.values():
        results += measured.read_left_out(each)
    console = Console(emoji=False)
    console.width = max(console.width, 160)
    console.print(measured.table(results), measured.curve(results), measured.confusion(results), sep="\n")
