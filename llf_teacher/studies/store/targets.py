"""Files to write: none replaces a store, a study's file, another study's report or a file of another kind."""

import os
import re
from collections.abc import Iterable
from html import unescape
from pathlib import Path

from llf_teacher.studies.store import Store

_SQLITE = b"SQLite format 3\0"
_PAGE = (".html", b"<!doctype html", "an HTML page")
_KINDS = {"the report": _PAGE, "the comparison": _PAGE, "the archive": (".zip", b"pk", "a zip file")}
"""The files that such a file may replace: how their names end, or how they begin, and what they are. No program and no
note is replaced by accident."""
_HEAD = 4096  # characters or bytes of a file that say what it is, of a report also its study's name
_NAME = re.compile(r'<meta name="study" content="([^"]*)">')


def check_target(path: Path, what: str, kept: Iterable[Path] = ()) -> None:
    """Check that a file to write replaces no file of a study, and no file of another kind than its own.

    Args:
        path: the file to write.
        what: what is written, for the message, as in `the report`.
        kept: files that must stay, beside all SQLite and TOML files: a store that may not exist yet.

    Raises:
        ValueError: it would.
    """
    found = ""
    if any(_same(path, each) for each in kept):
        found = "this study's own store or file"
    elif path.suffix == ".toml":
        found = "the name of a study's file"
    elif path.is_file():
        with path.open("rb") as file:
            head = file.read(_HEAD)
        end, begins, kind = _KINDS.get(what, ("", b"", ""))
        if head.startswith(_SQLITE):
            found = "an SQLite file, such as a store"
        elif head and not (path.name.lower().endswith(end) or head.lstrip().lower().startswith(begins)):
            found = f"a file that is not {kind}"
    if found:
        raise ValueError(f"cannot write {what} to {path}: it is {found}, which is not replaced; give another file")


def _same(one: Path, other: Path) -> bool:
    if one.exists() and other.exists():
        return one.samefile(other)
    return one.resolve() == other.resolve()


def check_report(path: Path, name: str) -> None:
    """Check that a file is not the report of another study.

    Args:
        path: the file.
        name: the study's name; empty: unknown.

    Raises:
        ValueError: it is.
    """
    if not name or not path.is_file():
        return
    with path.open(encoding="utf-8", errors="replace") as file:
        found = _NAME.search(file.read(_HEAD))
    if found and (other := unescape(found[1])) not in ("", name):
        raise ValueError(
            f"{path} is the report of the study {other}, not of {name}; give another file by --report, or replace it "
            "by --shared"
        )


def check_store(path: Path, name: str) -> None:
    """Check that a file is not the store of another study.

    Args:
        path: the file.
        name: the name of the study.

    Raises:
        ValueError: it is.
        StoreError: it is not a store.
    """
    if not path.is_file() or not path.stat().st_size:
        return
    with Store(path, read_only=True) as store:
        other, count = store.manifest().get("name", ""), store.count
    if other not in ("", name):
        raise ValueError(
            f"{path} is the store of the study {other}, not of {name}, and has {count} episodes; give another file by "
            "--store, or use it for both by --shared"
        )


def name_of(file: Path, store: Path) -> str:
    """The name of a study in its store and its report: its file, seen from the folder of the store."""
    try:
        return Path(os.path.relpath(file.resolve(), store.resolve().parent)).as_posix()
    except ValueError:  # on another drive
        return file.name
