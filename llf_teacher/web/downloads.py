"""An episode as a file to download."""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import llf_teacher
from llf_teacher.episodes.record import Record, pack_turns, unpack_regrets, unpack_turns
from llf_teacher.serialization import to_json
from llf_teacher.studies import load
from llf_teacher.studies.export import write_export
from llf_teacher.studies.store import Store


class Download(NamedTuple):
    """A file format."""

    media_type: str
    title: str
    write: Callable[[Path, Record], object]
    """Writes an episode to a path."""


def _write_json(path: Path, record: Record) -> None:
    values: dict[str, Any] = {
        **record.spec._asdict(),
        **record.episode._asdict(),
        "key": record.spec.key,
        "regrets": unpack_regrets(record.episode.regrets),
        "turns": unpack_turns(pack_turns(record.turns)),
    }
    path.write_text(to_json(values) + "\n", encoding="utf-8")


def _write_store(path: Path, record: Record) -> None:
    with Store(path) as store:
        store.add(record)
        store.write_manifest({"version": llf_teacher.__version__})


def _write_chat(path: Path, record: Record) -> None:
    whole = path.with_name("episode.db")
    _write_store(whole, record)
    with load(whole) as results:
        write_export(results, path, "chat")


DOWNLOADS = {
    "json": Download("application/json", "JSON: all that is known of it", _write_json),
    "jsonl": Download("application/jsonl", "chat: as messages", _write_chat),
    "db": Download("application/vnd.sqlite3", "a store of a study, with this row", _write_store),
}
"""The formats by the ending of the file's name, without the film, which has its own route."""


def content(ending: str, record: Record) -> bytes:
    """The bytes of an episode's file in a format; no file stays on the server."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"download.{ending}"
        DOWNLOADS[ending].write(path, record)
        return path.read_bytes()
