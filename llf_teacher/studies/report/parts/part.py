"""The interface of a part of a report."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.figure import Plot


class Part(NamedTuple):
    """A part of the page, or of its contents."""

    name: str
    """Name of its template, `parts/NAME.html.j2`, and id of its section."""
    values: Callable[[Data], Mapping[str, Any] | None]
    """Variables of the template, beside `data`; None leaves the part out."""
    title: str = ""
    """Title in the contents; empty: not listed."""
    plots: Callable[[Data], Sequence[Plot]] = lambda _: ()
    """Its figures, which `llf study figures` writes."""
    links: Callable[[Data], Sequence[tuple[str, str, str]]] | None = None
    """Lines of the contents in place of the title: id, name, and a remark in brackets."""
