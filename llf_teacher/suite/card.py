"""A card: the scores of a student, with what decides them, as JSON, Markdown, SVG and HTML."""

import hashlib
import io
import json
import math
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, ClassVar, Self

import llf_teacher
from llf_teacher.studies.analysis.power import least_effect
from llf_teacher.studies.analysis.statistics import LEAST, holm
from llf_teacher.suite.experiment import all_experiments
from llf_teacher.suite.score import Score
from teachers.spec import unknown

FORMATS = (".json", ".md", ".svg", ".html")
"""The suffixes of files that a card can be written to."""
FINDS = "finds: the least contrast, in the unit of the scores, that the test finds with a power of 0.8."
"""What a card says of its column of that name."""
_ALPHA, _HALF, _TINY = 0.05, 0.5, 0.001


class CardError(ValueError):
    """A file is no card, or was changed after it was written."""


@dataclass(frozen=True, kw_only=True)
class AbilityLine:
    """A line of a card: an ability and its score."""

    name: str
    ability: str
    score: float | None
    """None if it was not measured."""
    low: float | None
    """Ends of the 95 % interval; None without one."""
    high: float | None
    p: float | None
    """That there is no contrast, after Holm's correction for all abilities of the card."""
    seeds: int
    places: Mapping[str, float]
    """The score in each environment that counts."""
    why: str
    """What was not measured, and why."""
    alike: bool | None
    """Where both lessons should be alike: whether they are; None elsewhere."""
    finds: float | None = None
    """The least contrast, in the unit of the score, that the test finds with a power of 0.8, by this student's spread,
    at the level of Holm's first step; None if it finds none.
    """

    @property
    def power(self) -> str:
        """What the test finds, as text; empty without a score."""
        return "" if self.score is None else "none" if self.finds is None else f"{self.finds:.2f}"

    @property
    def chance(self) -> str:
        """The p-value as text; empty without one."""
        return chance_words(self.p)

    @property
    def words(self) -> str:
        """The score as text."""
        return interval_words(self.score, self.low, self.high, self.why)


