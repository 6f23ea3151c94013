"""Results of a study, for scripts and notebooks: episodes as a table, turns, transcripts."""

import contextlib
import csv
import itertools
import warnings
from collections.abc import Callable, Iterator, Mapping
from html import escape
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING, Any, Self

from llf_teacher.episodes.record import ASKED, EpisodeRow, EpisodeSpec, TurnRow
from llf_teacher.escaping import cell_of, text_of_cell
from llf_teacher.models.asked import UNKNOWN, Asked, lines_of
from llf_teacher.serialization import to_json, write_json_lines
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution import runner
from llf_teacher.studies.store import Store, StoreError
from llf_teacher.studies.store.targets import check_target
from teachers.atoms import FeedbackType, Label
from teachers.words import kind_word
from worlds.extras import pip_install

if TYPE_CHECKING:
    from llf_teacher.studies.report import Report

_MARKS = {Label.DISTORTED: "!", Label.HEDGED: "~"}
_NAMED = 3  # greatest number of keys in a message
_CHUNK = 10_000  # rows in memory at once
_OF_MODELS = ("answer", "reply", *ASKED)
_LISTED = 10  # greatest number of episodes in a list
_BEGINNING = 12  # digits of a key in a list
Rows = Iterator[dict[str, Any]]
Columns = Mapping[str, Any]
"""The type of each column."""


