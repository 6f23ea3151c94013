"""`llf study`: run feedback studies and report on them."""

import os
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from llf_teacher.cli import errors, say_missing
from llf_teacher.models.settings import BUDGET
from llf_teacher.visible import visible

if TYPE_CHECKING:
    from collections.abc import Mapping

    from llf_teacher.studies.study import Study

STORE, REPORT = Path("llf-study.db"), Path("llf-study.html")

Store_ = Annotated[
    Path, typer.Option("--store", help="SQLite file that holds the episodes; an interrupted study goes on.")
]
Report_ = Annotated[Path, typer.Option("--report", help="HTML file to write.")]
Workers_ = Annotated[int | None, typer.Option("--workers", min=1, help="Parallel processes; one a core by default.")]


def add_to(app: typer.Typer) -> None:
    """Add the command with its subcommand."""
    group = typer.Typer(
        help="Run a feedback study; without a subcommand the built-in quickstart.", invoke_without_command=True
    )
    group.callback()(quickstart)
    group.command("run")(run)
    group.command("check")(check)
    group.command("migrate")(migrate)
    group.command("export")(export)
    group.command("power")(power)
    app.add_typer(group, name="study")


def quickstart(
    context: typer.Context, store: Store_ = STORE, report: Report_ = REPORT, workers: Workers_ = None
) -> None:
    """Run the built-in quickstart study: every family, controls and some personalities."""
    if context.invoked_subcommand is None:
        from llf_teacher.studies import study

        say_missing()
        _run(study.quickstart(), store, report, workers)


def run(
    file: Annotated[Path, typer.Argument(help="TOML file that describes the study.")],
    store: Store_ = STORE,
    report: Report_ = REPORT,
    workers: Workers_ = None,
    llm_budget: Annotated[
        float | None,
        typer.Option(
            "--llm-budget",
            min=0,
            envvar=BUDGET,
            help="USD that LLM students may spend on this store, earlier runs included.",
        ),
    ] = None,
) -> None:
    """Run the study that FILE describes, or what is left of it, and write its report."""
    from llf_teacher.studies.study import load_study

    if os.getcwd() not in sys.path:  # where students `module:factory` are looked for, as with `python -m`
        sys.path.append(os.getcwd())
    _run(load_study(file), store, report, workers, {} if llm_budget is None else {BUDGET: f"{llm_budget}"})


def check(file: Annotated[Path, typer.Argument(help="Store of a study.", exists=True, dir_okay=False)]) -> None:
    """Check that every episode of a store is as it was written; name what is not, with exit status 1."""
    from llf_teacher.studies.store import Store

    with Store(file) as store:
        found = [f"{file}, row {number}: {problem}" for number, problem in store.damage(thorough=True)]
        for line in found:
            errors.print(visible(line))
        if found:
            raise typer.Exit(1)
        typer.echo(f"{len(store.keys())} episodes, all as they were written.")


def migrate(
    old: Annotated[Path, typer.Argument(help="Store of an earlier release; it is only read.")],
    new: Annotated[Path, typer.Argument(help="Store to write.")],
) -> None:
    """Write the episodes of an earlier release's store into one of this release."""
    from llf_teacher.studies import migration

    with Progress(console=Console(stderr=True, markup=False), transient=True) as progress:
        task = progress.add_task("episodes", total=None)
        number = migration.migrate(old, new, lambda done, total: progress.update(task, completed=done, total=total))
    typer.echo(f"{number} episodes, stored in {new}.")


def export(
    store: Annotated[Path, typer.Argument(help="Store of a study.")],
    file: Annotated[Path, typer.Argument(help="File to write: .csv, .jsonl or .parquet; of some formats a folder.")],
    turns: Annotated[bool, typer.Option("--turns", help="A row a turn, in place of one an episode.")] = False,
    format: Annotated[
        str,
        typer.Option("--format", help="Not a table, but data to train on: chat, sft, dpo, minari, eee, with options."),
    ] = "",
) -> None:
    """Write the episodes of a store, or their turns, as a table for other programs, or as data to train on."""
    from llf_teacher.studies import load

    if format:
        from llf_teacher.studies.exports import write_export

        if turns:
            raise typer.BadParameter("--turns is for tables; leave it out, or leave out --format")
        number = write_export(load(store), file, format)
        typer.echo(f"{number} written in the format {format}, stored in {file}.")
        return
    rows = load(store).export(file, "turns" if turns else "episodes")
    typer.echo(f"{rows} rows, stored in {file}.")