@dataclass(frozen=True, kw_only=True)
class Card:
    """What a student can do with feedback."""

    suite: str
    """The version, which fixes worlds, teachers, references and thresholds."""
    digest: str
    """Of all that decides a score."""
    student: str
    """Its spec, with all settings."""
    quick: bool
    key: str
    """The text from which the seeds are drawn; empty: those of the suite."""
    lines: Sequence[AbilityLine]
    cost: Mapping[str, float]
    """Episodes and turns of the student; answers, tokens in and out, and USD of one that asks a model, 0 if unknown."""
    failures: int
    """Episodes that failed."""
    error: str
    """The reason of the first of these."""
    versions: Mapping[str, str]

    role: ClassVar[str] = "student"
    about: ClassVar[str] = "what it can do with feedback"
    scale: ClassVar[str] = "0: takes no notice        1: as the reference"

    @classmethod
    def ability_of(cls, name: str) -> str:
        """What a student with the ability of this name does."""
        return all_experiments()[name].ability

    @classmethod
    def of(
        cls,
        student: str,
        scores: Mapping[str, Score],
        rows: Sequence[Mapping[str, Any]],
        lost: Sequence[Mapping[str, Any]],
        **settings: Any,
    ) -> Self:
        """The card of scores, from the rows of episodes and failures of this student and of others.

        Settings are `suite`, `digest`, `key` and `quick`.
        """
        measured = [name for name, each in scores.items() if each.measured]
        adjusted = dict(zip(measured, holm([scores[name].p for name in measured]), strict=True))
        played, failed = ([row for row in each if row[cls.role] == student] for each in (rows, lost))
        counted = ("turns", "answers", "input_tokens", "output_tokens", "usd")
        cost = {name: math.fsum(row.get(name) or 0 for row in played) for name in counted}
        return cls(
            student=student,
            lines=tuple(
                _line(name, cls.ability_of(name), each, adjusted.get(name), len(measured))
                for name, each in scores.items()
            ),
            cost={"episodes": float(len(played)), **cost},
            failures=len(failed),
            error=f"{failed[0]['error']}" if failed else "",
            versions={"llf-teacher": llf_teacher.__version__, "python": platform.python_version()},
            **settings,
        )

    def sentences(self) -> list[str]:
        """Three sentences: what it does best, what it does not do, and what was not measured."""
        named = [each for each in self.lines if each.score is not None]
        shown = sorted(
            (each for each in named if _for_certain(each)), key=lambda each: (each.alike is not None, -(each.low or 0))
        )  # to be alike proves less: so are lessons that a student does not hear
        lacking = sorted(
            (each for each in named if each.high is not None and each.high < _HALF), key=lambda e: e.high or 0
        )
        unmeasured = [each for each in self.lines if each.score is None]
        said = [
            f"The {self.role} {shown[0].ability}: {shown[0].words}."
            if shown
            else "No ability differs significantly from none."
        ]
        weak = "; ".join(f"{each.ability} ({each.words})" for each in lacking[:3])
        if lacking:
            said.append(f"Less than half of what the reference has: {weak}.")
        elif len(unmeasured) < len(self.lines):
            said.append("Of what was measured it has half or more.")
        names = ", ".join(each.name for each in unmeasured)
        said.append(f"Not measured: {names}." if unmeasured else "Everything was measured.")
        return said

    def as_json(self) -> str:
        """The card as JSON, with a checksum of itself."""
        values = asdict(self)
        return json.dumps(values | {"checksum": _checksum(values)}, indent=1) + "\n"

    @classmethod
    def load(cls, path: Path | str) -> Self:
        """The card in a JSON file.

        Raises:
            CardError: it is none, or was changed.
        """
        try:
            values = json.loads(Path(path).read_text(encoding="utf-8"))
            checksum = values.pop("checksum")
            lines = tuple(_checked(AbilityLine(**each)) for each in values["lines"])
            card = cls(**values | {"lines": lines})
        except (OSError, UnicodeDecodeError, ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
            raise CardError(
                f"{path} is no card of the suite: {error}; `llf suite --card FILE.json` writes one"
            ) from None
        if checksum != _checksum(values):
            raise CardError(f"{path} was changed after it was written: its checksum does not fit; write it anew")
        return card

    def as_markdown(self) -> str:
        """The card as a table, with its sentences and settings."""
        heads = ("ability", "score", "p", "finds", "by environment")
        rows = [
            (
                f"{each.name}: {each.ability}",
                each.words.replace("|", "with"),
                each.chance,
                each.power,
                ", ".join(f"{place} {value:.2f}" for place, value in each.places.items()),
            )
            for each in self.lines
        ]
        table = [f"| {' | '.join(row)} |" for row in (heads, ("---",) * len(heads), *rows)]
        return "\n".join([f"# `{self.student}`", "", *self.sentences(), "", *table, "", FINDS, "", self.settings(), ""])

    def settings(self) -> str:
        """What decides the scores, and what they cost, in a sentence."""
        cost = self.cost
        played = f"{cost['episodes']:.0f} episodes, {cost['turns']:.0f} turns"
        paid = (
            f", {cost['answers']:.0f} answers, {cost['input_tokens']:.0f} tokens in, {cost['output_tokens']:.0f} out, "
            f"{cost['usd']:.4f} USD"
        )
        failed = f"; {self.failures} episodes failed, the first: {self.error}" if self.failures else ""
        which = f"{self.suite} ({self.digest}{', quick' if self.quick else ''}{', own seeds' if self.key else ''})"
        versions = ", ".join(f"{name} {version}" for name, version in self.versions.items())
        return f"{which}; {played}{paid if cost['answers'] else ''}{failed}; {versions}."

    def as_svg(self) -> str:
        """A dot with its interval for each ability; 0 is no notice, 1 the reference."""
        from matplotlib import style
        from matplotlib.figure import Figure

        from llf_teacher.studies.report.plots import SERIES, STYLE

        file = io.StringIO()
        with style.context(STYLE):
            figure = Figure(figsize=(7.5, 1.0 + 0.34 * len(self.lines)))
            axes = figure.subplots()
            for place, each in enumerate(self.lines):
                if each.score is None:
                    axes.text(0.5, place, "not measured", ha="center", va="center", style="italic")
                    continue
                if each.low is not None and each.high is not None:
                    axes.plot([each.low, each.high], [place, place], color=SERIES[0], linewidth=2.2)
                axes.plot(each.score, place, "o", color=SERIES[0], markersize=7)
            for value, line in ((0, "-"), (1, ":")):
                axes.axvline(value, color="0.5", linewidth=1, linestyle=line, zorder=0)
            axes.set(yticks=range(len(self.lines)), yticklabels=[each.ability for each in self.lines])
            axes.set(ylim=(len(self.lines) - 0.5, -0.5), xlabel=self.scale, title=f"{self.student:.70}")
            figure.savefig(file, format="svg", metadata={"Date": None})
        return file.getvalue()

    def as_html(self) -> str:
        """A page that stands alone."""
        from llf_teacher.theme import pages, style

        page, picture = pages("llf_teacher.suite").get_template("card.html.j2"), self.as_svg()
        return page.render(card=self, finds=FINDS, style=style(), picture=picture[picture.index("<svg") :])

    def write(self, path: Path) -> None:
        """Write the card in the format of the file's suffix.

        Raises:
            ValueError, FileNotFoundError: see `check_file`.
        """
        check_file(path)
        made = {".json": self.as_json, ".md": self.as_markdown, ".svg": self.as_svg, ".html": self.as_html}
        path.write_text(made[path.suffix](), encoding="utf-8")


def check_file(path: Path) -> None:
    """Check, before the suite is played, that a card can be written to this file.

    Raises:
        ValueError: there is no such format.
        FileNotFoundError: there is no such folder.
    """
    if path.suffix not in FORMATS:
        raise ValueError(unknown("format of a card", path.suffix, FORMATS))
    if not path.absolute().parent.is_dir():
        raise FileNotFoundError(f"the folder {path.absolute().parent} of the card does not exist; make it first")


def interval_words(value: float | None, low: float | None, high: float | None, why: str, sign: str = "") -> str:
    """A value with its interval as text, or why there is none; `sign` is that of a format."""
    if value is None:
        return f"not measured: {why}"
    if low is None or high is None:
        return f"{value:{sign}.2f} (no interval: {why})"
    return f"{value:{sign}.2f} [{low:{sign}.2f}, {high:{sign}.2f}]"


def chance_words(p: float | None) -> str:
    """A p-value as text; empty without one."""
    return "" if p is None else f"< {_TINY}" if p < _TINY else f"{p:.3f}"


def check(path: Path | str, digest: str) -> Card:
    """The card in a file, if it is whole and of this suite.

    Raises:
        CardError: it is no card, was changed, or is of another version of the suite.
    """
    card = Card.load(path)
    if card.digest != digest:
        raise CardError(
            f"{path} is of {card.suite} with the digest {card.digest}, this release has {digest}: "
            "their scores cannot be compared; take the suite again"
        )
    return card


def _checked(line: AbilityLine) -> AbilityLine:
    """The line, if its numbers are such.

    Raises:
        ValueError: they are not.
    """
    numbers = (line.score, line.low, line.high, line.p, line.finds)
    if not all(each is None or isinstance(each, int | float) for each in numbers):
        raise ValueError(f"the line {line.name} must have numbers, got {numbers}")
    if not isinstance(line.seeds, int) or (line.low is None) != (line.high is None) or 0 < line.seeds < LEAST:
        raise ValueError(f"the line {line.name} must have an interval by {LEAST} seeds at least, got {line.seeds}")
    return line


def _line(name: str, ability: str, score: Score, p: float | None, tests: int) -> AbilityLine:
    there = score.measured
    finds = least_effect(score.seeds, score.spread, _ALPHA / tests) if there else math.inf
    return AbilityLine(
        name=name,
        ability=ability,
        score=score.value if there else None,
        low=None if math.isnan(score.low) else score.low,
        high=None if math.isnan(score.high) else score.high,
        p=p,
        seeds=score.seeds,
        places=dict(score.places),
        why=score.why,
        alike=score.alike,
        finds=finds if math.isfinite(finds) else None,
    )


def _for_certain(each: AbilityLine) -> bool:
    """Whether an ability is there: what it saves is significant, or both lessons are alike."""
    if each.alike is not None:
        return each.alike
    experiment = all_experiments().get(each.name)
    if each.low is None and experiment is not None and experiment.offset:  # p is not that of the ability
        return False
    above = each.low if each.low is not None else each.score
    return (above or 0) > 0 and each.p is not None and each.p < _ALPHA


def _checksum(values: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:16]
