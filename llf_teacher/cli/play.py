"""`llf play`: a person plays the student or the teacher in the terminal."""

import secrets
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.text import Text

from llf_teacher.cli import complete_id, complete_student, complete_teacher
from llf_teacher.escaping import escape_control_chars
from teachers.atoms import KINDS
from teachers.feedback import parse_kinds

if TYPE_CHECKING:
    from llf_teacher.gym import StudentEnv, TeacherEnv
    from pz_envs.teacher_seat import TeacherSeat
    from teachers.atoms import Claim

UNDO = "undo"
"""What one types to take a turn back."""
_STYLES = {
    "here": "bold blue",
    "goal": "bold yellow",
    "good": "green",
    "bad": "red",
    "muted": "dim",
    "action": "bold",
    "r": "bold magenta",
    "hp": "bold green",
    "hn": "bold red",
    "fp": "bold blue",
    "fn": "bold yellow",
}
"""Per role of a piece of text, and per kind of feedback, how it looks in a terminal that has colours."""


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("play")(play)


def play(
    id: Annotated[str, typer.Argument(help="Environment; `llf list` shows them.", autocompletion=complete_id)],
    seat: Annotated[str, typer.Option(help="Your seat: student or teacher.")] = "student",
    teacher: Annotated[
        str,
        typer.Option(
            help="Personality spec of the teacher; of your claims in its seat.", autocompletion=complete_teacher
        ),
    ] = "oracle",
    student: Annotated[
        str, typer.Option(help="Spec of the student whom you teach.", autocompletion=complete_student)
    ] = "obedient",
    instruction_type: Annotated[str, typer.Option(help="b, p or c.")] = "b",
    feedback_type: Annotated[str, typer.Option(help="a, n, m, or kinds such as r+hp.")] = "a",
    budget: Annotated[int | None, typer.Option(help="Claims that you may make as the teacher.")] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of the episode.")] = None,
    max_turns: Annotated[int | None, typer.Option(help="Turns at most.")] = None,
) -> None:
    """Play the student: read what the teacher says, type actions. Or play the teacher: choose what is said.

    `undo` takes a turn back, an empty line does nothing; it ends a text of several lines. Ctrl-D leaves. There are no
    colours where NO_COLOR is set.
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


class _Sitting:
    """An episode in one seat, whose turns can be taken back: it is played again up to there.

    Args:
        env: a seat, which can be shown as text.
        seed: of the episode; None: any.
        ends: whether success ends it.
    """

    def __init__(self, env: "StudentEnv | TeacherEnv", seed: int | None, ends: bool) -> None:
        self.env, self.ends = env, ends
        self.seed = secrets.randbelow(2**31) if seed is None else seed
        self.begin()

    def begin(self) -> None:
        """From the opening on."""
        self.env.reset(seed=self.seed)
        self.moves: list[Any] = []
        self.total, self.over = 0.0, False

    def move(self, action: Any) -> None:
        """One turn in the seat."""
        _, reward, terminated, truncated, _ = self.env.step(action)
        self.moves.append(action)
        self.total += float(reward)
        self.over = terminated or truncated or (self.ends and self.env.aec.moment.success)

    def undo(self) -> bool:
        """Take the last turn back; whether there was one."""
        *moves, _ = self.moves or [None]
        if not self.moves:
            return False
        self.begin()
        for action in moves:
            self.move(action)
        return True


def _learn(console: Console, id: str, seed: int | None, **settings: Any) -> None:
    """An episode in the student's seat."""
    import llf_teacher

    env = llf_teacher.make(id, text=True, render_mode="ansi", **settings)
    sitting = _Sitting(env, seed, not env.family.repeated)
    several_lines = env.aec.world.several_lines
    hint = " (an empty line ends it)" if several_lines else ""
    _greet(console, sitting)
    while True:
        _show(console, env)
        _say(console, env)
        if sitting.over:
            break
        action = ""
        while not action.strip():
            action = _ask(console, f"Turn {env.aec.turn + 1}{hint}> ", several_lines)
        if action.strip().lower() == UNDO:
            _take_back(console, sitting)
        else:
            sitting.move(action)
    _sum_up(console, env.aec.turn, env.aec.moment.success, sitting.total)


