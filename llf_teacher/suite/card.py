"""A card: the scores of a student, with what decides them, as JSON, Markdown, SVG and HTML."""

import hashlib
import io
import json
import math
import platform
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any, ClassVar, Self, get_args, get_origin, get_type_hints

import llf_teacher
from llf_teacher.studies.analysis.power import least_effect
from llf_teacher.studies.analysis.statistics import LEAST, Estimate, holm, p_words
from llf_teacher.suite.experiment import all_experiments
from llf_teacher.suite.score import Score
from teachers.spec import unknown

FORMATS = {".json": "as_json", ".md": "as_markdown", ".svg": "as_svg", ".html": "as_html"}
"""The methods that make a card's text, by the suffix of its file."""
FINDS = (
    "p: that the lessons compared are alike, by Holm's method; finds: the least contrast, in the unit of the scores, "
    "that the test finds with a power of 0.8; beside silence: the contrast with a silent teacher, in the same unit."
)
"""What a card says of its columns of these names."""
_ALPHA, _HALF = 0.05, 0.5
_COUNTED = ("episodes", "turns", "answers", "input_tokens", "output_tokens", "usd")
_MOST = 1e12
_RANGES = dict.fromkeys(("seeds", "finds", "cost", "failures"), (0.0, _MOST))
_RANGES |= {"p": (0.0, 1.0), "moments_p": (0.0, 1.0)}
"""By field of a card, the least and the greatest number; other numbers may be negative."""
_KINDS = {str: "a text", bool: "true or false", int: "an integer", float: "a number"}


class CardError(ValueError):
    """A file is no card, or was changed after it was written."""


@dataclass(frozen=True, kw_only=True)
class ScoreLine:
    """A line of a table of abilities."""

    name: str
    ability: str
    score: float | None
    """None if it was not measured."""
    low: float | None = None
    """Ends of the 95 % interval; None without one."""
    high: float | None = None
    p: float | None = None
    """That there is no contrast, after Holm's correction for all abilities of the table."""
    why: str = ""
    """What was not measured, and why."""

    sign: ClassVar[str] = ""
    """The format of signs."""

    @property
    def chance(self) -> str:
        """The p-value as text; empty without one."""
        return p_words(self.p)

    @property
    def words(self) -> str:
        """The score as text."""
        if self.score is None:
            return f"not measured: {self.why}"
        if self.low is None or self.high is None:
            return f"{self.score:{self.sign}.2f} (no interval: {self.why})"
        return f"{self.score:{self.sign}.2f} [{self.low:{self.sign}.2f}, {self.high:{self.sign}.2f}]"

    @property
    def above(self) -> bool:
        """Whether the score is significantly above 0."""
        least = self.score if self.low is None else self.low
        return (least or 0) > 0 and self.p is not None and self.p < _ALPHA


