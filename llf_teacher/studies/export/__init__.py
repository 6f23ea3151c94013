"""Formats in which other programs take a study's episodes: a module each, found by its name.

A module has `write(results, path, ...) -> int`, whose keyword arguments are the format's options, and which gives the
number of what it has written. All read the store's record and hold one episode at a time.
"""

import importlib
import inspect
import pkgutil
from pathlib import Path
from typing import Any

from llf_teacher.studies.results import Results
from teachers.spec import parse_call, unknown

__all__ = ["export_names", "write_export"]


def export_names() -> tuple[str, ...]:
    """The names of all formats, sorted."""
    names = (module.name for module in pkgutil.iter_modules(__path__))
    return tuple(sorted(name for name in names if name != "dialogue"))


def write_export(results: Results, path: Path | str, spec: str) -> int:
    """Write what a store holds in a format.

    Args:
        results: the store.
        path: the file, or the folder where a format makes several; it is replaced.
        spec: the format, with options if need be: `chat`, `sft(success=True, regret_below=0.5)`, ...

    Returns:
        The number of rows, or of data sets.

    Raises:
        ValueError: there is no such format, or it does not take such an option.
        ModuleNotFoundError: a library that the format needs is not installed; the message has the pip line.
    """
    call = parse_call("format", spec, "`name` or `name(key=value)`, such as sft(success=True)")
    name, options = call.name, call.arguments
    if name not in export_names():
        raise ValueError(unknown("format", name, export_names()))
    write: Any = importlib.import_module(f"{__name__}.{name}").write
    allowed = [key for key, each in inspect.signature(write).parameters.items() if each.kind == each.KEYWORD_ONLY]
    for key in options:
        if key not in allowed:
            raise ValueError(f"format {name!r}: {unknown('parameter', key, allowed)}")
    written: int = write(results, Path(path), **options)
    return written
