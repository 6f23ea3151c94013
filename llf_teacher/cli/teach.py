"""`llf teach`: try what can be taught in an environment."""

import os
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from llf_teacher.cli import complete_teacher, read_options, search_here
from llf_teacher.escaping import escape_control_chars


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("teach")(teach)


def teach(
    environment: Annotated[
        str,
        typer.Argument(
            metavar="ENVIRONMENT",
            help="An id of Gymnasium, such as gym:Taxi-v4, or package.module:name of a class or a function that makes "
            "an environment.",
        ),
    ],
    option: Annotated[
        list[str] | None,
        typer.Option(help="Option of the environment, as NAME=VALUE, such as oracle=rewards; repeat it for several."),
    ] = None,
    teacher: Annotated[
        str,
        typer.Option(help="Teacher, such as 'mistake(eps=0.3)' or module:Class.", autocompletion=complete_teacher),
    ] = "oracle",
    seed: Annotated[int, typer.Option(help="Seed of the episode.")] = 0,
) -> None:
    """Show what can be taught in an environment: its spaces, what the teacher knows, an episode, and what is missing.

    The exit status is 1 if the environment breaks Gymnasium's interface.
    """
    from llf_teacher.speakers.parsing import parse_teacher
    from llf_teacher.speakers.speaker import Speaker
    from llf_teacher.tools.trial import trial
    from pz_envs.registered import registered
    from pz_envs.subject import GYM

    search_here()
    if ":" not in environment:
        raise ValueError(
            f"environment {environment!r} must be an id of Gymnasium with its prefix, {GYM}{environment}, or "
            "package.module:name of a class or a function that makes an environment"
        )
    subject = registered(environment if environment.startswith(GYM) else f"{GYM}{environment}")
    taught = parse_teacher(teacher)
    if isinstance(taught, Speaker):
        taught.check(os.environ)
    console = Console(emoji=False, highlight=False)
    broken = False
    for line in trial(subject, read_options(option), seed, taught):
        style = {True: "green", False: "yellow", None: ""}[line.good]
        console.print(Text(f"{line.about:13} ", "bold").append(escape_control_chars(line.text), style), soft_wrap=True)
        broken |= line.about == "interface" and not line.good
    if broken:
        raise typer.Exit(1)
