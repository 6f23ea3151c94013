"""`llf film`: an episode as an animation."""

from pathlib import Path
from typing import Annotated

import typer

from llf_teacher.cli import complete_id, complete_student, complete_teacher, draw_off_screen


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("film")(film)


def film(
    id: Annotated[str, typer.Argument(help="Environment; `llf list` shows them.", autocompletion=complete_id)],
    path: Annotated[Path, typer.Argument(help="Where it goes: a .gif, a .webp, or with the extra `film` an .mp4.")],
    teacher: Annotated[
        str, typer.Option(help="Personality spec of the teacher.", autocompletion=complete_teacher)
    ] = "oracle",
    student: Annotated[str, typer.Option(help="Spec of the student.", autocompletion=complete_student)] = "obedient",
    instruction_type: Annotated[str, typer.Option(help="b, p or c.")] = "b",
    feedback_type: Annotated[str, typer.Option(help="a, n, m, or kinds such as r+hp.")] = "a",
    seed: Annotated[int, typer.Option(help="Seed of the episode.")] = 0,
    max_turns: Annotated[int | None, typer.Option(help="Turns at most.")] = None,
    theme: Annotated[str, typer.Option(help="light or dark.")] = "light",
    seconds: Annotated[float, typer.Option(help="How long each turn is shown.", min=0.02)] = 1.5,
    plain: Annotated[bool, typer.Option("--plain", help="Show only what the student may know.")] = False,
) -> None:
    """Film an episode, a frame a turn: the world, what the student did, and what the teacher said of it.

    It shows the truth, and whether each sentence holds, unless it is plain.
    """
    draw_off_screen()
    from llf_teacher.registry import entry
    from llf_teacher.tools.film import check_path, save
    from llf_teacher.tools.film import film as play

    check_path(path)
    frames = play(
        entry(id).id,
        teacher=teacher,
        student=student,
        instruction_type=instruction_type,
        feedback_type=feedback_type,
        seed=seed,
        max_turns=max_turns,
        theme=theme,
        privileged_info=not plain,
    )
    save(frames, path, seconds)
    typer.echo(f"{path}: {len(frames)} frames, {path.stat().st_size / 1000:.0f} kB")
