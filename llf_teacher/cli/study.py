"""`llf study`: run feedback studies and report on them."""

import signal
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from llf_teacher.cli import Advanced, Commands, errors, help_shows, print_missing, search_here
from llf_teacher.escaping import escape_control_chars
from llf_teacher.models.settings import BUDGET
from llf_teacher.studies import commands

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from llf_teacher.studies.definition.study import Study
    from llf_teacher.studies.execution.runner import RunOptions
    from llf_teacher.studies.report.data import Data

_SHOWN = 8  # comparisons in the terminal

Store_ = Annotated[
    Path | None,
    typer.Option(
        "--store",
        help="SQLite file for the episodes, from which an interrupted study is resumed; by default named after the "
        "study's file, in the working directory.",
        show_default=False,
    ),
]
Report_ = Annotated[
    Path | None,
    typer.Option("--report", help="HTML file to write; by default named after the study's file.", show_default=False),
]
Shared_ = Annotated[
    bool, typer.Option("--shared", help="Use a store and replace a report that another study has made.")
]
Workers_ = Annotated[
    int | None, typer.Option("--workers", min=1, help="Parallel processes; by default one for each core.")
]


class _StudyCommands(Commands):
    """Treats `llf study FILE.toml` as `llf study run FILE.toml`."""

    def parse_args(self, ctx: Any, args: list[str]) -> Any:
        """Read the arguments; with a TOML file before any command all of them, in any order, are those of `run`."""
        first = next((each for each in args if each in self.commands or each.endswith(".toml")), "")
        return super().parse_args(ctx, ["run", *args] if first.endswith(".toml") else args)

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """The help of the group, and that of `run`, whose options `llf study FILE.toml` takes."""
        super().format_help(ctx, formatter)
        run = self.get_command(ctx, "run")
        with ctx.command.context_class(run, info_name="run", parent=ctx) as below:
            typer.echo("`llf study FILE.toml` is short for `llf study run FILE.toml`:")
            run.format_help(below, formatter)


def add_to(app: typer.Typer) -> None:
    """Add the group and its commands."""
    group = typer.Typer(
        help="Run a study: `llf study FILE.toml` runs the one in a file, `llf study` a built-in one.",
        cls=_StudyCommands,
        invoke_without_command=True,
    )
    group.callback()(quickstart)
    group.command("run")(run)
    group.command("report")(report)
    group.command("check")(check)
    group.command("archive")(archive)
    group.command("export")(export)
    group.command("power")(power)
    group.command("merge")(merge)
    group.command("rescue")(rescue)
    commands.add_to(group)
    app.add_typer(group, name="study")


def quickstart(
    context: typer.Context,
    store: Store_ = None,
    report: Report_ = None,
    workers: Workers_ = None,
    shared: Shared_ = False,
) -> None:
    """Run the built-in study of all families, which asks whether late or wrong words cost a student more."""
    search_here()  # for students `module:factory`, also those of a store
    if context.invoked_subcommand is None:
        from llf_teacher.studies.definition import study
        from llf_teacher.studies.execution.runner import RunOptions

        print_missing()
        _run(study.quickstart(), None, store, report, workers, {}, RunOptions(), shared)


