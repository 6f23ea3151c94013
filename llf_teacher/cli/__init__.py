"""The command line: `llf`, one module a command; a command of one family has its name."""

import pkgutil
import sys
from importlib import import_module

import typer
from rich.console import Console

app = typer.Typer(
    name="llf",
    help="Learning from language feedback: list environments, play, run studies, audit teachers.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
errors = Console(stderr=True, highlight=False, soft_wrap=True, markup=False)

for _module in pkgutil.iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}").add_to(app)


def main() -> None:
    """Run the command line; what a user can mend is one line on standard error and exit status 2."""
    try:
        app()
    except (ValueError, ModuleNotFoundError, OSError) as error:
        errors.print(f"llf: {error}")
        sys.exit(2)