class Results:
    """The episodes of a store, read only; as a context manager, it closes the file.

    Args:
        path: the file.

    Raises:
        StoreError: the file does not exist, is no store, or lacks episodes that were written.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self._store = Store(self.path, read_only=True)
        with contextlib.ExitStack() as on_error:
            on_error.callback(self.close)
            self._store.check()
            on_error.pop_all()

    def close(self) -> None:
        """Close the file."""
        self._store.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: Any) -> None:
        self._store.__exit__(*error)

    @property
    def episodes(self) -> Any:
        """One row per episode, as a data frame of pandas, of polars, or, without both, as a list of dicts.

        The columns are `key`, the fields of `EpisodeSpec` and `EpisodeRow`, and `revision`, a key of `definitions`.
        """
        rows = list(self.rows())
        try:
            import pandas

            return pandas.DataFrame(rows)
        except ModuleNotFoundError:
            pass
        try:
            import polars

            return polars.DataFrame(rows)
        except ModuleNotFoundError:
            return rows

    def rows(self) -> Rows:
        """The same rows one by one, in constant memory; `regrets` is a list with one number per turn."""
        return self._store.rows()

    def failures(self) -> Rows:
        """The episodes that failed: `key`, the fields of `EpisodeSpec`, `reason`, `error` and `trace`."""
        return self._store.failures()

    def turns(self, key: str) -> list[dict[str, Any]]:
        """The turns of an episode, as fields of `TurnRow`, with `action` and `atoms` decoded; turn 0 is the opening."""
        return self._store.turns(key)

    def all_turns(self) -> Rows:
        """The turns of all episodes, one by one, each with the `key` of its episode, and without the prompts."""
        for row in self.rows():
            for turn in self.turns(row["key"]):
                yield {"key": row["key"], **{name: value for name, value in turn.items() if name not in ASKED}}

    def transcript(self, key: str, *, prompts: bool = False) -> str:
        """An episode as text: observations, thoughts, feedback and actions; `!` marks false claims, `~` hedged ones.

        Args:
            key: the key of the episode, or a beginning that is unique in the store.
            prompts: whether to show what the models of student and teacher were asked.

        Raises:
            StoreError: there is no such episode, or there are several.
        """
        turns = self.turns(self._whole(key))
        lines = []
        if prompts and not any(any(turn[name] is not None for name in _OF_MODELS) for turn in turns):
            lines.append("Neither student nor teacher asked a model, so there are no prompts.")
        for turn in turns:
            if prompts:
                lines += _prompt_lines("student", turn["asked"], turn["answer"] is not None)
            if turn["turn"]:
                did = turn["action_words"] or turn["action"] or f"{turn['parse_failure']!r}, which is no action"
                lines += [f"    thinks: {line}" for line in (turn["thought"] or "").splitlines()]
                lines.append(f"[{turn['turn']}] student: {did}  (reward {turn['reward']:g})")
            lines += [f"    sees: {line}" for line in turn["observation"].splitlines()]
            if prompts:
                lines += _prompt_lines("teacher", turn["teacher_asked"], turn["reply"] is not None)
            for atom in turn["atoms"]:
                kind = kind_word(atom["kind"] and FeedbackType(atom["kind"]), not turn["turn"])
                lines.append(f"    teacher, {kind}{_MARKS.get(atom['label'], '')}: {atom['text']}")
        return "\n".join(lines)

    def only_key(self) -> str:
        """The key of the only episode.

        Raises:
            StoreError: there are several, or none; the message lists the first.
        """
        rows = list(itertools.islice(self.rows(), _LISTED + 1))
        if len(rows) == 1:
            return str(rows[0]["key"])
        if not rows:
            raise StoreError(f"{self.path} has no episodes; `llf study run` plays them")
        names = ("key", "id", "teacher", "student", "seed")
        cells = [[f"{row[name]}" for name in names] for row in rows[:_LISTED]]
        listed = [names, *([key[:_BEGINNING], *rest] for key, *rest in cells)]
        widths = [max(map(len, column)) for column in zip(*listed, strict=True)]
        padded = ([cell.ljust(width) for cell, width in zip(row, widths, strict=True)] for row in listed)
        lines = ["  ".join(row).rstrip() for row in padded]
        head = f"{self.path} has {self._store.count} episodes; give the key of one, or how it begins, as in"
        first = f"`llf study transcript {self.path} {listed[1][0]}`"
        more = ["`llf study export` writes all keys"] if len(rows) > _LISTED else []
        raise StoreError("\n".join([f"{head} {first}:", *lines, *more]))

    def _whole(self, beginning: str) -> str:
        """The only key with a beginning; errors as in `transcript`."""
        found = sorted(key for key in self._store.keys() if key.startswith(beginning.lower()))  # noqa: SIM118 (not a dict)
        if len(found) == 1:
            return found[0]
        if not found:
            raise StoreError(
                f"{self.path} has no episode whose key begins with {beginning!r}; `llf study export` writes all keys"
            )
        some = ", ".join(found[:_NAMED]) + (", ..." if len(found) > _NAMED else "")
        raise StoreError(
            f"{self.path} has {len(found)} episodes whose keys begin with {beginning!r}: {some}; give more of the key"
        )

    @property
    def manifest(self) -> dict[str, Any]:
        """The study's definition, and the versions of its software."""
        return self._store.manifest()

    @property
    def definitions(self) -> dict[int, dict[str, Any]]:
        """Every definition of played episodes, by `revision`: the study, and its software's versions."""
        return self._store.definitions()

    @property
    def study(self) -> Study:
        """The last study that was run with the store; the modules of your own agents may be missing.

        Raises:
            StoreError: the store names none.
        """
        return self._study(as_played=False)

    @property
    def played_study(self) -> Study:
        """The same study with the versions of the stored episodes, so that its episodes are the stored ones.

        Raises:
            StoreError: the store names none.
        """
        return self._study(as_played=True)

    def _study(self, *, as_played: bool) -> Study:
        if "study" not in (manifest := self.manifest):
            raise StoreError(f"{self.path} does not name its study; give the study, too")
        return Study.from_manifest(manifest, as_played=as_played)

    def report(self, study: Study | None = None) -> "Report":
        """The report of a study, by default `study`; a notebook shows it.

        Raises:
            ValueError: no episode of the study has been played.
        """
        from llf_teacher.studies.report import Report, render  # imports Matplotlib

        return Report(render(self._store, study or self.played_study))

    def figures(self, folder: Path | str, study: Study | None = None) -> list[Path]:
        """Write each figure of the report as standalone SVG and PDF, with its data as CSV.

        Raises:
            ValueError: no episode of the study has been played.
        """
        from llf_teacher.studies.report import write_figures  # imports Matplotlib

        return write_figures(self._store, study or self.played_study, Path(folder))

    def archive(self, path: Path | str) -> list[str]:
        """Write a zip file with everything about the study; other processes may write to the store at the same time.

        It has `study.db`, a whole copy of the store; `study.toml`; `manifest.json`; `requirements.txt`, the versions of
        the software; `report.html`, if an episode was played; and in `code` the modules of the user's own that the
        study names, with those that they import and the text files that they name.

        Returns:
            What the archive lacks of that code, what has changed since the last run, and what it cannot know, in words.
        """
        from llf_teacher.studies.archive import write_archive  # imports Matplotlib

        return write_archive(self.path, Path(path))

    def export(self, path: Path | str, table: str = "episodes") -> int:
        """Write a table, in constant memory.

        Args:
            path: ends in `.csv` (see `llf_teacher.studies.read_csv`), `.jsonl`, or `.parquet`, which needs pyarrow. The
                file is replaced.
            table: `episodes` or `turns`.

        Returns:
            The number of rows.

        Raises:
            ValueError: another suffix or table, or the file is a store or a study's file.
            ModuleNotFoundError: pyarrow is not installed.
        """
        path = Path(path)
        if table not in _TABLES:
            raise ValueError(f"table must be one of {', '.join(_TABLES)}, got {table!r}")
        if path.suffix not in _WRITERS:
            raise ValueError(f"the file must end in one of {', '.join(_WRITERS)}, got {path.name!r}")
        check_target(path, "the table", [self.path])
        rows, columns = _TABLES[table]
        return _WRITERS[path.suffix](path, rows(self), columns)

    def __repr__(self) -> str:
        return f"Results({str(self.path)!r}, {self._store.count} episodes)"

    def _repr_html_(self) -> str:
        """Mean regret and success of each teacher with each student, for notebooks."""
        cells: dict[tuple[str, str, str], list[tuple[float, bool]]] = {}
        for row in self.rows():
            cells.setdefault((row["family"], row["teacher"], row["student"]), []).append(
                (row["regret"], row["success"])
            )
        lines = [
            "".join(f"<td>{escape(name)}</td>" for name in names)
            + f"<td>{len(cell)}</td><td>{fmean(r for r, _ in cell):.2f}</td><td>{fmean(s for _, s in cell):.0%}</td>"
            for names, cell in cells.items()
        ]
        heads = "".join(
            f"<th>{name}</th>" for name in ("family", "teacher", "student", "episodes", "regret", "success")
        )
        return f"<table><tr>{heads}</tr>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>"


