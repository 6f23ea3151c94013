"""The command line: `llf`, one module a command; a command of one family has its name."""

import os
import pkgutil
import sys
from importlib import import_module
from typing import Annotated

import typer
from rich.console import Console

from llf_teacher import __version__
from llf_teacher.escaping import escape_control_chars

app = typer.Typer(
    name="llf",
    help="Learning from language feedback: list environments, play, run studies, audit teachers.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
errors = Console(stderr=True, highlight=False, soft_wrap=True, markup=False)


def draw_off_screen() -> None:
    """Let MuJoCo draw without a window, as far as that is to be chosen; before it is imported."""
    if sys.platform == "linux":
        os.environ.setdefault("MUJOCO_GL", "egl")


def say_missing() -> None:
    """Say of which families nothing is done, a line each."""
    from pz_envs.family import all_families

    for family in all_families():
        if why := family.missing():
            errors.print(f"left out: {why}")


def complete_id(incomplete: str) -> list[str]:
    """The ids that begin so, for shells."""
    from llf_teacher.registry import ids

    return [id for id in ids() if id.startswith(incomplete)]


def complete_teacher(incomplete: str) -> list[str]:
    """The personalities whose names begin so; of a pipeline its last one."""
    from teachers.personality import PERSONALITIES

    return _ends(incomplete, PERSONALITIES.names)


def complete_student(incomplete: str) -> list[str]:
    """The students whose names begin so."""
    from llf_teacher.students.parsing import STUDENTS

    return _ends(incomplete, STUDENTS.names)


def _ends(incomplete: str, names: tuple[str, ...]) -> list[str]:
    """How the last stage of a spec may go on."""
    last = incomplete.rpartition("|")[2].lstrip()
    before = incomplete[: len(incomplete) - len(last)]
    return [f"{before}{name}" for name in names if name.startswith(last)]


def _say_version(wanted: bool) -> None:
    if wanted:
        print(f"llf-teacher {__version__}")  # noqa: T201
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_say_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """What can be said before a command."""


for _module in pkgutil.iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}").add_to(app)


def main() -> None:
    """Run the command line; what a user can mend is one line on standard error and exit status 2."""
    try:
        app()
    except (ValueError, ModuleNotFoundError, OSError) as error:
        errors.print(escape_control_chars(f"llf: {error}"))
        sys.exit(2)
