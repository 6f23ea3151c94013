"""Export formats of a study's episodes: one module each, found by its name.

A module has `write(results, path, ...) -> int`, whose keyword-only arguments are the format's options, and which
returns the number of rows. All formats read the store, one episode at a time.
"""

import importlib
import inspect
import pkgutil
from pathlib import Path
from typing import Any

from llf_teacher.studies.results import Results
from llf_teacher.studies.store.targets import check_target
from teachers.spec import parse_call, unknown

__all__ = ["export_names", "write_export"]


def export_names() -> tuple[str, ...]:
    """The names of all formats, sorted."""
    names = (module.name for module in pkgutil.iter_modules(__path__))
    return tuple(sorted(name for name in names if name != "dialogue"))


def write_export(results: Results, path: Path | str, spec: str) -> int:
    """Export a store in a format.

    Args:
        results: the store.
        path: the file; it is replaced.
        spec: the format, with or without options: `chat`, `sft(success=True, regret_below=0.5)`, ...

    Returns:
        The number of rows.

    Raises:
        ValueError: an unknown format or option, or the file is a store or a study's file.
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
    check_target(Path(path), "the export", [results.path])
    written: int = write(results, Path(path), **options)
    return written
