"""What a part of a report is."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.figure import Plot


class Part(NamedTuple):
    """A part of the page, or of its contents."""

    name: str
    """Of its template, `parts/NAME.html.j2`, and the id of its section."""
    values: Callable[[Data], Mapping[str, Any] | None]
    """What the template is filled with, beside `data`, the whole; None leaves the part out."""
    title: str = ""
    """How the contents call it; they leave out what has no title."""
    plots: Callable[[Data], Sequence[Plot]] = lambda _: ()
    """Its figures, which `llf study figures` writes."""
    links: Callable[[Data], Sequence[tuple[str, str, str]]] | None = None
    """In place of the title, lines of the contents: id, name, and what stands behind it in brackets."""