@help_shows("store", "report", "workers", "llm_budget", "retry_failed")
def run(
    file: Annotated[Path, typer.Argument(help="TOML file of the study.")],
    store: Store_ = None,
    report: Report_ = None,
    workers: Workers_ = None,
    llm_budget: Annotated[
        float | None,
        typer.Option(
            "--llm-budget",
            min=0,
            envvar=BUDGET,
            help="Most USD that language models may cost for this store, earlier runs included.",
        ),
    ] = None,
    episode_seconds: Annotated[
        float | None, typer.Option("--episode-seconds", help="Most seconds of an episode; a longer one fails.")
    ] = None,
    turn_seconds: Annotated[
        float | None,
        typer.Option("--turn-seconds", help="Most seconds of a turn; with a longer one the episode fails."),
    ] = None,
    memory: Annotated[
        int | None, typer.Option("--memory", help="Most megabytes of a process; an episode that needs more fails.")
    ] = None,
    retry_failed: Annotated[
        bool, typer.Option("--retry-failed", help="Play again the episodes that failed in earlier runs.")
    ] = False,
    fail_fast: Annotated[
        bool, typer.Option("--fail-fast", help="Start no more episodes after one has failed.")
    ] = False,
    executor: Annotated[
        str | None,
        typer.Option(
            "--executor",
            help="Executor: processes, threads (for students that wait for a network), here (in this process) or ray; "
            "by default threads for models of this machine, else processes.",
        ),
    ] = None,
    address: Annotated[
        str | None,
        typer.Option("--address", help="Address of a Ray cluster; by default one is started on this machine."),
    ] = None,
    shard: Annotated[
        str,
        typer.Option("--shard", help="Part of the episodes to play, such as 3/8; `llf study merge` merges the stores."),
    ] = "1/1",
    replay_changed: Annotated[
        bool,
        typer.Option(
            "--replay-changed", help="Play again the episodes whose teacher, student or world has changed since."
        ),
    ] = False,
    keep_old: Annotated[
        bool, typer.Option("--keep-old", help="Keep these episodes, and mark the report; without either the run stops.")
    ] = False,
    shared: Shared_ = False,
    _advanced: Advanced = False,
) -> None:
    """Play the episodes of FILE that the store lacks, and write the report.

    If episodes fail, the others are still played, and the exit status is 3.
    """
    from llf_teacher.studies.definition.study import load_study
    from llf_teacher.studies.execution.changes import choice_of
    from llf_teacher.studies.execution.limits import Limits
    from llf_teacher.studies.execution.runner import RunOptions, asks_here, parse_shard

    changed = choice_of(replay_changed, keep_old)
    limits = Limits(episode_seconds, turn_seconds, memory)
    study = load_study(file)
    if executor is None:
        waits = limits == Limits() and address is None and asks_here(study, study.students)
        executor = "threads" if waits else "processes"
    options = RunOptions(executor, address, limits, parse_shard(shard), retry_failed, fail_fast, changed=changed)
    environment = {} if llm_budget is None else {BUDGET: f"{llm_budget}"}
    _run(study, file, store, report, workers, environment, options, shared)


def report(
    file: Annotated[
        Path | None, typer.Argument(help="TOML file of the study; by default the study that the store was made for.")
    ] = None,
    store: Store_ = None,
    report: Report_ = None,
    shared: Shared_ = False,
) -> None:
    """Write the report of a study from the episodes in its store, also while the study runs or after it stopped."""
    from llf_teacher.studies import load
    from llf_teacher.studies.definition.own_code import since
    from llf_teacher.studies.definition.study import load_study
    from llf_teacher.studies.report import check_writable, write_report
    from llf_teacher.studies.store import Store
    from llf_teacher.studies.store.targets import check_report, name_of

    path = store or commands.store_of(file)
    report = report or (path if file is None else commands.store_of(file)).with_suffix(".html")
    check_writable(report, [path, *([] if file is None else [file])])
    with load(path) as results, Store(path, read_only=True) as opened:
        if not shared:
            check_report(report, results.manifest.get("name", "") if file is None else name_of(file, path))
        write_report(opened, results.played_study if file is None else load_study(file), report)
        _warn(since(results.manifest.get("code", {})))
    Console(emoji=False, stderr=True, markup=False).print(f"Report: {report.resolve()}")


