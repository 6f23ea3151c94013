"""`llf play`: a person plays the student in the terminal."""

from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("play")(play)


def play(
    id: Annotated[str, typer.Argument(help="Environment; `llf list` shows them.")],
    teacher: Annotated[str, typer.Option(help="Personality spec of the teacher.")] = "oracle",
    instruction_type: Annotated[str, typer.Option(help="b, p or c.")] = "b",
    feedback_type: Annotated[str, typer.Option(help="a, n, m, or kinds such as r+hp.")] = "a",
    seed: Annotated[int | None, typer.Option(help="Seed of the episode.")] = None,
    max_turns: Annotated[int | None, typer.Option(help="Turns at most.")] = None,
) -> None:
    """Play the student: read what the teacher says, type actions.

    End a text of several lines with an empty line. Ctrl-D leaves.
    """
    from gymnasium import spaces

    import llf_teacher

    env = llf_teacher.make(
        id,
        teacher=teacher,
        instruction_type=instruction_type,
        feedback_type=feedback_type,
        max_turns=max_turns,
        text=True,
    )
    console = Console(highlight=False)
    many_lines = isinstance(env.aec.world.action_space, spaces.Text)
    observation, _ = env.reset(seed=seed)
    total, turn, done = 0.0, 0, False
    while True:
        for key, style in (("instruction", "bold"), ("observation", "cyan"), ("feedback", "green")):
            if observation[key]:
                console.print(f"[{style}]{escape(observation[key])}[/]\n")
        if done:
            break
        turn += 1
        try:
            action = _ask(console, f"Turn {turn}> ", many_lines)
        except (EOFError, KeyboardInterrupt):
            console.print("\nYou left the episode.")
            return
        observation, reward, terminated, truncated, info = env.step(action)
        total += reward
        done = terminated or truncated or (info["success"] and not env.family.repeated)
    solved = "solved" if info["success"] else "not solved"
    console.print(f"Over after {turn} turns: {solved}, total reward {total:.4g}.")


def _ask(console: Console, prompt: str, many_lines: bool) -> str:
    lines = [console.input(prompt)]
    while many_lines and lines[-1].strip():
        lines.append(input())
    return "\n".join(lines)
