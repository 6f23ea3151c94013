"""The command line, `llf`: one module for each command; those for developers are in `dev`."""

import ast
import difflib
import inspect
import json
import os
import pkgutil
import sys
import textwrap
from collections.abc import Callable
from importlib import import_module
from types import ModuleType
from typing import Annotated, Any, TypeVar

import typer
from rich.console import Console
from typer.core import TyperGroup

from llf_teacher import __version__
from llf_teacher.escaping import escape_control_chars
from teachers.spec import unknown


def _show_all(ctx: typer.Context, wanted: bool) -> None:
    if wanted:
        for param in ctx.command.params:
            param.hidden = False  # type: ignore[attr-defined]  # arguments have it, too
        typer.echo(ctx.get_help())
        raise typer.Exit


# Options that several commands share.
InstructionType = Annotated[
    str, typer.Option(help="Instruction: b (basic), p (with feedback on past actions) or c (complete).")
]
FeedbackType = Annotated[
    str,
    typer.Option(help="Feedback: a (all), n (none), m (random kinds in each turn), or kinds such as praise+blame."),
]
MaxTurns = Annotated[int | None, typer.Option(help="Most turns of the episode; by default those of the environment.")]
WorldOptions = Annotated[
    list[str] | None, typer.Option(help="Option of the environment's world, as NAME=VALUE; repeat it for several.")
]
Advanced = Annotated[
    bool, typer.Option("--advanced", callback=_show_all, is_eager=True, help="Show all options, and exit.")
]
_F = TypeVar("_F", bound=Callable[..., Any])
_NO_HELP = "No help: `python -OO` removes docstrings, and there is no source; run `llf` without -OO."
errors = Console(emoji=False, stderr=True, highlight=False, soft_wrap=True, markup=False)


class Commands(TyperGroup):
    """Commands in alphabetical order. An unknown name is an error with the nearest ones; flags show no type."""

    def list_commands(self, ctx: Any) -> list[str]:
        """The names of the commands."""
        return sorted(self.commands)

    def get_params(self, ctx: Any) -> list[Any]:
        """The options of the group itself."""
        return _without_type_of_flags(super().get_params(ctx))

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The command of a name, or None."""
        command = super().get_command(ctx, cmd_name)
        if command is not None:
            _without_type_of_flags(command.get_params(ctx))
            command.help = command.help or _help_in_source(command.callback)
            if not ctx.resilient_parsing:  # shells complete all options
                _fold_options(command)
        return command

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command that the first argument names.

        Raises:
            ValueError: there is no such command.
        """
        name = args[0]
        if name not in self.commands and not name.startswith("-") and not ctx.resilient_parsing:
            below = {sub: group for group, each in self.commands.items() for sub in getattr(each, "commands", ())}
            for sub in difflib.get_close_matches(name, below, n=1, cutoff=0.8):
                raise ValueError(f"unknown command {name!r}; did you mean {below[sub]} {sub}?")
            raise ValueError(unknown("command", name, sorted(self.commands)))
        return super().resolve_command(ctx, args)


def _help_in_source(function: Any) -> str:
    """The docstring of a command, which `python -OO` removes."""
    try:
        (tree,) = ast.parse(textwrap.dedent(inspect.getsource(inspect.unwrap(function)))).body
        return ast.get_docstring(tree) or _NO_HELP  # type: ignore[arg-type]  # it is a function
    except (OSError, TypeError, SyntaxError):  # no source is there
        return _NO_HELP


def help_shows(*options: str) -> Callable[[_F], _F]:
    """A decorator for a command with many options: its help shows these, and `_advanced: Advanced` lets it show all."""

    def mark(function: _F) -> _F:
        vars(function)["help_shows"] = options
        return function

    return mark


def _fold_options(command: Any) -> None:
    """Hide the options of a command that its help does not show."""
    shown = getattr(command.callback, "help_shows", None)
    if shown is not None:
        for param in command.params:
            if param.param_type_name == "option":
                param.hidden = param.name not in (*shown, "_advanced", "help")


def _without_type_of_flags(params: list[Any]) -> list[Any]:
    """The same parameters; help shows `--json` instead of `--json <bool>`."""
    for param in params:
        if getattr(param, "is_flag", False):
            param.metavar = ""
    return params


app = typer.Typer(
    name="llf",
    cls=Commands,
    help="Learning from language feedback: try environments, run studies, check what teachers say.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
)


def add_modules(group: typer.Typer, package: ModuleType) -> None:
    """Add the commands of all modules of a package to a group."""
    for module in pkgutil.iter_modules(package.__path__):
        import_module(f"{package.__name__}.{module.name}").add_to(group)


def draw_off_screen() -> None:
    """Make MuJoCo draw without a window. Call it before MuJoCo is imported; a MUJOCO_GL that is set stays."""
    if sys.platform == "linux":
        os.environ.setdefault("MUJOCO_GL", "egl")


def print_missing() -> None:
    """Print a line for each family that is left out because a package is not installed."""
    from pz_envs.family import all_families

    for family in all_families():
        if why := family.missing():
            errors.print(f"left out: {why}")


def read_options(given: list[str] | None) -> dict[str, Any]:
    """Options of a world from arguments NAME=VALUE; a value is JSON, True, False or None, or a text.

    Raises:
        ValueError: an argument has no `=`, or the name of another one.
    """
    options: dict[str, Any] = {}
    for each in given or ():
        name, equals, value = each.partition("=")
        if not equals or not name:
            raise ValueError(f"an option must be NAME=VALUE, as in map_name=8x8, got {each!r}")
        if name in options:
            raise ValueError(f"each option must be given once, got {name} twice")
        try:
            options[name] = json.loads({"True": "true", "False": "false", "None": "null"}.get(value, value))
        except (ValueError, RecursionError):
            options[name] = value
    return options


def search_here() -> None:
    """Let imports find modules in the working directory, as with `python -m`."""
    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())


def complete_id(incomplete: str) -> list[str]:
    """The ids that begin with `incomplete`, for shells."""
    from llf_teacher.registry import ids

    return [id for id in ids() if id.startswith(incomplete)]


def complete_teacher(incomplete: str) -> list[str]:
    """The completions of a teacher's spec; in a pipeline, of its last stage."""
    from teachers.personality import PERSONALITIES

    return _complete_stage(incomplete, PERSONALITIES.names)


def complete_student(incomplete: str) -> list[str]:
    """The completions of a student's spec; behind `|`, of a trait."""
    from llf_teacher.students.parsing import STUDENTS, TRAITS

    return _complete_stage(incomplete, TRAITS.names if "|" in incomplete else STUDENTS.names)


def _complete_stage(incomplete: str, names: tuple[str, ...]) -> list[str]:
    last = incomplete.rpartition("|")[2].lstrip()
    before = incomplete[: len(incomplete) - len(last)]
    return [f"{before}{name}" for name in names if name.startswith(last)]


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"llf-teacher {__version__}")  # noqa: T201
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Options of `llf` itself."""


add_modules(app, sys.modules[__name__])


def main() -> None:
    """Run the command line; an error that a user can mend is one line on standard error, with exit status 2."""
    try:
        app()
    except (ValueError, ModuleNotFoundError, OSError) as error:
        errors.print(escape_control_chars(f"llf: {error}"))
        sys.exit(2)