def _prompt_lines(seat: str, asked: Asked | None, model: bool) -> list[str]:
    """What the model of a seat was asked, as lines of a transcript."""
    if asked is None:
        return [f"    {seat}'s model: {UNKNOWN}"] if model else []
    lines = [f"    {seat}'s model was asked:"]
    for role, text in lines_of(asked):
        first, *rest = text.strip().splitlines() or [""]
        lines += [f"      {role}: {first}", *(f"        {line}".rstrip() for line in rest)]
    return lines


def load(path: Path | str) -> Results:
    """The results in a store.

    Raises:
        StoreError: the file does not exist, is no store, or lacks episodes that were written.
    """
    return Results(path)


def run(
    study: Study,
    path: Path | str = "llf-study.db",
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    options: runner.RunOptions = runner.RunOptions(),  # noqa: B008 (immutable)
) -> Results:
    """Play the episodes of a study that a store lacks, and give its results.

    Failed episodes give a warning; `Results.failures` has them.

    Args:
        study: the study.
        path: the store; it is created if it does not exist.
        workers: number of episodes at once; None: one per core. With 1 this process plays, unless `options` say
            otherwise. With more, a script needs the call under `if __name__ == "__main__":`.
        progress: called with the number of completed episodes, and the total.
        options: how to play.

    Raises:
        StudyError: the study cannot go on, for example after a spending limit; played episodes are stored.
        ValueError, ModuleNotFoundError: see `runner.play_missing`.
    """
    with Store(Path(path)) as store:
        try:
            runner.play_missing(study, store, workers, progress, options=options)
        except runner.StudyError:
            raise
        except runner.EpisodeError as error:
            warnings.warn(f"{error}; `failures` of the results gives the reasons", RuntimeWarning, stacklevel=2)
    return load(path)


