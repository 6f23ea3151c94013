"""`llf list`: list environments, teacher personalities, students and their traits."""

import dataclasses
import inspect
import json
from fnmatch import fnmatchcase
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from llf_teacher.cli import print_missing, search_here
from llf_teacher.registry import PREFIX
from pz_envs.family import Family
from pz_envs.subject import GYM


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("list")(list_)


def list_(
    pattern: Annotated[
        str,
        typer.Argument(
            help="Part of a name, or a pattern such as 'llf-metaworld-*'; what matches is described in full. Or an id "
            "of Gymnasium, such as gym:Taxi-v4: what can be taught there."
        ),
    ] = "",
    schema: Annotated[
        bool,
        typer.Option("--schema", help="Print the JSON Schema of what a teacher can say, of a family given by name."),
    ] = False,
) -> None:
    """List environments, teacher personalities, students and their traits: all, or the names that match."""
    from llf_teacher.registry import entries, ids
    from llf_teacher.students.parsing import STUDENTS, TRAITS
    from pz_envs.family import all_families
    from teachers.personality import PERSONALITIES
    from teachers.spec import unknown

    if schema:
        _print_schema(pattern)
        return
    console = Console(emoji=False, highlight=False)
    if pattern.startswith(GYM):
        _show_registered(console, pattern)
        return
    here = [family for family in all_families() if not family.missing()]
    found = {id: each.family for id, each in entries().items() if each.family in here and _matches(id, pattern)}
    teachers, students, traits = (
        [name for name in registry.names if _matches(name, pattern)] for registry in (PERSONALITIES, STUDENTS, TRAITS)
    )
    if not (found or teachers or students or traits):
        every = [*ids(), *PERSONALITIES.names, *STUDENTS.names, *TRAITS.names]
        raise ValueError(unknown("name", pattern, every, where="`llf list`"))
    if found:
        console.print("[bold]Environments[/]")
        print_missing()
    for family in here:
        _show_environments(console, family, [id for id, its_family in found.items() if its_family is family])
    if teachers:
        table = _table("teacher personality", "honest", "what it does")
        for name in teachers:
            cls: Any = PERSONALITIES[name]
            honest = "[green]yes[/]" if cls().honest else "[red]no[/]"
            table.add_row(_spec(name, cls), honest, escape(_description(name, cls, bool(pattern))))
        console.print("", table, sep="\n")
    named: tuple[tuple[str, list[str], Any], ...] = (
        ("student", students, STUDENTS),
        ("trait of students", traits, TRAITS),
    )
    for what, names, registry in named:
        if names:
            table = _table(what, "what it does")
            for name in names:
                cls = registry[name]
                table.add_row(_spec(name, cls), escape(_description(name, cls, bool(pattern))))
            console.print("", table, sep="\n")


def _print_schema(name: str) -> None:
    """The schema for a family, an id's family, or an id of Gymnasium."""
    from llf_teacher.registry import entry, family
    from pz_envs.family import all_families

    search_here()
    known = {each.name for each in all_families()}
    subject = entry(name).family if name.startswith((PREFIX, GYM)) and name not in known else family(name)
    typer.echo(json.dumps(subject.vocabulary().schema(), indent=2, ensure_ascii=False))


def _matches(name: str, pattern: str) -> bool:
    return pattern in name or fnmatchcase(name, pattern)


def _show_environments(console: Console, family: Family, ids: list[str]) -> None:
    from llf_teacher.registry import supported_types
    from teachers.words import coded_words

    if not ids:
        return
    console.print(f"\n[bold]{family.name}[/]: {escape(family.summary)}")
    instructions, feedback = map(coded_words, supported_types(ids[0]))
    console.print(f"  {family.max_turns} turns, instructions {instructions}", soft_wrap=True)
    console.print(f"  feedback {feedback}", soft_wrap=True)
    for id in ids:
        console.print(f"  [cyan]{id}[/]", soft_wrap=True)


def _show_registered(console: Console, id: str) -> None:
    """What can be taught in an environment of Gymnasium's registry."""
    from llf_teacher.tools.trial import facts
    from pz_envs.registered import registered

    search_here()
    subject = registered(id)
    console.print(f"[bold]{escape(subject.id)}[/]: {escape(subject.summary)}", soft_wrap=True)
    for about, text, _ in facts(subject):
        console.print(f"  {about:13} {escape(text)}", soft_wrap=True)
    console.print(f"  {'options':13} {', '.join(subject.options())}", soft_wrap=True)


def _table(*columns: str) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), header_style="bold")
    for name in columns:
        table.add_column(name)
    return table


def _spec(name: str, cls: Any) -> str:
    """A spec with all of its parameters."""
    parameters = ", ".join(f"{field.name}={field.default!r}" for field in dataclasses.fields(cls))
    return f"[cyan]{escape(f'{name}({parameters})' if parameters else name)}[/]"


def _description(name: str, cls: type, whole: bool) -> str:
    """What it does, as the documents say it, and with `whole` its docstring, each paragraph in one line."""
    from llf_teacher.tools.tables import definition

    paragraphs = [" ".join(each.split()) for each in (inspect.getdoc(cls) or "").split("\n\n")]
    said = definition(name, cls)
    return "\n".join([*filter(None, (said,)), *paragraphs] if whole else [said or paragraphs[0]])
