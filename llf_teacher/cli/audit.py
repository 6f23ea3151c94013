"""`llf audit`: check the claims of teachers against the simulators."""

import itertools
import json
import math
import multiprocessing
import os
import pkgutil
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import track
from rich.table import Table

from llf_teacher import cli
from llf_teacher.cli import help_shows, print_missing, read_options, search_here

if TYPE_CHECKING:
    from llf_teacher.tools.audit import Audit
    from teachers.information import Gain
    from teachers.voice import Voice


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("audit")(audit)


@help_shows("teacher", "turns", "workers", "by_family", "as_json")
def audit(
    ids: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="ID",
            help="Environments, or patterns such as 'llf-poem-*'; by default all.",
        ),
    ] = None,
    teacher: Annotated[
        list[str] | None,
        typer.Option(
            help="Teacher, such as 'mistake(eps=0.3)' or module:Class, or a pattern such as '*_focused'; repeat it for "
            "several. By default oracle."
        ),
    ] = None,
    turns: Annotated[int, typer.Option(min=1, help="Turns for each environment and teacher.")] = 1000,
    feedback_type: cli.FeedbackType = "a",
    voice: Annotated[
        str, typer.Option(help="Name of a voice, path of a voice's file, or module:function that rewrites sentences.")
    ] = "plain",
    workers: Annotated[
        int | None, typer.Option(min=1, help="Parallel processes; by default one for each core.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    by_family: Annotated[bool, typer.Option("--by-family", help="Print one row for each family.")] = False,
    by_claim: Annotated[
        bool, typer.Option("--by-claim", help="Print one row for each class of claims; needs --bits.")
    ] = False,
    bits: Annotated[
        int,
        typer.Option(
            min=0,
            metavar="WORLDS",
            help="Measure how much claims say after a basic instruction, by so many worlds, such as 256.",
        ),
    ] = 0,
    option: Annotated[
        list[str] | None,
        typer.Option(help="Option of the environments' worlds, as NAME=VALUE; repeat it for several."),
    ] = None,
    _advanced: cli.Advanced = False,
) -> None:
    """Check every claim of teachers, with many kinds of students, in worlds with many options.

    The exit status is 1 if a teacher that promises honesty makes a false claim or contradicts itself, or if
    unrequested feedback leaks.
    """
    if by_claim and not bits:
        raise ValueError("--by-claim prints how much the claims of each class say; give --bits too, as in --bits 256")
    from llf_teacher import registry
    from llf_teacher.speakers.parsing import needed_of, parse_teacher
    from llf_teacher.speakers.speaker import Speaker
    from teachers.personality import PERSONALITIES

    search_here()  # for `module:function` and `module:Class`
    _voice(voice)
    options = read_options(option)
    if not ids:
        print_missing()
        ids = [id for id in registry.ids() if not registry.entry(id).family.missing()]
    chosen = _matching(ids, registry.ids(), lambda id: registry.entry(id).id)
    specs = _matching(teacher or ["oracle"], PERSONALITIES.names, lambda spec: str(parse_teacher(spec)))
    taught = {spec: parse_teacher(spec) for spec in specs}
    for each in taught.values():
        if isinstance(each, Speaker):
            each.check(os.environ)
    console = Console(emoji=False, stderr=True)
    jobs = []
    left_out: dict[str, dict[str, None]] = {}
    unmeasured: dict[str, None] = {}
    for id, spec in itertools.product(chosen, specs):
        family = registry.entry(id).family
        if unknown := [name for name in options if name not in family.options()]:
            raise ValueError(f"{id} has no option {unknown[0]}; allowed: {', '.join(family.options()) or 'none'}")
        if bits and not family.posterior:
            unmeasured[family.name] = None
        elif family.serves(needed_of(taught[spec]), **{**family.posterior_needs, **options}):
            jobs.append((id, spec, turns, feedback_type, voice, bits, options))
        else:
            left_out.setdefault(family.name, {})[spec] = None
    if unmeasured:
        why = "bits cannot be measured there, since no worlds like the student's can be drawn"
        message = f"left out: {', '.join(unmeasured)}: {why}"
        console.print(message, markup=False, highlight=False, soft_wrap=True)
    for name, unserved in left_out.items():
        message = f"left out: {name} does not support {', '.join(unserved)}"
        console.print(message, markup=False, highlight=False, soft_wrap=True)
    if not jobs:
        raise ValueError(
            "none of these teachers can teach in these environments; docs/personalities.md shows which can"
        )
    found = list(track(_audits(jobs, workers), "auditing", len(jobs), console=console, transient=True))
    found.sort(key=lambda each: (each.id, specs.index(each.teacher)))
    if as_json:
        print(json.dumps([each.as_dict() for each in found], indent=2))  # noqa: T201
    elif not (by_family or by_claim):
        _print(found)
    else:
        if by_family:
            _print_families(found)
        if by_claim:
            _print_claims(found)
    if any(each.caught for each in found):
        raise typer.Exit(1)


def _matching(patterns: list[str], names: Iterable[str], other: Callable[[str], str]) -> list[str]:
    """The names that match the patterns, each once; `other` converts a pattern without a match, or raises an error."""
    found: dict[str, None] = {}
    for pattern in patterns:
        found.update(dict.fromkeys([name for name in names if fnmatchcase(name, pattern)] or [other(pattern)]))
    return list(found)


def _audits(jobs: list[tuple[Any, ...]], workers: int | None) -> Iterator["Audit"]:
    if len(jobs) == 1:
        yield _audit(*jobs[0])
        return
    context = multiprocessing.get_context("spawn")
    from llf_teacher.studies.execution.executors import end_with_parent

    most = min(workers or os.cpu_count() or 1, len(jobs))
    with ProcessPoolExecutor(most, mp_context=context, initializer=end_with_parent) as pool:
        futures = [pool.submit(_audit, *job) for job in jobs]
        try:
            for future in as_completed(futures):
                yield future.result()
        finally:
            pool.shutdown(cancel_futures=True)


def _audit(
    id: str, teacher: str, turns: int, feedback_type: str, voice: str, worlds: int, options: dict[str, Any]
) -> "Audit":
    from llf_teacher.tools.audit import audit

    return audit(id, teacher, turns=turns, feedback_type=feedback_type, voice=_voice(voice), worlds=worlds, **options)


def _voice(name: str) -> "Voice":
    """The name of a voice, or the function for `module:function`.

    Raises:
        ValueError: there is no such voice or function.
    """
    from teachers.voice import load_tone

    if ":" not in name or name.endswith(".toml"):
        load_tone(name)
        return name
    try:
        function: Callable[[str], str] = pkgutil.resolve_name(name)
    except (ImportError, AttributeError, ValueError) as error:
        raise ValueError(f"cannot load the voice {name!r}: {error}; expected `package.module:function`") from None
    if not callable(function):
        raise ValueError(f"the voice {name!r} must be a function that rewrites a sentence, got {function!r}")
    return function


def _print_families(found: list["Audit"]) -> None:
    """Print a row per family: the oracle's claims and words in a turn, and the false claims of all teachers."""
    from llf_teacher.registry import entry
    from teachers.atoms import KINDS, Label

    liars = list(dict.fromkeys(each.teacher for each in found if not each.honest))
    table = Table(box=None, padding=(0, 2, 0, 0))
    for column in (
        "family",
        "environments",
        "turns",
        *KINDS,
        "words",
        "honest",
        "claims",
        "false",
        "contradictions",
        *liars,
    ):
        table.add_column(column, justify="left" if column == "family" else "right")
    families: dict[str, list[Audit]] = {}
    for each in found:
        families.setdefault(entry(each.id).family.name, []).append(each)
    for name, audits in families.items():
        honest = [each for each in audits if each.honest]
        oracles = [each for each in audits if each.teacher == "oracle"]
        turns = sum(each.turns for each in oracles)
        said = {kind: sum(n for each in oracles for (k, _), n in each.claims.items() if k == kind) for kind in KINDS}
        table.add_row(
            escape(name),
            f"{len({each.id for each in audits})}",
            f"{sum(each.turns for each in audits if each.teacher == audits[0].teacher):,}",
            *(f"{said[kind] / turns:.2f}" if turns else "" for kind in KINDS),
            f"{sum(each.words for each in oracles) / turns:.0f}" if turns else "",
            f"{len({each.teacher for each in honest})}",
            f"{sum(each.checked for each in honest):,}",
            f"{sum(each.count(Label.DISTORTED) for each in honest):,}",
            f"{sum(each.contradictions for each in honest):,}",
            *(_share_false([each for each in audits if each.teacher == liar]) for liar in liars),
        )
    Console(emoji=False, width=200).print(table)


def _print_claims(found: list["Audit"]) -> None:
    """Print a row per claim class of a family: the information of its claims."""
    from llf_teacher.registry import entry
    from teachers.information import Gain

    table = Table(box=None, padding=(0, 2, 0, 0))
    for column in ("family", "claim", "measured", *_GAINS):
        table.add_column(column, justify="left" if column in ("family", "claim") else "right")
    gains: dict[tuple[str, str], Gain] = {}
    for each in found:
        for name, gain in each.gains.items():
            key = entry(each.id).family.name, name.rpartition(".")[2]
            gains[key] = gain + gains.get(key, Gain())
    for (family, name), gain in sorted(gains.items()):
        table.add_row(escape(family), name, f"{gain.claims:,}", *_gains(gain, gain.claims))
    Console(emoji=False, width=200).print(table)


_WIDE = 110  # characters
_GAINS = ("bits", "a word", "saved", "a bit")
"""Columns: bits per claim or turn, bits per word, regret saved per claim or turn and per word, regret saved per bit."""


def _gains(gain: "Gain", number: int) -> list[str]:
    """These columns, for a number of claims or turns."""
    if not gain.claims or not number:
        return ["-"] * len(_GAINS)
    bound = ">" if gain.at_least else ""
    per_word, per_bit = gain.bits_per_word, gain.saved_per_bit
    return [
        f"{bound}{gain.bits / number:.2f}",
        "-" if per_word is None else f"{bound}{per_word:.3f}",
        f"{gain.saved / number:.3f}" if gain.valued else "-",
        "-" if per_bit is None else f"{per_bit:.3f}",
    ]


def _share_false(audits: list["Audit"]) -> str:
    """The number of false claims of feedback, without instructions and notices."""
    from teachers.atoms import Label

    said = sum(number for each in audits for (kind, _), number in each.claims.items() if kind is not None)
    return f"{sum(each.count(Label.DISTORTED) for each in audits):,} of {said:,}"


def _print(found: list["Audit"]) -> None:
    from teachers.atoms import KINDS
    from teachers.words import coded_words

    measured = any(each.measured for each in found)
    console = Console(emoji=False, highlight=False)
    if measured:
        console.width = max(console.width, _WIDE)
    columns = [
        *((kind, 4) for kind in KINDS),
        ("true", 6),
        ("with-\nheld", 5),
        ("words", 5),
        ("leaks", 5),
        ("contra-\ndictions", 8),
    ]
    changes = any(each.changes for each in found)
    if changes:
        columns.append(("changed", 7))
    if measured:
        columns += [(name, 5) for name in _GAINS]
    for id, audits in itertools.groupby(found, lambda each: each.id):
        table = Table(box=None, padding=(0, 1, 0, 0))
        table.add_column("  teacher", width=12 if changes else 20, overflow="fold")
        for column, width in columns:
            table.add_column(column, min_width=width, justify="right")
        for each in audits:
            said = {kind: sum(n for (k, _), n in each.claims.items() if k == kind) for kind in KINDS}
            table.add_row(
                f"  [{'red' if each.caught else 'green'}]{escape(each.teacher)}[/]",
                *(f"{said[kind]}" for kind in KINDS),
                "-" if each.held is None else f"{math.floor(1000 * each.held) / 10:g} %",
                f"{each.withheld.total()}",
                f"{each.words / each.turns:.1f}",
                f"{each.leaks}",
                f"{each.contradictions}",
                *([f"{each.changes}"] if changes else []),
                *(_gains(each.gain, each.measured) if measured else []),
            )
        console.print(f"[bold]{escape(id)}[/]", table, sep="\n")
    table = Table("claims", "false", "student", box=None, padding=(0, 1, 0, 0))
    claims: Counter[str] = Counter()
    wrong: Counter[str] = Counter()
    for each in found:
        claims += each.students
        wrong += each.falsehoods
    for student, number in claims.items():
        table.add_row(f"{number}", f"{wrong[student]}", escape(student))
    console.print("[bold]students[/]", table, sep="\n")
    _print_elsewhere(console, [each for each in found if each.elsewhere])
    _print_hedges(console, [each for each in found if each.hedges.sentences])
    console.print(
        f"\nColumns: claims of {coded_words(KINDS)}; share of claims that are true, with those of instructions; "
        "claims of the oracle that "
        "the personality withheld; words of feedback in a turn; leaks, that is, feedback that was not asked for; pairs "
        "of claims that contradict each other."
    )
    if measured:
        console.print(
            "Bits of feedback in a turn and in a word, regret of the next action that it saves in a turn and by a bit; "
            "> where some claims say at least so much."
        )
    if reworded := sum(each.reworded for each in found):
        console.print(
            f"{reworded:,} sentences are not in our words for their claim; nobody checked whether they say the same."
        )
    if changes:
        console.print("Changed: sentences in which the voice changed a number or a name.")
    for each in found:
        for example in each.examples:
            console.print(f"\n{each.id}, {each.teacher}: {example.what}", style="red", markup=False)
            console.print(
                f"  {example.text}\n  {example.claim}\n  student {example.student}, instruction "
                f"{example.instruction_type}, options {example.options}, seed {example.seed}, turn {example.turn}",
                markup=False,
            )
        for change in each.changed:
            console.print(f"\n{each.id}, {each.teacher}: changed by the voice", style="yellow", markup=False)
            lost, new = (", ".join(names) or "nothing" for names in (change.vanished, change.appeared))
            console.print(f"  {change.before}\n  {change.after}\n  vanished: {lost}; appeared: {new}", markup=False)
    console.print(f"\n{summary(found)}", markup=False)


def _print_elsewhere(console: Console, found: list["Audit"]) -> None:
    """Print how many claims from other worlds are true there, and how many are true here, by chance."""
    for each in found:
        table = Table("kind", "claims", "true there", "true here", box=None, padding=(0, 2, 0, 0))
        for kind, numbers in each.displaced().items():
            claims, _, here = numbers
            table.add_row(kind or "", *(f"{number:,}" for number in numbers[:2]), f"{here:,} ({here / claims:.0%})")
        console.print(
            f"[bold]claims from other worlds by {escape(each.teacher)} in {escape(each.id)}[/]", table, sep="\n"
        )


def _print_hedges(console: Console, found: list["Audit"]) -> None:
    """Print how often the hedged claims of each teacher hold, by their stated probability."""
    for each in found:
        hedges = each.hedges
        table = Table("said", "sentences", "mean", "true", box=None, padding=(0, 2, 0, 0))
        for group in hedges.bins:
            numbers = f"{group.sentences:,}", f"{group.said:.1%}", f"{group.held:.1%}"
            table.add_row(f"{group.low:.0%} to {group.low + 0.09:.0%}", *numbers)
        console.print(f"[bold]hedges of {escape(each.teacher)} in {escape(each.id)}[/]", table, sep="\n")
        console.print(
            f"{hedges.sentences:,} sentences in {len(hedges.scores)} episodes: Brier score {hedges.brier:.3f}, "
            f"expected calibration error {hedges.error:.3f}; {hedges.verdict} (p = {hedges.p_value:.2g})",
            markup=False,
        )


def summary(found: list["Audit"]) -> str:
    """The findings of the audits, with everything that makes the exit status 1."""
    from teachers.atoms import Label

    honest = [each for each in found if each.honest]
    false = sum(each.count(Label.DISTORTED) for each in honest)
    contradictions = sum(each.contradictions for each in honest)
    return (
        f"{sum(each.checked for each in found)} claims checked. By teachers that promise honesty ({len(honest)} of "
        f"{len(found)} audits): {false} false claims, {contradictions} contradictions. By all: "
        f"{sum(each.leaks for each in found)} leaks."
    )
