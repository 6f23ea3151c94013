"""`llf play`: a person plays the student or the teacher in the terminal."""

from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape

from llf_teacher.visible import visible
from teachers.atoms import KINDS
from teachers.feedback import parse_kinds

if TYPE_CHECKING:
    from pz_envs.teacher_seat import TeacherSeat
    from teachers.atoms import Claim


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("play")(play)


def play(
    id: Annotated[str, typer.Argument(help="Environment; `llf list` shows them.")],
    seat: Annotated[str, typer.Option(help="Your seat: student or teacher.")] = "student",
    teacher: Annotated[
        str, typer.Option(help="Personality spec of the teacher; of your claims in its seat.")
    ] = "oracle",
    student: Annotated[str, typer.Option(help="Spec of the student whom you teach.")] = "obedient",
    instruction_type: Annotated[str, typer.Option(help="b, p or c.")] = "b",
    feedback_type: Annotated[str, typer.Option(help="a, n, m, or kinds such as r+hp.")] = "a",
    budget: Annotated[int | None, typer.Option(help="Claims that you may make as the teacher.")] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of the episode.")] = None,
    max_turns: Annotated[int | None, typer.Option(help="Turns at most.")] = None,
) -> None:
    """Play the student: read what the teacher says, type actions. Or play the teacher: choose what is said.

    End a text of several lines with an empty line. Ctrl-D leaves.
    """
    if seat not in ("student", "teacher"):
        raise ValueError(f"seat {seat!r} is unknown; allowed: student, teacher")
    settings = {"instruction_type": instruction_type, "feedback_type": feedback_type, "max_turns": max_turns}
    console = Console(highlight=False)
    try:
        if seat == "student":
            _learn(console, id, seed, teacher=teacher, **settings)
        else:
            _teach(console, id, seed, teacher=teacher, student=student, budget=budget, **settings)
    except (EOFError, KeyboardInterrupt):
        console.print("\nYou left the episode.")


def _learn(console: Console, id: str, seed: int | None, **settings: Any) -> None:
    """An episode in the student's seat."""
    import llf_teacher

    env = llf_teacher.make(id, text=True, **settings)
    several_lines = env.aec.world.several_lines
    hint = " (an empty line ends it)" if several_lines else ""
    observation, _ = env.reset(seed=seed)
    total, turn, done = 0.0, 0, False
    while True:
        for key, style in (("instruction", "bold"), ("observation", "cyan"), ("feedback", "green")):
            if observation[key]:
                console.print(f"[{style}]{_shown(observation[key])}[/]\n")
        if done:
            break
        turn += 1
        action = _ask(console, f"Turn {turn}{hint}> ", several_lines)
        observation, reward, terminated, truncated, info = env.step(action)
        total += reward
        done = terminated or truncated or (info["success"] and not env.family.repeated)
    _sum_up(console, turn, info["success"], total)


def _teach(console: Console, id: str, seed: int | None, **settings: Any) -> None:
    """An episode in the teacher's seat."""
    import llf_teacher

    env = llf_teacher.TeacherEnv(id, until_success=True, **settings)
    aec, seat = env.aec, env.aec.seat
    env.reset(seed=seed)
    console.print(f"[bold]{_shown(aec.instruction)}[/]\n")
    total, done = 0.0, False
    while not done:
        told = aec.describe()
        if told["action"]:
            console.print(f"The student did: [bold]{_shown(told['action'])}[/]")
        console.print(f"[cyan]{_shown(told['state'])}[/]\n")
        subset = _choose(console, seat)
        _, reward, terminated, truncated, _ = env.step(subset)
        console.print(f"[green]{_shown(aec.feedback)}[/]\n")
        total += reward
        done = terminated or truncated
    _sum_up(console, aec.turn, aec.moment.success, total)


def _sum_up(console: Console, turns: int, success: bool, total: float) -> None:
    solved = "solved" if success else "not solved"
    console.print(f"Over after {turns} turns: {solved}, total reward {total:.4g}.")


def _choose(console: Console, seat: "TeacherSeat") -> int:
    """The subset of the kinds that a person types, asked until it is one; none once the budget is spent."""
    purse = seat.purse
    if not purse.left:
        console.input(f"Your budget of {purse.budget} is spent, so that you can say nothing more. Enter to go on> ")
        return 0
    for claim in seat.claims():
        if claim.kind is not None:
            console.print(f"  {claim.kind:2} {_shown(_worded(claim, seat))}", soft_wrap=True)
    left = "" if purse.budget is None else f"; {purse.left} of {purse.budget} left"
    prompt = f"Say which kinds of {', '.join(KINDS)}? (a: all, empty: none{left})> "
    while True:
        words = console.input(prompt).replace("+", " ").replace(",", " ").split()
        try:
            kinds = parse_kinds("a" if words == ["a"] else words)
        except ValueError as error:
            console.print(_shown(str(error)))
            continue
        return sum(1 << i for i, kind in enumerate(KINDS) if kind in kinds)


def _worded(claim: "Claim[Any]", seat: "TeacherSeat") -> str:
    """A claim in the first of its paraphrases; which one is said is drawn when it is."""
    import numpy as np

    from teachers.phrasebook import Draws

    return seat.teacher.voice.say((claim,), seat.moment.turn, Draws(np.random.default_rng(0)), 0)


def _ask(console: Console, prompt: str, several_lines: bool) -> str:
    lines = [console.input(prompt)]
    while several_lines and lines[-1].strip():
        lines.append(input())
    return "\n".join(lines)


def _shown(text: str) -> str:
    """Text that Rich prints as it is."""
    return escape(visible(text))
