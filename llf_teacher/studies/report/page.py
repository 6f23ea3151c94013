"""The report of a study: one self-contained HTML page."""

import base64
import hashlib
import os
from collections import Counter
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

import jinja2
from markupsafe import Markup

from llf_teacher.escaping import escape_control_chars
from llf_teacher.studies.analysis.statistics import exact_p
from llf_teacher.studies.definition.fingerprints import mixed_words
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.report.data import Data, read
from llf_teacher.studies.report.parts import PARTS
from llf_teacher.studies.report.parts import findings as findings_part
from llf_teacher.studies.report.section import reads, reads_words
from llf_teacher.studies.store import Store
from llf_teacher.studies.store.targets import check_target
from llf_teacher.theme import pages, style

_FIGURES, _SHOWN = (
    3_000_000,
    1_500_000,
)  # bytes of figures with their data, and of transcripts, that browsers handle well


_FEW = 4  # greatest number of listed values


class ByteBudget:
    """A limit for the size of optional contents of the page.

    Args:
        left: bytes that remain.
    """

    def __init__(self, left: int) -> None:
        self._left = left

    def take(self, text: str) -> bool:
        """Whether a text fits; if so, subtract its size."""
        fits = len(text) <= self._left
        self._left -= len(text) if fits else 0
        return fits


def check_writable(path: Path, kept: Iterable[Path] = ()) -> None:
    """Check that a report can be written to a path, before a study is played.

    Args:
        path: the file.
        kept: the store and the study's file.

    Raises:
        ValueError: it is a folder, its folder is missing or not writable, or it would replace a file of a study.
    """
    check_target(path, "the report", kept)
    if path.is_dir():
        raise ValueError(f"cannot write the report to {path}: it is a folder; give a file")
    folder = path.absolute().parent
    if not folder.is_dir():
        raise ValueError(f"cannot write the report to {path}: there is no folder {folder}; create it first")
    if not os.access(folder, os.W_OK):
        raise ValueError(f"cannot write the report to {path}: the folder {folder} is not writable")


def write_report(store: Store, study: Study, path: Path) -> Data:
    """Write the report as an HTML file, which is replaced atomically.

    Returns:
        The data of the report.

    Raises:
        ValueError: no episode of the study has been played, or the path cannot be written.
    """
    check_writable(path, [store.path])
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        data = read(store, study)
        draft.write_text(page(data), encoding="utf-8", newline="\n")
        os.replace(draft, path)
    finally:
        draft.unlink(missing_ok=True)
    return data


def render(store: Store, study: Study) -> str:
    """The report as HTML; the same episodes give the same text. It does not verify columns; `Store.damage` does.

    Raises:
        ValueError: no episode of the study has been played, or turns of a transcript are missing.
    """
    return page(read(store, study))


def write_figures(store: Store, study: Study, folder: Path) -> list[Path]:
    """Write each figure as SVG and PDF, with its data as CSV, into a folder, which is created.

    Returns:
        The files.

    Raises:
        ValueError: no episode of the study has been played.
    """
    data = read(store, study)
    folder.mkdir(parents=True, exist_ok=True)
    return [file for part in PARTS for plot in part.plots(data) for file in plot.save(folder)]


class Report:
    """A report for a notebook, which shows it in a frame.

    Args:
        html: the page.
    """

    def __init__(self, html: str) -> None:
        self.html = html

    def save(self, path: Path | str) -> None:
        """Write the page; errors as in `check_writable`."""
        check_writable(Path(path))
        Path(path).write_text(self.html, encoding="utf-8", newline="\n")

    def _repr_html_(self) -> str:
        return f'<iframe srcdoc="{escape(self.html)}" width="100%" height="800" title="Feedback study"></iframe>'


def findings(data: Data) -> list[str]:
    """The findings at the head of the page, without markup."""
    environment = _environment()
    environment.filters["named"] = data.called
    values = findings_part.PART.values(data) or {}
    html = environment.get_template("parts/findings_list.html.j2").render(data=data, **values)
    plain = (Markup(each).striptags() for each in html.split("<li>"))  # noqa: S704 (the template has escaped it)
    return [escape_control_chars(each) for each in plain if each]


def page(data: Data) -> str:
    """The report as HTML."""
    environment = _environment()
    environment.filters["named"] = data.called
    filled = [(part, values) for part in PARTS if (values := part.values(data)) is not None]
    contents: list[tuple[str, str, str]] = []
    for part, _ in filled:
        contents += part.links(data) if part.links else [(part.name, part.title, "")] if part.title else []
    parts = [
        Markup(  # noqa: S704 (the template has escaped it)
            environment.get_template(f"parts/{part.name}.html.j2").render(data=data, contents=contents, **values)
        )
        for part, values in filled
    ]
    css, script = (Markup(text) for text in (style(), environment.get_template("script.js").render()))  # noqa: S704 (files of ours)
    allowed = f"style-src {_hash(css)}; script-src {_hash(script)}"
    policy = Markup(f"default-src 'none'; {allowed}; base-uri 'none'; form-action 'none'")  # noqa: S704 (as above)
    frame = environment.get_template("page.html.j2")
    name = data.manifest.get("name", "")
    return escape_control_chars(frame.render(name=name, parts=parts, style=css, script=script, policy=policy))


def _hash(text: str) -> str:
    """The hash of a text for a content security policy."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def _every(values: Sequence[float], digits: int, scale: float = 1) -> list[str]:
    """All values as texts."""
    return [f"{scale * value:.{digits}f}".replace("-", "\N{MINUS SIGN}") for value in values]


def _counted(values: Sequence[float], digits: int, scale: float = 1) -> str:
    """The different values with their counts, or the first and the last of many."""
    counts = Counter(_every(values, digits, scale))
    if len(counts) > _FEW:
        first, *_, last = counts
        return f"seeds range from {first} to {last}"
    return ", ".join(value if count == 1 else f"{value} ({count} times)" for value, count in counts.items())


def _environment() -> jinja2.Environment:
    environment = pages("llf_teacher.studies.report")
    environment.globals |= {"mixed_words": mixed_words, "figures": ByteBudget(_FIGURES), "shown": ByteBudget(_SHOWN)}
    environment.filters |= {
        "reads": reads,
        "reads_words": reads_words,
        "every": _every,
        "counted": _counted,
        "exact_p": exact_p,
    }
    return environment