def check(file: Annotated[Path, typer.Argument(help="Store of a study.", exists=True, dir_okay=False)]) -> None:
    """Check that a store is complete and unchanged. Damage is printed, and the exit status is 1."""
    from llf_teacher.studies.definition.fingerprints import mixed, mixed_words
    from llf_teacher.studies.definition.own_code import since, unseen
    from llf_teacher.studies.store import Store

    with Store(file, read_only=True) as store:
        found = [f"{file}, {table}, row {row}: {problem}" for table, row, problem in store.damage()]
        for line in found:
            errors.print(escape_control_chars(line))
        if found:
            raise typer.Exit(1)
        typer.echo(f"{store.count} episodes, all as they were written.")
        code = store.manifest().get("code", {})
        _warn(mixed_words(*each) for each in mixed(store.definitions(), store.coded(), code).items())
        _warn([*since(code), *unseen(code)])


def archive(
    store: Annotated[Path, typer.Argument(help="Store of a study, which may be running.", exists=True, dir_okay=False)],
    file: Annotated[Path, typer.Argument(help="Zip file to write.")],
) -> None:
    """Copy a store whole, with the study's file, your own code, the versions of its software and its report."""
    from llf_teacher.studies import load

    with load(store) as results:
        _warn(results.archive(file))
    typer.echo(f"Archive: {file.resolve()}")


def _warn(lines: "Iterable[str]") -> None:
    for line in lines:
        errors.print(escape_control_chars(f"warning: {line}"), highlight=False, soft_wrap=True)


def export(
    store: Annotated[Path, typer.Argument(help="Store of a study.")],
    file: Annotated[Path, typer.Argument(help="File to write: .csv, .jsonl or .parquet.")],
    turns: Annotated[
        bool, typer.Option("--turns", help="Write one row for each turn instead of each episode.")
    ] = False,
    format: Annotated[
        str,
        typer.Option(
            "--format",
            help="Write training data instead of a table: chat, sft, dpo, preferences or ratings, with options.",
        ),
    ] = "",
) -> None:
    """Write the episodes of a store, or their turns, as a table or as training data."""
    from llf_teacher.studies import load

    if format:
        from llf_teacher.studies.export import write_export

        if turns:
            raise typer.BadParameter("--turns is for tables, got --format, too; leave out one of them")
        with load(store) as results:
            number = write_export(results, file, format)
        typer.echo(f"{number} written in the format {format}, stored in {file}.")
        return
    with load(store) as results:
        rows = results.export(file, "turns" if turns else "episodes")
    typer.echo(f"{rows} rows, stored in {file}.")


