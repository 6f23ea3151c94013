"""`llf suite`: what a student can do with feedback, as a card."""

import os
import shlex
import sys
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.table import Table

from llf_teacher.cli import Advanced, Commands, complete_student, errors, help_shows, search_here
from llf_teacher.escaping import escape_control_chars
from llf_teacher.models.settings import BUDGET

if TYPE_CHECKING:
    from llf_teacher.suite.card import AbilityLine, Card

STORE = Path("llf-suite.db")


def add_to(app: typer.Typer) -> None:
    """Add the group and its commands."""
    group = typer.Typer(
        help="Measure what a student can do with feedback: `llf suite --student obedient` writes a card of scores.",
        cls=Commands,
        invoke_without_command=True,
    )
    group.callback()(suite)
    group.command("compare")(compare_cards)
    group.command("check")(check_cards)
    app.add_typer(group, name="suite")


@help_shows("student", "card", "quick", "store", "workers")
def suite(
    context: typer.Context,
    student: Annotated[
        str | None,
        typer.Option(
            help="Student, such as obedient, or `module:factory` of your agent.", autocompletion=complete_student
        ),
    ] = None,
    card: Annotated[
        list[Path] | None, typer.Option(help="File to write: .json, .md, .svg or .html; repeat it for several.")
    ] = None,
    only: Annotated[list[str] | None, typer.Option(help="Experiment to play; repeat it for several.")] = None,
    quick: Annotated[
        bool,
        typer.Option("--quick", help="Play only four experiments, in fewer worlds, within 20 minutes."),
    ] = False,
    key: Annotated[str, typer.Option(help="Text from which other seeds are drawn.")] = "",
    store: Annotated[Path, typer.Option(help="SQLite file for the episodes; an interrupted suite is resumed.")] = STORE,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Parallel processes; by default one for each core.")
    ] = None,
    llm_budget: Annotated[
        float | None,
        typer.Option(
            min=0, envvar=BUDGET, help="Most USD that a model may cost for this store, earlier runs included."
        ),
    ] = None,
    turn_seconds: Annotated[
        float | None, typer.Option(min=0.001, help="Seconds of a turn, after which an agent that hangs has failed.")
    ] = None,
    replay_changed: Annotated[
        bool, typer.Option("--replay-changed", help="Play again the episodes whose student has changed since.")
    ] = False,
    keep_old: Annotated[
        bool, typer.Option("--keep-old", help="Keep these episodes, and mark the card; without either the run stops.")
    ] = False,
    _advanced: Advanced = False,
) -> None:
    """Measure what a student does with feedback, one ability an experiment.

    A score is 0 if the student takes no notice of the feedback, and 1 if it gains as much as a scripted student. The
    exit status is 3 if episodes fail, and 1 if nothing was measured, for example since no answer was an action.
    """
    if context.invoked_subcommand is not None:
        return
    if student is None:
        raise typer.BadParameter("give --student, such as --student obedient, or the command check or compare")
    from llf_teacher.studies.definition.own_code import unseen
    from llf_teacher.studies.execution.changes import choice_of
    from llf_teacher.studies.execution.progress import StudyProgress
    from llf_teacher.studies.execution.runner import StudyError
    from llf_teacher.suite import take
    from llf_teacher.suite.card import check_file
    from llf_teacher.suite.estimate import estimate
    from llf_teacher.suite.taking import Outlook, actions_of

    search_here()
    changed = choice_of(replay_changed, keep_old)
    command = escape_control_chars(shlex.join(["llf", *sys.argv[1:]]))
    if llm_budget is not None:
        os.environ[BUDGET] = f"{llm_budget}"
    for path in card or ():
        check_file(path)
    console = Console(emoji=False, stderr=True, markup=False)
    console.print(
        f"The student plays {estimate(student, only or (), quick, key)}; those in {store} are not played again."
    )
    console.print("Scripted students, with which it is compared, play as well. The first episodes measure the speed.")
    for id, syntax in actions_of(only or (), quick).items():
        console.print(f"An answer in {id} is {syntax}.", highlight=False)
    for said in unseen([student]) if store.exists() else ():
        console.print(escape_control_chars(said), highlight=False)
    with StudyProgress(console, measured=True) as progress, warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=r"\d+ of \d+ episodes failed")  # the card gives the reason

        def announce(outlook: Outlook) -> None:
            console.print(f"{outlook}", highlight=False)
            console.print(f"Ctrl-C ends it; the same command goes on: {command}", highlight=False, soft_wrap=True)

        try:
            found = take(student, store, only or (), quick, key, workers, progress, turn_seconds, announce, changed)
        except StudyError as error:
            errors.print(escape_control_chars(f"{error.trace}llf: {error}"))
            errors.print(f"The episodes so far are in {store}; the next run goes on from there.")
            raise typer.Exit(1) from None
        except KeyboardInterrupt:
            errors.print(f"Interrupted. The episodes so far are in {store}; the same command goes on:")
            errors.print(command, soft_wrap=True)
            raise
    for path in card or ():
        found.write(path)
        console.print(f"Card: {path.resolve()}")
    result = Console(emoji=False, markup=False, highlight=False)
    measured = any(line.score is not None for line in found.lines)
    _print_lines(found, store, result)
    if measured:
        heads, *rows = ([escape_control_chars(cell) for cell in row[:-1]] for row in found.table())
        table = Table(*heads, title=escape_control_chars(found.student), caption=found.explained)
        for row in rows:
            table.add_row(*row)
        result.print(table)
    for sentence in found.sentences():
        result.print(escape_control_chars(f"- {sentence}"))
    result.print(found.settings())
    if found.failures:
        raise typer.Exit(3)
    if not measured:
        raise typer.Exit(1)


def _print_lines(card: "Card", store: Path, result: Console) -> None:
    """Print what the student did in each experiment; what was not measured for the same reason stands in one line."""
    by_reason: dict[str, list[AbilityLine]] = {}
    for line in card.lines:
        by_reason.setdefault(line.name if line.score is not None else line.why, []).append(line)
    for line, *others in by_reason.values():
        names = ", ".join(each.name for each in (line, *others))
        alone = f"{line.asked} {line.did} ({line.measured}.) {line.answered}"
        result.print(escape_control_chars(f"{names}: {line.did if others else alone}"))
        if line.answers.episode:
            read = shlex.join(["llf", "study", "transcript", f"{store}", line.answers.episode[:12]])
            result.print(escape_control_chars(f"  an episode: {read}"), soft_wrap=True)


Card_ = Annotated[Path, typer.Argument(help="JSON file of a card.", exists=True, dir_okay=False)]


def compare_cards(first: Card_, second: Card_) -> None:
    """Compare two cards: the second one's scores minus the first one's, each with its interval and test."""
    from llf_teacher.suite import check, compare

    table = Table("ability", "difference", "p", title=escape_control_chars(f"{second} less {first}"))
    for each in compare(first, second):
        table.add_row(each.ability, escape_control_chars(each.words), each.chance)
    result = Console(emoji=False, markup=False)
    result.print(table)
    for path in (first, second):
        card = check(path)
        result.print(escape_control_chars(f"{path}: {card.student}; {card.settings()}"))


def check_cards(
    files: Annotated[list[Path], typer.Argument(metavar="FILE", help="JSON files of cards.", exists=True)],
) -> None:
    """Check that cards are complete, unchanged, and of this version of the suite."""
    from llf_teacher.suite import check

    for path in files:
        card = check(path)
        typer.echo(f"{path}: a card of {card.suite} ({card.digest}) of {escape_control_chars(card.student)}.")
