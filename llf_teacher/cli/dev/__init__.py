"""`llf dev`: commands for developers of these packages, one module for each."""

import sys

import typer

from llf_teacher.cli import Commands, add_modules


def add_to(app: typer.Typer) -> None:
    """Add the group and its commands."""
    group = typer.Typer(
        cls=Commands,
        help="Commands for developers of these packages: benchmarks, comparisons, golden files, tables.",
        no_args_is_help=True,
    )
    add_modules(group, sys.modules[__name__])
    app.add_typer(group, name="dev", rich_help_panel="For developers")