def power(
    pilot: Annotated[Path, typer.Argument(help="Store of a pilot: the study with a few seeds.")],
    effect: Annotated[
        float,
        typer.Option("--effect", min=0.001, max=10, help="Smallest difference between two teachers that matters."),
    ],
    of: Annotated[
        str,
        typer.Option(
            "--of",
            help="Unit of --effect: `score`, as in the findings, `regret`, in the family's unit, or `success`, a share "
            "of episodes.",
        ),
    ] = "score",
    chance: Annotated[
        float, typer.Option("--power", min=0.5, max=0.999, help="Probability of finding the effect.")
    ] = 0.8,
    baseline: Annotated[
        str | None, typer.Option("--baseline", help="Teacher to compare with; by default the baseline of the pilot.")
    ] = None,
) -> None:
    """Print how many seeds a study needs to find an effect, from a pilot: the study with a few seeds."""
    from llf_teacher.studies import load
    from llf_teacher.studies.analysis.outcomes import outcomes
    from llf_teacher.studies.analysis.power import equal, needs
    from llf_teacher.studies.analysis.primary import primary_needs
    from llf_teacher.studies.definition.design import BASELINE

    with load(pilot) as results:
        study = results.manifest.get("study", {})
        names = results.played_study.named if study else {}
        against = baseline or study.get("baseline", BASELINE)
        compare = () if baseline else study.get("compare", ())
        played = outcomes(results.rows())
    every = list(needs(played, against, effect, "regret", chance, compare))
    same = equal(played, against, of, compare)
    if not every and not same:
        raise ValueError(
            f"{pilot} has too few episodes: it needs two seeds of a student that uses feedback, with {against!r} and "
            "with another teacher; play more, or name another teacher by --baseline"
        )
    found = sorted(needs(played, against, effect, of, chance, compare), key=lambda need: -need.safe)
    patterns = study.get("primary", ())
    primary = primary_needs(played, against, effect, chance, patterns, compare) if of == "score" else []
    primary.sort(key=lambda need: -need.safe)
    head = ("family", "types", "teacher", "against", "student", "pilot", "spread", "seeds", "to be safe")
    rows = [
        (
            n.family,
            f"{n.instruction_type}, {n.feedback_type}",
            *(names.get(spec, spec) for spec in (n.teacher, n.other, n.student)),
            f"{n.pairs}",
            f"{n.spread:.3f}",
            f"{n.seeds}",
            f"{n.safe}",
        )
        for n in (*primary, *found)
    ]
    widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
    for row in (head, *rows) if rows else ():
        typer.echo("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip())
    for which, each in (("primary comparison, of all families together", primary), ("comparison of a family", found)):
        if each:
            typer.echo(
                f"To find a {of} of {effect:g} with a probability of {chance:g} in every {which}, "
                f"use {max(need.seeds for need in each)} seeds, or {each[0].safe} to be safe."
            )
    if same:
        what = "success" if of == "success" else "regret"
        typer.echo(
            f"Left out: {same} comparison{'s' * (same > 1)} of a family with the same {what} with both teachers in "
            "every seed of the pilot: no number of seeds can be given."
        )
    if of == "score" and (lacking := len(every) - len(found)):
        typer.echo(
            f"{lacking} of {len(every)} comparisons of a family have no score, since regret with the teacher that they "
            "are against is about 0: give --effect in the unit of regret, by --of regret."
        )


def merge(
    into: Annotated[Path, typer.Argument(help="Store to write.")],
    parts: Annotated[list[Path], typer.Argument(help="Stores of the parts; they are not changed.")],
) -> None:
    """Merge the stores of a study's parts."""
    from llf_teacher.studies.store import merging

    with Progress(console=Console(emoji=False, stderr=True, markup=False), transient=True) as progress:
        task = progress.add_task("episodes", total=None)
        number = merging.merge(into, parts, lambda done, total: progress.update(task, completed=done, total=total))
    typer.echo(f"{number} episodes, stored in {into}.")


def rescue(
    store: Annotated[Path, typer.Argument(help="Damaged store; it is not changed.", exists=True, dir_okay=False)],
    into: Annotated[Path, typer.Argument(help="Store to write, which must not exist.")],
) -> None:
    """Copy the whole episodes of a damaged store to a new one; `llf study run` with --store plays the others again."""
    from llf_teacher.studies.store import merging

    number, written = merging.rescue(store, into)
    of = "an unknown number of" if written is None else f"{written}"
    typer.echo(f"{number} of {of} episodes, stored in {into}; `llf study run FILE --store {into}` plays the others.")


class _Terminated(KeyboardInterrupt):
    """SIGTERM was received."""


def _terminate(number: int, frame: FrameType | None) -> None:
    raise _Terminated


def _run(
    study: "Study",
    file: Path | None,
    store: Path | None,
    report: Path | None,
    workers: int | None,
    environment: "Mapping[str, str]",
    options: "RunOptions",
    shared: bool,
) -> None:
    """Play a study and write its report; ends by `typer.Exit`.

    Args:
        study: the study.
        file: its file; None: the built-in study.
        store: the store; None: it is named after the file, like the report.
        report: the report.
        workers: see `play_missing`, as for the next two.
        environment: environment variables.
        options: how to play.
        shared: whether store and report may be those of another study.
    """
    from llf_teacher.studies.report import check_writable
    from llf_teacher.studies.store.targets import check_report, check_store, name_of

    path = store or commands.store_of(file)
    report = report or commands.store_of(file).with_suffix(".html")
    name = commands.QUICKSTART if file is None else name_of(file, path)
    check_writable(report, [path, *([] if file is None else [file])])
    if not shared:
        check_store(path, name)
        check_report(report, name)
    options = options._replace(name=name)
    signal.signal(signal.SIGTERM, _terminate)
    try:
        status = _play_and_report(study, path, report, workers, environment, options)
    except KeyboardInterrupt as error:
        what, status = ("Terminated", 143) if isinstance(error, _Terminated) else ("Interrupted", 130)
        errors.print(f"{what}. The episodes so far are in {path}; the same command resumes the study.")
    raise typer.Exit(status)


def _play_and_report(
    study: "Study",
    path: Path,
    report: Path,
    workers: int | None,
    environment: "Mapping[str, str]",
    options: "RunOptions",
) -> int:
    """Play a study and write its report; the exit status."""
    from llf_teacher.studies.analysis import costs
    from llf_teacher.studies.execution.progress import StudyProgress
    from llf_teacher.studies.execution.runner import EpisodeError, StudyError, play_missing
    from llf_teacher.studies.report import write_report
    from llf_teacher.studies.store import Store

    console = Console(emoji=False, stderr=True, markup=False)
    status = 0
    with Store(path) as store:
        try:
            with StudyProgress(console) as progress:
                played = play_missing(
                    study, store, workers, progress, environment, options, lambda message: console.print(f"{message}")
                )
        except EpisodeError as error:
            errors.print(escape_control_chars(f"{error.trace}llf: {error}"))
            if isinstance(error, StudyError) or options.fail_fast:
                if store.count:
                    errors.print(f"The episodes so far are in {path}; the same command resumes the study.")
                raise typer.Exit(3 if options.fail_fast and not isinstance(error, StudyError) else 1) from None
            errors.print("The same command with --retry-failed plays the failed episodes again.")
            status, played = 3, error.played
        for line in costs.cost_lines(store):
            console.print(line)
        console.print(f"Played {played} episodes; {path} now has {store.count}.")
        if not store.count:
            errors.print("There is no report, since all episodes failed: mend what the error names first.")
        if store.count:
            console.print("Writing the report ...")
            data = write_report(store, study, report)
            for student in data.unreadable:
                errors.print(
                    escape_control_chars(
                        f"warning: no answer of {student} could be read as an action; see `llf study transcript`"
                    )
                )
            _print_findings(console, data)
            console.print(f"Report: {report.resolve()}")
    return status


def _print_findings(console: Console, data: "Data") -> None:
    """Print the findings of the report and their scores."""
    from llf_teacher.studies.analysis.statistics import p_words
    from llf_teacher.studies.report import findings
    from llf_teacher.studies.report.parts import findings as findings_part

    for finding in findings(data):
        console.print(f"- {finding}")
    several = len(data.units) > 1
    table = Table()
    for column in (
        "teacher",
        "against",
        "student",
        *([] if several else ["more regret"]),
        "score",
        "95 %",
        "p",
        "seeds",
    ):
        table.add_column(column, overflow="fold")
    ranked = [each for each in findings_part.ranked(data) if each.declared]
    for each in ranked[:_SHOWN]:
        estimate, compared = each.score.estimate, each.compared
        names = map(data.called, (compared.teacher, compared.other, compared.student))
        more = [] if several else [each.differences[0].text(2)]
        score = f"{each.mean:.2f}" if each.ratio else "none"
        interval = f"[{estimate.low:.2f}, {estimate.high:.2f}]" if each.ratio and not estimate.why else ""
        p = p_words(each.score.p) if data.test else ""
        table.add_row(*map(escape_control_chars, names), *more, score, interval, p, f"{estimate.n}")
    if ranked:
        console.print(table)
    if len(ranked) > _SHOWN:
        console.print(f"{len(ranked) - _SHOWN} more are in the report.")
