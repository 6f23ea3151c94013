"""The command line: `llf`, one module a command; a command of one family has its name."""

import pkgutil
import sys
from importlib import import_module

import typer
from rich.console import Console

from llf_teacher.visible import visible

app = typer.Typer(
    name="llf",
    help="Learning from language feedback: list environments, play, run studies, audit teachers.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
errors = Console(stderr=True, highlight=False, soft_wrap=True, markup=False)


def say_missing() -> None:
    """Say of which families nothing is done, a line each."""
    from pz_envs.family import all_families

    for family in all_families():
        if why := family.missing():
            errors.print(f"left out: {why}")


for _module in pkgutil.iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}").add_to(app)


def main() -> None:
    """Run the command line; what a user can mend is one line on standard error and exit status 2."""
    try:
        app()
    except (ValueError, ModuleNotFoundError, OSError) as error:
        errors.print(visible(f"llf: {error}"))
        sys.exit(2)