def read_csv(path: Path | str) -> Iterator[dict[str, str]]:
    """The rows of a table that `Results.export` wrote as CSV, as texts by their columns.

    In the file, a text has an apostrophe in front, which is removed here, if a spreadsheet would run it (it begins with
    `=`, `+`, `-`, `@`, also in full width, a tab or a line end) or if it begins with an apostrophe.
    """
    with Path(path).open(newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file)
        while (row := _next_row(reader)) is not None:
            yield {name: text_of_cell(cell) for name, cell in row.items()}


def _next_row(reader: "csv.DictReader[str]") -> dict[str, str] | None:
    """The next row, whose cells may be of any length; None at the end."""
    limit = csv.field_size_limit(2**31 - 1)  # of all readers in the process
    try:
        return next(reader, None)
    finally:
        csv.field_size_limit(limit)


def _write_csv(path: Path, rows: Rows, columns: Columns) -> int:
    count = 0
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(columns))
        writer.writeheader()
        for row in rows:
            writer.writerow(
                {
                    name: to_json(value) if isinstance(value, list | dict) else cell_of(value)
                    for name, value in row.items()
                }
            )
            count += 1
    return count


def _write_jsonl(path: Path, rows: Rows, columns: Columns) -> int:
    return write_json_lines(path, rows)


def _write_parquet(path: Path, rows: Rows, columns: Columns) -> int:
    try:
        import pyarrow
        from pyarrow import parquet
    except ModuleNotFoundError:
        raise ModuleNotFoundError(f"Parquet needs pyarrow; run: {pip_install('data')}, or give a .csv") from None
    kinds: dict[Any, Any] = {
        str: pyarrow.string(),
        int: pyarrow.int64(),
        float: pyarrow.float64(),
        bool: pyarrow.bool_(),
    }
    kinds |= {bytes: pyarrow.list_(pyarrow.float64()), int | None: pyarrow.int64(), float | None: pyarrow.float64()}
    schema = pyarrow.schema([(name, kinds.get(kind, pyarrow.string())) for name, kind in columns.items()])
    count = 0
    with parquet.ParquetWriter(path, schema, compression="zstd") as writer:
        while chunk := list(itertools.islice(rows, _CHUNK)):
            for row in chunk:
                nested = [name for name, value in row.items() if isinstance(value, list | dict)]
                texts = {"action", *nested} - {name for name, kind in columns.items() if kind is bytes}
                row.update({name: to_json(row[name]) for name in texts if row.get(name) is not None})
            writer.write_table(pyarrow.Table.from_pylist(chunk, schema))
            count += len(chunk)
    return count


_TURN_COLUMNS = {name: kind for name, kind in TurnRow.__annotations__.items() if name not in ASKED}
_TABLES: dict[str, tuple[Callable[[Results], Rows], Columns]] = {
    "episodes": (
        Results.rows,
        {"key": str} | EpisodeSpec.__annotations__ | EpisodeRow.__annotations__ | {"revision": int},
    ),
    "turns": (Results.all_turns, {"key": str} | _TURN_COLUMNS),
}
_WRITERS = {".csv": _write_csv, ".jsonl": _write_jsonl, ".parquet": _write_parquet}
