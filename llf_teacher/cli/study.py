"""`llf study`: run feedback studies and report on them."""

import os
import signal
import sys
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.progress import Progress
from typer.core import TyperGroup

from llf_teacher.cli import errors, say_missing
from llf_teacher.escaping import escape_control_chars
from llf_teacher.models.settings import BUDGET
from llf_teacher.studies import commands

if TYPE_CHECKING:
    from collections.abc import Mapping

    from llf_teacher.studies.definition.study import Study
    from llf_teacher.studies.execution.runner import RunOptions

STORE, REPORT = Path("llf-study.db"), Path("llf-study.html")

Store_ = Annotated[
    Path, typer.Option("--store", help="SQLite file that holds the episodes; an interrupted study goes on.")
]
Report_ = Annotated[Path, typer.Option("--report", help="HTML file to write.")]
Workers_ = Annotated[int | None, typer.Option("--workers", min=1, help="Parallel processes; one a core by default.")]


class _Files(TyperGroup):
    """Takes a study's file for `run` with that file."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command that is meant."""
        named = args[0] in self.commands or not args[0].endswith(".toml")
        return super().resolve_command(ctx, args if named else ["run", *args])


def add_to(app: typer.Typer) -> None:
    """Add the command with its subcommand."""
    group = typer.Typer(
        help="Run a feedback study: `llf study FILE.toml`; without a file or a subcommand the built-in quickstart.",
        cls=_Files,
        invoke_without_command=True,
    )
    group.callback()(quickstart)
    group.command("run")(run)
    group.command("report")(report)
    group.command("check")(check)
    group.command("migrate")(migrate)
    group.command("export")(export)
    group.command("power")(power)
    group.command("merge")(merge)
    commands.add_to(group)
    app.add_typer(group, name="study")


def quickstart(
    context: typer.Context, store: Store_ = STORE, report: Report_ = REPORT, workers: Workers_ = None
) -> None:
    """Run the built-in quickstart study: every family, controls and some personalities."""
    if context.invoked_subcommand is None:
        from llf_teacher.studies.definition import study
        from llf_teacher.studies.execution.runner import RunOptions

        say_missing()
        _run(study.quickstart(), store, report, workers, {}, RunOptions())


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
    episode_seconds: Annotated[
        float | None, typer.Option("--episode-seconds", help="An episode that takes longer has failed.")
    ] = None,
    turn_seconds: Annotated[
        float | None, typer.Option("--turn-seconds", help="An episode of which a turn takes longer has failed.")
    ] = None,
    memory: Annotated[
        int | None, typer.Option("--memory", help="An episode that needs more megabytes in its process has failed.")
    ] = None,
    retry_failed: Annotated[
        bool, typer.Option("--retry-failed", help="Play episodes again that failed in an earlier run.")
    ] = False,
    fail_fast: Annotated[
        bool, typer.Option("--fail-fast", help="Begin no more episodes after one that failed.")
    ] = False,
    executor: Annotated[
        str,
        typer.Option(
            "--executor",
            help="What plays: processes, threads (many that wait for a network), here (in this process) or ray.",
        ),
    ] = "processes",
    address: Annotated[
        str | None, typer.Option("--address", help="Where Ray's cluster is; without it one is begun on this machine.")
    ] = None,
    shard: Annotated[
        str, typer.Option("--shard", help="Part of the episodes, as 3/8; `llf study merge` puts stores together.")
    ] = "1/1",
) -> None:
    """Run the study that FILE describes, or what is left of it, and write its report.

    Episodes that fail are noted, the rest goes on, and the exit status is 3.
    """
    from llf_teacher.studies.definition.study import load_study
    from llf_teacher.studies.execution.limits import Limits
    from llf_teacher.studies.execution.runner import RunOptions, parse_shard

    if os.getcwd() not in sys.path:  # where students `module:factory` are looked for, as with `python -m`
        sys.path.append(os.getcwd())
    limits = Limits(episode_seconds, turn_seconds, memory)
    options = RunOptions(executor, address, limits, parse_shard(shard), retry_failed, fail_fast)
    _run(load_study(file), store, report, workers, {} if llm_budget is None else {BUDGET: f"{llm_budget}"}, options)


