"""`llf study transcript`, `figures` and `diff`: the contents of stores without a report."""

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from llf_teacher.escaping import escape_control_chars

if TYPE_CHECKING:
    from collections.abc import Mapping

    from llf_teacher.studies.analysis.diff import Comparison, Contrast
    from llf_teacher.studies.store import Store

_LISTED = 10  # greatest number of named combinations of one store only

File = Annotated[Path, typer.Argument(help="Store of a study.", exists=True, dir_okay=False)]


QUICKSTART = "llf-study"
"""Name of the built-in study."""


def store_of(file: Path | None) -> Path:
    """The store of a study by its file, in the working directory; of the built-in one without a file."""
    return Path(f"{QUICKSTART if file is None else file.stem}.db")


def add_to(group: typer.Typer) -> None:
    """Add the commands to those of studies."""
    for command in (transcript, figures, diff):
        group.command(command.__name__)(command)


def transcript(
    store: File,
    key: Annotated[
        str | None,
        typer.Argument(
            help="The episode's key, as in reports and `llf study export`, or how it begins; without it, the only "
            "episode, or a list of the first keys."
        ),
    ] = None,
    prompts: Annotated[
        bool,
        typer.Option("--prompts", help="Show what each model was asked: all messages as sent, and the answer's form."),
    ] = False,
) -> None:
    """Print an episode turn by turn: observations, feedback and actions; `!` marks a false claim, `~` a hedged one."""
    from llf_teacher.studies import load

    with load(store) as results:
        typer.echo(escape_control_chars(results.transcript(key or results.only_key(), prompts=prompts)))


def figures(
    folder: Annotated[Path, typer.Argument(help="Folder to write to; it is made if there is none.")],
    store: Annotated[
        Path | None,
        typer.Option(
            "--store",
            help="Store of a study; by default named after the study's file.",
            exists=True,
            dir_okay=False,
            show_default=False,
        ),
    ] = None,
    study: Annotated[
        Path | None, typer.Option("--study", help="TOML file of the study; without it, the one that was run.")
    ] = None,
) -> None:
    """Write each figure of the report as standalone SVG and PDF, with its data as CSV."""
    from llf_teacher.studies import load, load_study

    with load(store or store_of(study)) as results:
        files = results.figures(folder, load_study(study) if study else None)
    typer.echo(f"{len(files)} files, stored in {folder}.")


def diff(
    first: File,
    second: File,
    html: Annotated[Path | None, typer.Option("--html", help="Write what is printed as a page, too.")] = None,
) -> None:
    """Compare two stores: the second one's cumulative regret minus the first one's, and what only one store has."""
    from llf_teacher.studies.analysis.diff import compare
    from llf_teacher.studies.store import Store
    from llf_teacher.studies.store.targets import check_target

    if html is not None:
        check_target(html, "the comparison", [first, second])
    console = Console(emoji=False, record=html is not None, markup=False, highlight=False, soft_wrap=True)
    with Store(first, read_only=True) as one, Store(second, read_only=True) as other:
        one.check()
        other.check()
        called = _names(one, other)
        _show(compare(one, other), (f"{first}", f"{second}"), console, called)
    if html is not None:
        console.save_html(f"{html}")


def _numbers(change: "Contrast") -> tuple[str, ...]:
    """The printed row of a common combination."""
    regret = change.regret
    return (
        f"{regret.n}{'' if change.paired else '*'}",
        f"{change.second.regret.mean():.2f}",
        f"{regret.mean:+.2f}",
        f"none: {regret.why}" if regret.why else f"[{regret.low:.2f}, {regret.high:.2f}]",
        f"{100 * change.success:+.0f} %",
    )


def _names(*stores: "Store") -> dict[str, str]:
    """The names of teachers and students in reports, by spec, without names of several specs."""
    from llf_teacher.studies.definition.study import Study

    found: dict[str, str] = {}
    for store in stores:
        manifest = store.manifest()
        found |= Study.from_manifest(manifest, as_played=True).named if "study" in manifest else {}
    taken = Counter(found.values())
    return {spec: name for spec, name in found.items() if taken[name] == 1}


def _show(found: "Comparison", names: tuple[str, str], console: Console, called: "Mapping[str, str]") -> None:
    from llf_teacher.studies.analysis.diff import FIELDS

    def said(value: str | int) -> str:
        return called.get(f"{value}", f"{value}")

    changed = [change for change in found.changes if not change.equal]
    same = len(found.changes) - len(changed)
    console.print(
        f"{len(found.changes)} combinations of environment, teacher and student in both: {same} with equal results, "
        f"{len(changed)} without."
    )
    shown = [i for i in range(len(FIELDS)) if i < 3 or len({change.setting[i] for change in changed}) > 1]
    if changed:
        console.print(f"{names[1]} less {names[0]}: n counts pairs of the same seed, n* seeds of different worlds.")
        rows = [("n", "regret", "difference", "95 %", "success"), *map(_numbers, changed)]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        settings = [FIELDS, *(change.setting for change in changed)]
        for setting, row in zip(settings, rows, strict=True):  # a line each, since an id is longer than a column
            console.print(escape_control_chars(", ".join(said(setting[i]) for i in shown)))
            console.print("  " + "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)))
    for name, only in zip(names, found.only, strict=True):
        for setting in only[:_LISTED]:
            parts = ", ".join(said(each) for each in setting if each != "")
            console.print(escape_control_chars(f"only in {name}: {parts}"))
        if len(only) > _LISTED:
            console.print(f"only in {name}: {len(only) - _LISTED} more")