def power(
    pilot: Annotated[Path, typer.Argument(help="Store of a pilot, which has a few seeds of the study.")],
    effect: Annotated[
        float, typer.Option("--effect", min=0.001, max=10, help="Least difference from the baseline that matters.")
    ],
    of: Annotated[
        str,
        typer.Option("--of", help="A share of what: `gain`, of the baseline's regret, or `success`, of episodes."),
    ] = "gain",
    chance: Annotated[float, typer.Option("--power", min=0.5, max=0.999, help="Chance to find it.")] = 0.8,
    baseline: Annotated[str | None, typer.Option("--baseline", help="Teacher to compare with; the pilot's.")] = None,
) -> None:
    """Say how many seeds a study needs to find an effect, from a pilot's paired differences."""
    from llf_teacher.studies import load
    from llf_teacher.studies.design import BASELINE
    from llf_teacher.studies.outcomes import outcomes
    from llf_teacher.studies.power import needs

    results = load(pilot)
    against = baseline or results.manifest.get("study", {}).get("baseline", BASELINE)
    found = sorted(needs(outcomes(results.rows()), against, effect, of, chance), key=lambda need: -need.safe)
    if not found:
        raise ValueError(
            f"{pilot} has no two seeds of a student whom teachers can reach with {against!r} and with another teacher; "
            "play some, or name another teacher by --baseline"
        )
    head = ("family", "types", "teacher", "student", "pilot", "spread", "seeds", "to be safe")
    rows = [
        (
            n.family,
            f"{n.instruction_type}, {n.feedback_type}",
            n.teacher,
            n.student,
            f"{n.pairs}",
            f"{n.spread:.3f}",
            f"{n.seeds}",
            f"{n.safe}",
        )
        for n in found
    ]
    widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
    for row in (head, *rows):
        typer.echo("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip())
    typer.echo(
        f"An effect of {effect:g} against {against} is found with a chance of {chance:g} by "
        f"{max(need.seeds for need in found)} seeds, to be safe {found[0].safe}, in every comparison."
    )


def _run(
    study: "Study", path: Path, report: Path, workers: int | None, environment: "Mapping[str, str] | None" = None
) -> None:
    from llf_teacher.studies import costs
    from llf_teacher.studies.report import check_writable, write_report
    from llf_teacher.studies.runner import EpisodeError
    from llf_teacher.studies.runner import run as play
    from llf_teacher.studies.store import Store

    console = Console(stderr=True, markup=False)
    check_writable(report)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    progress = Progress(*columns, console=console)
    task = progress.add_task("episodes", total=None)
    with Store(path) as store:
        try:
            with ExitStack() as shown:

                def show(done: int, total: int) -> None:
                    if not progress.live.is_started:  # nothing is shown of a study that cannot start
                        shown.enter_context(progress)
                    progress.update(task, completed=done, total=total)

                played = play(study, store, workers, show, environment)
        except EpisodeError as error:
            errors.print(visible(f"{error.trace}llf: {error}"))
            if store.keys():
                errors.print(f"What was played is in {path}; the same command goes on from there.")
            raise typer.Exit(1) from None
        except KeyboardInterrupt:
            console.print(f"Interrupted. What was played is in {path}; the same command goes on from there.")
            raise typer.Exit(130) from None
        for line in costs.told(store):
            console.print(line)
        console.print(f"Played {played} episodes, stored in {path}. Writing the report ...")
        write_report(store, study, report)
    console.print(f"Report: {report.resolve()}")
