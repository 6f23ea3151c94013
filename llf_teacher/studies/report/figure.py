"""A figure of a report with its data: as SVG in the page, and as separate files.

In the page, colours are custom properties (`var(--ink)`, `var(--series-0)`, ...), which it defines for light and dark
mode, and text has the page's font.
"""

import csv
import io
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

import matplotlib.style
from matplotlib.figure import Figure

from llf_teacher.escaping import cell_of
from llf_teacher.studies.report.plots import NARROW, STYLE, WIDTH
from llf_teacher.theme import SHADES

_STYLES: list[str | Path | dict[str, Any]] = ["default", STYLE]
_PLAIN = "!$&'()*+,-./:;=?@[]_~ "  # characters that a data URI may contain unquoted
_NOTHING: dict[str, Any] = dict.fromkeys(("Creator", "Date", "Format", "Type"))
FORMATS = ("svg", "pdf", "csv")
"""Suffixes of a figure's files."""


@dataclass(frozen=True, kw_only=True)
class Plot:
    """A figure, drawn on demand."""

    name: str
    """Stem of its files, and id of the figure in the page."""
    title: str
    """Alternative text."""
    draw: Callable[[float], Figure]
    """Draws it with a width in inches."""
    columns: Sequence[str]
    rows: Sequence[Sequence[Any]]
    """The data; floats are written with five digits, NaN is left empty."""

    @property
    def csv(self) -> str:
        """The data as CSV."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows([_cell(cell_of(value)) for value in row] for row in self.rows)
        return text.getvalue()

    @property
    def data_uri(self) -> str:
        """The data as a data URI."""
        return f"data:text/csv;charset=utf-8,{quote(self.csv, safe=_PLAIN)}"

    def save(self, folder: Path) -> list[Path]:
        """Write the figure as SVG and PDF, and its data as CSV.

        Returns:
            The files.
        """
        files = [folder / f"{self.name}.{suffix}" for suffix in FORMATS]
        with matplotlib.style.context(_STYLES):
            figure = self.draw(WIDTH)
            figure.savefig(files[0], metadata={"Date": None})
            figure.savefig(files[1], metadata={"CreationDate": None})
        files[2].write_text(self.csv, encoding="utf-8")
        return files

    def svg(self, narrow: bool = False) -> str:
        """An SVG element with unique ids, whose colours and fonts are the page's; `narrow`: for a phone."""
        buffer = io.StringIO()
        with matplotlib.style.context(_STYLES):
            figure = self.draw(NARROW if narrow else WIDTH)
            figure.savefig(buffer, format="svg", metadata=_NOTHING, transparent=True)
        svg = buffer.getvalue()
        svg = svg[svg.index("<svg") :]
        svg = re.sub(r' (width|height)="[\d.]+pt"', "", svg, count=2)
        svg = re.sub(r"<defs>\s*<style.*?</style>\s*</defs>", "", svg, flags=re.DOTALL)  # would apply to the whole page
        svg = re.sub(r"font-family: [^;\"]*;? ?", "", svg)
        svg = re.sub(r"font: ([\d.]+px) [^;\"]*", r"font-size: \1", svg)  # of older Matplotlib
        svg = re.sub(r'style="([^"]*)"', _attributes, svg)
        svg = re.sub(r'(?<==")[^"]*(?=")', _rounded, svg)
        svg = re.sub(r' transform="rotate\(-?0 [^"]*"', "", svg)  # rotations by 0
        svg = re.sub(r'<path d="[^"]*" fill="none"/>', "", svg)  # invisible paths
        used = set(re.findall(r"#([\w.-]+)", svg))
        svg = re.sub(r' id="([^"]*)"', lambda found: found[0] if found[1] in used else "", svg)
        svg = re.sub(r'(\bid="|url\(#|href="#)', rf"\g<1>{self.name}-{'narrow-' if narrow else ''}", svg)
        svg = re.sub(r">\s+<", "><", svg)
        for name, shade in SHADES.items():
            svg = svg.replace(shade.light, f"var(--{name})")
        return svg


def _cell(value: Any) -> Any:
    if not isinstance(value, float):
        return value
    return "" if math.isnan(value) else f"{value:.5g}"


def _attributes(style: re.Match[str]) -> str:
    """A style as attributes, which the content security policy always allows."""
    pairs = (part.split(":", 1) for part in style[1].split(";") if ":" in part)
    return " ".join(f'{name.strip()}="{value.strip()}"' for name, value in pairs)


def _rounded(value: re.Match[str]) -> str:
    """Coordinates to a tenth of a point, small ones to a hundredth, on one line."""
    text = " ".join(value[0].split())
    return re.sub(r"-?\d+\.\d{2,}", lambda found: _short(float(found[0])), text)


def _short(number: float) -> str:
    return f"{number:.{1 if abs(number) >= 10 else 2}f}".rstrip("0").rstrip(".")