@dataclass(frozen=True, kw_only=True)
class AbilityLine(ScoreLine):
    """A line of a card: an ability and its score."""

    seeds: int
    places: Mapping[str, float]
    """The score in each environment that counts."""
    alike: bool | None
    """Where both lessons should be alike: whether they are; None elsewhere."""
    finds: float | None = None
    """The least contrast that the test finds with a power of 0.8, at the level of Holm's first step; None: none."""
    silence: ScoreLine | None = None
    """The same contrast beside silence in place of a placebo, with p after Holm's correction among these tests."""
    moments_p: float | None = None
    """That the placebo costs as much as silence, likewise: when it speaks, and that it does, changes nothing."""

    @property
    def note(self) -> str:
        """What happened where the student gains beside one of placebo and silence only; empty elsewhere."""
        if self.silence is None or self.above == self.silence.above:
            return ""
        moments = self.moments_p is not None and self.moments_p < _ALPHA
        more = (self.silence.score or 0) > (self.score or 0)  # the placebo costs less than silence
        if moments and self.above and not more:
            return "is harmed by the placebo rather than helped by the teacher"
        if moments and more and not self.above:
            return "does better with the placebo's moments than in silence: it learns from when the teacher speaks"
        worse, other = ("with the placebo", "in silence") if self.above else ("in silence", "with the placebo")
        return f"does better than {worse}, but not significantly better than {other}"

    @property
    def power(self) -> str:
        """What the test finds, as text; empty without a score."""
        return "" if self.score is None else "none" if self.finds is None else f"{self.finds:.2f}"


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
    """The reason of the first of these, and the line of the student's or teacher's code."""
    versions: Mapping[str, str]

    role: ClassVar[str] = "student"
    about: ClassVar[str] = "what it can do with feedback"
    scored: ClassVar[str] = "ability"

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
        measured = {name: each for name, each in scores.items() if each.measured}
        silent = {name: each.silence.p for name, each in measured.items() if each.silence}
        moments = {name: scores[name].moments_p for name in silent}
        tested = ({name: each.p for name, each in measured.items()}, silent, moments)
        adjusted = [dict(zip(p, holm([*p.values()]), strict=True)) for p in tested]
        played, failed = ([row for row in each if row[cls.role] == student] for each in (rows, lost))
        cost = {name: math.fsum(row.get(name) or 0 for row in played) for name in _COUNTED[1:]}
        return cls(
            student=student,
            lines=tuple(
                _line(name, cls.ability_of(name), each, [p.get(name) for p in adjusted], len(measured))
                for name, each in scores.items()
            ),
            cost={"episodes": float(len(played)), **cost},
            failures=len(failed),
            error=f"{failed[0]['error']}{_place(failed[0]['trace'])}" if failed else "",
            versions={"llf-teacher": llf_teacher.__version__, "python": platform.python_version()},
            **settings,
        )

    def sentences(self) -> list[str]:
        """Three sentences: what it does best, what it does not do, and what was not measured.

        Between the first two is one for each ability of which placebo and silence say different things.
        """
        plain = [each for each in self.lines if each.score is not None and not each.note]
        shown = sorted(
            (each for each in plain if _for_certain(each)), key=lambda each: (each.alike is not None, -(each.low or 0))
        )  # to be alike proves less: so are lessons that a student does not hear
        lacking = sorted(
            (each for each in plain if each.high is not None and each.high < _HALF), key=lambda e: e.high or 0
        )
        noted = [each for each in self.lines if each.note]
        unmeasured = [each for each in self.lines if each.score is None]
        if len(unmeasured) == len(self.lines):
            return ["Nothing was measured."]
        said = [
            f"The {self.role} {shown[0].ability}: {shown[0].words}."
            if shown
            else f"No {self.scored} differs significantly from none."
        ]
        said += [f"Whether it {each.ability} was not shown: it {each.note}." for each in noted]
        weak = "; ".join(f"{each.ability} ({each.words})" for each in lacking[:3])
        less = f"Less than half of what the reference has: {weak}."
        if lacking or not noted:
            said.append(less if lacking else "Of what was measured it has half or more.")
        names = "; ".join(each.ability for each in unmeasured)
        said.append(f"Not measured: {names}." if unmeasured else "Everything was measured.")
        return said

    def as_json(self) -> str:
        """The card as JSON, with a checksum of itself."""
        values = asdict(self)
        return json.dumps(values | {"checksum": checksum(values)}, indent=1) + "\n"

    @classmethod
    def load(cls, path: Path | str) -> Self:
        """The card in a JSON file.

        Raises:
            CardError: it is none, or was changed.
        """
        try:
            values = json.loads(Path(path).read_text(encoding="utf-8-sig"))
            if not isinstance(values, dict) or "checksum" not in values:
                raise ValueError("it has no checksum")
            whole = values.pop("checksum") == checksum(values)
            if whole:
                card: Self = _read(cls, values, "card")
                if why := _impossible(card):
                    raise ValueError(why)
        except (OSError, ValueError, RecursionError) as error:
            raise CardError(f"{path} is no card of the suite: {error}; `llf suite --card` writes one") from None
        if not whole:
            raise CardError(f"{path} was changed after it was written: its checksum does not fit; write it anew")
        return card

    def table(self) -> list[list[str]]:
        """The lines as text, below a line of heads; what is beside silence is left out where nothing is."""
        rows = [[self.scored, "score", "p", "finds", "beside silence", "by environment"]]
        for each in self.lines:
            places = ", ".join(f"{place} {value:.2f}" for place, value in each.places.items())
            silence = f"{each.silence.words}, p {each.silence.chance}" if each.silence else ""
            rows.append([each.ability, each.words, each.chance, each.power, silence, places])
        silent = any(each.silence is not None for each in self.lines)
        return [row if silent else row[:4] + row[5:] for row in rows]

    def as_markdown(self) -> str:
        """The card as a table, with its sentences and settings."""
        heads, *rows = self.table()
        rows = [[f"{each.name}: {row[0]}", *row[1:]] for each, row in zip(self.lines, rows, strict=True)]
        cells = [[cell.replace("|", "with") for cell in row] for row in (heads, ["---"] * len(heads), *rows)]
        table = [f"| {' | '.join(row)} |" for row in cells]
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
        """A dot with its interval for each ability that was measured; 0 is no notice, 1 the reference."""
        from matplotlib import style

        from llf_teacher.studies.report.plots import STYLE, Pane, panel_plot

        file, rows, dots, scale = io.StringIO(), [], {}, "0: none of it, 1: as the reference"
        for each in self.lines:
            rows.append(each.ability if each.score is not None else f"{each.ability} (not measured)")
            if each.score is not None:
                low, high = (math.nan if end is None else end for end in (each.low, each.high))
                dots[each.ability, self.role] = Estimate(each.score, low, high, each.seeds)
        with style.context(STYLE):
            figure = panel_plot([Pane(f"{self.student:.70}", scale, dots)], rows, [self.role], "score")
            figure.axes[0].axvline(1, color="0.5", linestyle=":", zorder=0)
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
        path.write_text(getattr(self, FORMATS[path.suffix])(), encoding="utf-8")


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


