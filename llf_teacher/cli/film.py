"""`llf film`: write an episode as an animation."""

from pathlib import Path
from typing import Annotated

import typer

from llf_teacher import cli
from llf_teacher.cli import (
    complete_id,
    complete_student,
    complete_teacher,
    draw_off_screen,
    help_shows,
    read_options,
    search_here,
)


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("film")(film)


@help_shows("teacher", "student", "seed", "max_turns", "theme")
def film(
    id: Annotated[str, typer.Argument(help="Environment, as `llf list` shows it.", autocompletion=complete_id)],
    path: Annotated[Path, typer.Argument(help="File to write: .gif, .webp, or, with the extra `film`, .mp4.")],
    teacher: Annotated[
        str, typer.Option(help="Teacher, such as 'mistake(eps=0.3)' or module:Class.", autocompletion=complete_teacher)
    ] = "oracle",
    student: Annotated[
        str, typer.Option(help="Student, such as obedient or module:Class.", autocompletion=complete_student)
    ] = "obedient",
    instruction_type: cli.InstructionType = "b",
    feedback_type: cli.FeedbackType = "a",
    seed: Annotated[int, typer.Option(min=0, help="Seed of the episode.")] = 0,
    max_turns: cli.MaxTurns = None,
    option: cli.WorldOptions = None,
    theme: Annotated[str, typer.Option(help="Colours: light or dark.")] = "light",
    seconds: Annotated[float, typer.Option(help="Seconds that each turn is shown.", min=0.02)] = 1.5,
    bits: Annotated[
        int,
        typer.Option(min=0, max=100_000, metavar="WORLDS", help="Show how much each claim says, by these worlds."),
    ] = 0,
    plain: Annotated[
        bool,
        typer.Option(
            "--plain", help="Show only what the student may know, without the truth and the labels of sentences."
        ),
    ] = False,
    _advanced: cli.Advanced = False,
) -> None:
    """Write an episode as an animation with one frame for each turn: the world, the action and the feedback.

    The frames also show the truth, and whether each sentence is true; leave both out with --plain.
    """
    draw_off_screen()
    from llf_teacher.registry import entry
    from llf_teacher.tools.film import check_path, save
    from llf_teacher.tools.film import film as play

    check_path(path)
    search_here()
    frames = play(
        entry(id).id,
        teacher=teacher,
        student=student,
        instruction_type=instruction_type,
        feedback_type=feedback_type,
        seed=seed,
        worlds=bits,
        max_turns=max_turns,
        theme=theme,
        privileged_info=not plain,
        options=read_options(option),
    )
    save(frames, path, seconds)
    typer.echo(f"{path}: {len(frames)} frames, {path.stat().st_size / 1000:.0f} kB")