def _teach(console: Console, id: str, seed: int | None, **settings: Any) -> None:
    """An episode in the teacher's seat, which sees the truth."""
    import llf_teacher

    env = llf_teacher.TeacherEnv(id, until_success=True, render_mode="ansi", privileged_info=True, **settings)
    sitting = _Sitting(env, seed, False)
    _greet(console, sitting)
    _put(console, Text(escape_control_chars(env.aec.instruction), "bold"))
    while not sitting.over:
        _show(console, env)
        subset = _choose(console, env.aec.seat)
        if subset is None:
            _take_back(console, sitting)
            continue
        sitting.move(subset)
        _put(console, Text(escape_control_chars(env.aec.feedback), "green"))
    _sum_up(console, env.aec.turn, env.aec.moment.success, sitting.total)


def _greet(console: Console, sitting: _Sitting) -> None:
    _put(console, Text(f"Seed {sitting.seed}. Type {UNDO} to take a turn back, Ctrl-D to leave.", "dim"))


def _put(console: Console, text: Text, **settings: Any) -> None:
    """Text and an empty line."""
    console.print(text, **settings)
    console.print()


def _show(console: Console, env: "StudentEnv | TeacherEnv") -> None:
    """The turn, what the student did, and the world."""
    shown = Text()
    for piece, role in env.aec.pieces():
        shown.append(escape_control_chars(piece), _STYLES.get(role, ""))
    shown.rstrip()
    _put(console, shown, soft_wrap=True)


def _say(console: Console, env: "StudentEnv") -> None:
    """What the teacher said, each sentence with its kind."""
    for sentence in env.aec.watch.sentences:
        kind = sentence.kind or ""
        style = _STYLES.get(kind, "bold")
        console.print(Text(f"{kind:2} ", style).append(escape_control_chars(sentence.text), "" if kind else "bold"))
    console.print()


def _take_back(console: Console, sitting: _Sitting) -> None:
    done = sitting.undo()
    _put(console, Text("The last turn is taken back." if done else "There is no turn to take back."))


def _sum_up(console: Console, turns: int, success: bool, total: float) -> None:
    solved = "solved" if success else "not solved"
    console.print(f"Over after {turns} turns: {solved}, total reward {total:.4g}.")


def _choose(console: Console, seat: "TeacherSeat") -> int | None:
    """The subset of the kinds that a person types, asked until it is one, none once the budget is spent; None: undo."""
    purse = seat.purse
    if not purse.left:
        spent = f"Your budget of {purse.budget} is spent, so that you can say nothing more. Enter to go on> "
        return None if console.input(spent).strip().lower() == UNDO else 0
    for claim in seat.claims():
        if claim.kind is not None:
            said = escape_control_chars(_worded(claim, seat))
            line = Text("  ").append(f"{claim.kind:2}", _STYLES[claim.kind]).append(f" {said}")
            console.print(line, soft_wrap=True)
    left = "" if purse.budget is None else f"; {purse.left} of {purse.budget} left"
    prompt = f"Say which kinds of {', '.join(KINDS)}? (a: all, empty: none{left})> "
    while True:
        words = console.input(prompt).lower().replace("+", " ").replace(",", " ").split()
        if words == [UNDO]:
            return None
        try:
            kinds = parse_kinds("a" if words == ["a"] else words)
        except ValueError as error:
            console.print(Text(escape_control_chars(f"{error}")))
            continue
        return sum(1 << i for i, kind in enumerate(KINDS) if kind in kinds)


def _worded(claim: "Claim[Any]", seat: "TeacherSeat") -> str:
    """A claim in the first of its paraphrases; which one is said is drawn when it is."""
    import numpy as np

    from teachers.phrasebook import Draws

    return seat.teacher.voice.say((claim,), seat.moment.turn, Draws(np.random.default_rng(0)), 0)


def _ask(console: Console, prompt: str, several_lines: bool) -> str:
    lines = [console.input(prompt)]
    if lines[0].strip().lower() == UNDO:
        return UNDO
    while several_lines and lines[-1].strip():
        lines.append(input())
    return "\n".join(lines)