def report(
    file: Annotated[
        Path | None, typer.Argument(help="TOML file of the study; without it, the one that the store was made for.")
    ] = None,
    store: Store_ = STORE,
    report: Report_ = REPORT,
) -> None:
    """Write the report of what a store has of a study, which may still be running, or have been stopped."""
    from llf_teacher.studies.definition.study import Study, load_study
    from llf_teacher.studies.report import write_report
    from llf_teacher.studies.store import Store, StoreError

    if not store.is_file():
        raise StoreError(f"there is no file {store}; `llf study run` makes stores, and --store names one")
    with Store(store) as opened:
        if file is None and "study" not in opened.manifest():
            raise StoreError(f"{store} does not say which study it was made for; give the study's file, too")
        write_report(opened, Study(**opened.manifest()["study"]) if file is None else load_study(file), report)
    Console(stderr=True, markup=False).print(f"Report: {report.resolve()}")


def check(file: Annotated[Path, typer.Argument(help="Store of a study.", exists=True, dir_okay=False)]) -> None:
    """Check that every episode of a store is as it was written; name what is not, with exit status 1."""
    from llf_teacher.studies.store import Store

    with Store(file) as store:
        found = [f"{file}, row {number}: {problem}" for number, problem in store.damage(thorough=True)]
        for line in found:
            errors.print(escape_control_chars(line))
        if found:
            raise typer.Exit(1)
        typer.echo(f"{store.count} episodes, all as they were written.")


def migrate(
    old: Annotated[Path, typer.Argument(help="Store of an earlier release; it is only read.")],
    new: Annotated[Path, typer.Argument(help="Store to write.")],
) -> None:
    """Write the episodes of an earlier release's store into one of this release."""
    from llf_teacher.studies.store import migration

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
        typer.Option(
            "--format", help="Not a table, but data to train on: chat, sft, dpo, sdpo, minari, eee, with options."
        ),
    ] = "",
) -> None:
    """Write the episodes of a store, or their turns, as a table for other programs, or as data to train on."""
    from llf_teacher.studies import load

    if format:
        from llf_teacher.studies.export import write_export

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
    from llf_teacher.studies.analysis.outcomes import outcomes
    from llf_teacher.studies.analysis.power import needs
    from llf_teacher.studies.definition.design import BASELINE

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


def merge(
    into: Annotated[Path, typer.Argument(help="Store to write.")],
    parts: Annotated[list[Path], typer.Argument(help="Stores of the parts; they are only read.")],
) -> None:
    """Put the stores of a study's shards together into one."""
    from llf_teacher.studies.store import merging

    with Progress(console=Console(stderr=True, markup=False), transient=True) as progress:
        task = progress.add_task("episodes", total=None)
        number = merging.merge(into, parts, lambda done, total: progress.update(task, completed=done, total=total))
    typer.echo(f"{number} episodes, stored in {into}.")


class _Terminated(KeyboardInterrupt):
    """SIGTERM came."""


def _terminate(number: int, frame: FrameType | None) -> None:
    raise _Terminated


def _run(
    study: "Study",
    path: Path,
    report: Path,
    workers: int | None,
    environment: "Mapping[str, str]",
    options: "RunOptions",
) -> None:
    from llf_teacher.studies.analysis import costs
    from llf_teacher.studies.execution.progress import StudyProgress
    from llf_teacher.studies.execution.runner import EpisodeError, StudyError
    from llf_teacher.studies.execution.runner import run as play
    from llf_teacher.studies.report import check_writable, write_report
    from llf_teacher.studies.store import Store

    console = Console(stderr=True, markup=False)
    check_writable(report)
    signal.signal(signal.SIGTERM, _terminate)
    status = 0
    with Store(path) as store:
        try:
            with StudyProgress(console) as progress:
                show = lambda decision: console.print(f"{decision}")  # noqa: E731 (of one call)
                played = play(study, store, workers, progress, environment, options, show)
        except EpisodeError as error:
            errors.print(escape_control_chars(f"{error.trace}llf: {error}"))
            if isinstance(error, StudyError) or options.fail_fast:
                if store.count:
                    errors.print(f"What was played is in {path}; the same command goes on from there.")
                raise typer.Exit(3 if options.fail_fast and not isinstance(error, StudyError) else 1) from None
            errors.print("The same command with --retry-failed plays again what failed.")
            status, played = 3, error.played
        except KeyboardInterrupt as error:
            what, status = ("Terminated", 143) if isinstance(error, _Terminated) else ("Interrupted", 130)
            errors.print(f"{what}. What was played is in {path}; the same command goes on from there.")
            raise typer.Exit(status) from None
        for line in costs.cost_lines(store):
            console.print(line)
        console.print(f"Played {played} episodes, stored in {path}.")
        if store.count:
            console.print("Writing the report ...")
            for student in write_report(store, study, report).unreadable:
                errors.print(
                    escape_control_chars(
                        f"warning: no answer of {student} could be read as an action; see a transcript"
                    )
                )
            console.print(f"Report: {report.resolve()}")
    raise typer.Exit(status)