def _read(type_: Any, value: Any, where: str, ends: tuple[float, float] = (-_MOST, _MOST)) -> Any:
    """A JSON value as one of the type of a card's field, numbers between ends; a ValueError says what is wrong."""
    origin, inner, made = get_origin(type_), get_args(type_), is_dataclass(type_)
    if type(None) in inner:
        return None if value is None else _read(inner[0], value, where, ends)
    if isinstance(value, dict) and made:
        if odd := sorted({*value} ^ {each.name for each in fields(type_)}):
            raise ValueError(f"{where}: missing or unknown: {', '.join(odd)}")
        read = ((name, hint, _RANGES.get(name, ends)) for name, hint in get_type_hints(type_).items() if name in value)
        return type_(**{name: _read(hint, value[name], f"{where}.{name}", own) for name, hint, own in read})
    if isinstance(value, dict) and origin is Mapping:
        return {name: _read(inner[1], each, f"{where}.{name}", ends) for name, each in value.items()}
    if isinstance(value, list) and origin is Sequence:
        return tuple(_read(inner[0], each, f"{where}[{i}]", ends) for i, each in enumerate(value))
    if type(value) is not type_ and not (type_ is float and type(value) is int):
        kind = _KINDS.get(type_, "a list" if origin is Sequence else "an object")
        raise ValueError(f"{where} must be {kind}, got {value!r:.40}")
    if type_ in (int, float) and not ends[0] <= value <= ends[1]:
        raise ValueError(f"{where} must be from {ends[0]:g} to {ends[1]:g}, got {value!r:.40}")
    return value


def _impossible(card: Card) -> str:
    """Why a card cannot be, though its values have the right types; empty if it can."""
    names = [each.name for each in card.lines]
    if not names or len({*names}) < len(names):
        return f"it must have lines of different names, got {', '.join(names) or 'none'}"
    if lacking := sorted({*_COUNTED} - {*card.cost}):
        return f"its cost lacks {', '.join(lacking)}"
    for each in card.lines:
        for part in filter(None, (each, each.silence)):
            there = [end for end in (part.low, part.score, part.high) if end is not None]
            if len(there) == 2 or there != sorted(there):
                return f"the line {each.name} must have a score in its interval, got {', '.join(map(str, there))}"
        if each.score is not None and each.seeds < LEAST:
            return f"the line {each.name} must have a score by {LEAST} seeds at least, got {each.seeds}"
    return ""


def _line(name: str, ability: str, score: Score, p: Sequence[float | None], tests: int) -> AbilityLine:
    finds = least_effect(score.seeds, score.spread, _ALPHA / tests) if score.measured else math.inf
    return AbilityLine(
        **_parts(name, ability, score, p[0]),
        finds=finds if math.isfinite(finds) else None,
        silence=ScoreLine(**_parts(name, ability, score.silence, p[1])) if score.silence else None,
        moments_p=p[2],
        seeds=score.seeds,
        places=dict(score.places),
        alike=score.alike,
    )


def _parts(name: str, ability: str, score: Score, p: float | None) -> dict[str, Any]:
    """The fields of a `ScoreLine`."""
    numbers = {"score": score.value, "low": score.low, "high": score.high}
    finite = {each: value if math.isfinite(value) else None for each, value in numbers.items()}
    return {"name": name, "ability": ability, "p": p, "why": score.why, **finite}


def _place(trace: str) -> str:
    """The last line outside of this project in a traceback, such as ` (my_agent.py, line 7)`; empty without one."""
    ours = [Path(llf_teacher.__file__).parents[1] / name for name in ("llf_teacher", "pz_envs", "teachers", "worlds")]
    lines = [(Path(file), line) for file, line in re.findall(r'File "(.+)", line (\d+)', trace)]
    there = [f" ({file.name}, line {line})" for file, line in lines if not any(map(file.is_relative_to, ours))]
    return there[-1] if there else ""


def _for_certain(each: AbilityLine) -> bool:
    """Whether an ability is there: what it saves is significant, or both lessons are alike."""
    if each.alike is not None:
        return each.alike
    experiment = all_experiments().get(each.name)
    if each.low is None and experiment is not None and experiment.offset:  # p is not that of the ability
        return False
    return each.above


def checksum(values: Any) -> str:
    """A digest of JSON values."""
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:16]
