"""A card: the scores of a student and the settings behind them, as JSON, Markdown, SVG and HTML."""

import hashlib
import io
import json
import math
import os
import platform
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, is_dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Self, get_args, get_origin, get_type_hints

import llf_teacher
from llf_teacher.escaping import escape_control_chars
from llf_teacher.studies.analysis.power import least_effect
from llf_teacher.studies.analysis.statistics import LEAST, RESAMPLES, Estimate, holm
from llf_teacher.studies.store.targets import check_target
from llf_teacher.suite.answers import AnswerSummary
from llf_teacher.suite.experiment import all_experiments, asked
from llf_teacher.suite.score import ALPHA, Score
from pz_envs.text.json_values import unique_keys
from teachers.spec import unknown

FORMATS = {".json": "as_json", ".md": "as_markdown", ".svg": "as_svg", ".html": "as_html"}
"""The methods that make a card's text, by the suffix of its file."""
FINDS = (
    "score: 0 is none of the ability, 1 as much as the scripted student that it is compared with; p: how probable so "
    "great a difference is by chance, after Holm's method; of a loss: a small p speaks against the ability; detects: "
    "the smallest score that the test finds in 8 of 10 cards (all equal: the difference was the same in every world, "
    "so that its spread is unknown); against silence: the same score with a silent teacher in place of useless words."
)
"""The explanations of columns by name."""
ABOVE = (
    "A score above 1 is no better than 1: the teacher made a greater difference to the student than to the scripted "
    "one, mostly since it does worse than that one without the teacher."
)
"""The explanation of scores above 1."""
HEARD = 0.8
"""Least score that counts as the whole ability in words."""
MOST = 3
"""Abilities of a kind that the sentences at the head of a card name."""
TILT = 0.05
"""Difference between lessons in the share of answers that are no action, above which a card says what it does."""
_WELL = {"obedient": "a scripted student that obeys", "reasoner": "a scripted student that reasons"}
"""References by the beginning of their spec, in plain words."""
_LATER = ("answers", "left_out", "mixed", "lessons", "readable")
"""Fields that cards of earlier releases lack."""
_COUNTED = ("episodes", "turns", "answers", "input_tokens", "output_tokens", "usd")
_MOST = 1e12
_RANGES = dict.fromkeys(("seeds", "spread", "finds", "cost", "failures"), (0.0, _MOST))
_RANGES |= {"p": (0.0, 1.0), "moments_p": (0.0, 1.0)}
_RANGES |= dict.fromkeys(("turns", "no_action", "cut", "copied", "advised", "followed"), (0.0, _MOST))
"""For fields of a card, the least and the greatest number; numbers in other fields may be negative."""
_KINDS = {str: "a text", bool: "true or false", int: "an integer", float: "a number"}


class CardError(ValueError):
    """A file is not a card, or was changed after it was written."""


@dataclass(frozen=True, kw_only=True)
class AbilityLine(Score):
    """A line of a card: an ability and its score; its p-values are corrected by Holm's method over all lines."""

    name: str
    ability: str
    finds: float | None = None
    """The least contrast that the test detects with a power of 0.8, at the level of Holm's first step; None without
    one.
    """
    answers: AnswerSummary = field(default_factory=AnswerSummary)
    """How the student answered, and a lesson to read."""
    readable: Score | None = None
    """The score in the worlds in which each answer was an action, its p not corrected; None if that was so in all."""

    @property
    def _names(self) -> dict[str, str]:
        """The kinds of lessons in words."""
        if self.asked and not all_experiments()[self.name].worse:
            return {"better": "with the teacher's words", "worse": "with useless words", "silent": "in silence"}
        return {"better": "with the better teacher", "worse": "with the worse teacher", "silent": "in silence"}

    @property
    def failing(self) -> str:
        """How many answers were no action in each kind of lesson, in words; empty if all were actions, or none was."""
        lessons = self.answers.lessons
        if sum(each.no_action for each in lessons.values()) in (0, sum(each.turns for each in lessons.values())):
            return ""
        return ", ".join(f"{each.no_action} of {each.turns} {self._names[kind]}" for kind, each in lessons.items())

    def _more(self, kind: str) -> float:
        """How much greater the share of failing answers is than in the better lessons; 0 if not by more than `TILT`."""
        lessons = self.answers.lessons
        more = lessons[kind].share - lessons["better"].share if {kind, "better"} <= {*lessons} else 0.0
        return more if abs(more) > TILT and self.score is not None else 0.0

    @property
    def too(self) -> str:
        """What failing answers make the score: `too high` or `too low`; empty if they do neither."""
        more = self._more("worse") if self.alike is None else -self._more("worse")
        return "too high" if more > 0 else "too low" if more < 0 else ""

    @property
    def bias(self) -> str:
        """What failing answers do to the score, as a clause; empty if they do nothing."""
        compared = {"worse": ("the score", self.too)}
        if self.silence is not None and (more := self._more("silent")):
            compared["silent"] = ("the score against silence", "too high" if more > 0 else "too low")
        for kind, (what, too) in compared.items():
            if too:
                more_in, less_in = (kind, "better") if self._more(kind) > 0 else ("better", kind)
                return f"{what} is {too}, since more answers failed {self._names[more_in]} than {self._names[less_in]}"
        return ""

    @property
    def elsewhere(self) -> str:
        """The score in the worlds in which no answer failed, as a clause."""
        there = self.readable
        if there is None or there.score is None:
            return "too few worlds have no failing answer for a score of their own"
        least = ", the least that so few worlds can give" * (there.p == 2.0 ** (1 - there.seeds) >= ALPHA)
        return f"in the {there.seeds} worlds in which no answer failed it is {there.words}, p {there.chance}{least}"

    @property
    def shown(self) -> bool:
        """Whether the ability is shown; if failing answers make the score too high, by the other worlds, too."""
        flattered = self.too == "too high" or (self.silence is not None and self._more("silent") > 0)
        held = [self, *([self.readable or Score()] if flattered else [])]
        if self.alike is not None:
            return all(each.alike for each in held)
        silences = [each.silence for each in held[1:] if each.silence is not None]
        return all(each.above for each in (*held, *silences))

    @property
    def answered(self) -> str:
        """The answers, in sentences, with those of each kind of lesson if some failed."""
        return f"{self.answers.words}{f' No action: {self.failing}.' if self.failing else ''}"

    @property
    def summary(self) -> str:
        """The score, and what failing answers do to it."""
        return f"{self.words}; {self.bias} ({self.failing}); {self.elsewhere}" if self.bias else self.words

    @property
    def asked(self) -> str:
        """What was asked, in plain words."""
        return asked(self.name)

    @property
    def did(self) -> str:
        """What the student did, in a sentence of plain words."""
        reference = all_experiments()[self.name].reference if self.asked else ""
        other = next((words for spec, words in _WELL.items() if reference.startswith(spec)), "the scripted student")
        if self.score is None:
            return f"This could not be measured: {self.why}."
        return " ".join(filter(None, (self._verdict(self.score, other), self._remark())))

    def _verdict(self, score: float, other: str) -> str:
        """Whether the student has the ability, in a sentence; `other` is its reference in plain words."""
        spared = f"the teacher spared it {score:.0%} of the loss that it spares {other}"
        if score <= 0:
            spared = "the teacher spared it nothing"
        elif round(score, 2) > 1:
            spared = f"the teacher spared it more loss than it spares {other}, {score:.0%} of that"
        if self.alike is not None:
            if self.shown:
                return "It did as well as without this: it lost nothing that chance does not explain."
            if self.p is not None and self.p < ALPHA and score < 1:
                return f"It lost by this, {1 - score:.0%} of what it costs {other}."
            return (
                "Whether it lost by this is not decided: chance explains the difference, but more worlds may show one."
            )
        if self.note:
            return f"Whether it {self.ability} was not shown: it {self.note}."
        if self.shown:
            return f"It {'did' if score >= HEARD else 'did in part'}: {spared}."
        if self.above:
            return f"Whether it {self.ability} is not decided: failing answers may explain the score."
        low = " So many answers failed that this says little about what it understood."
        low *= self.answers.failed and not self.bias
        if self.high is not None and self.high < HEARD / 2:
            return f"It did not: {spared}, no more than chance explains.{low}"
        return f"This is not decided: {spared}, and chance explains as much.{low}"

    def _remark(self) -> str:
        """What failing answers do to the score, and why a score has no spread, in sentences; empty without either."""
        said = [f"{self.bias.capitalize()}; {self.elsewhere}."] if self.bias else []
        asked = all_experiments().get(self.name)
        if self.score == 0 and not self.spread and self.alike is None:
            since = f" from turn {asked.since + 1} on, which alone counts," if asked and asked.since else ""
            both = f"{self._names['better']} and {self._names['worse']}"
            said.append(f"In each world its loss{since} was the same {both}.")
        return " ".join(said)

    @property
    def measured(self) -> str:
        """The score with its interval and the number of worlds."""
        return f"score {self.cell}, {self.seeds} worlds" if self.score is not None else "no score"

    @property
    def cell(self) -> str:
        """The score with its interval for a table; the reason of a missing one stands elsewhere."""
        return "not measured" if self.score is None else f"{self.words}{f', {self.too}' if self.too else ''}"

    @property
    def detects(self) -> str:
        """The smallest score that the test finds, for a table."""
        if self.score is None or not self.spread:
            return "all equal" * (self.score is not None)
        return "none" if self.finds is None else f"{self.finds:.2f}"

    @property
    def note(self) -> str:
        """The explanation if the student gains over only one of placebo and silence; otherwise empty."""
        if self.silence is None or self.above == self.silence.above:
            return ""
        worse, other = ("with useless words", "in silence") if self.above else ("in silence", "with useless words")
        costs_less = (self.silence.score or 0) > (self.score or 0)  # the placebo costs less than silence
        if self.moments_p is None or self.moments_p >= ALPHA or self.above == costs_less:
            return f"does better than {worse}, but not significantly better than {other}"
        if self.above:
            return "is harmed by useless words rather than helped by the teacher"
        return "does better with useless words than in silence: it learns from when the teacher speaks"


@dataclass(frozen=True, kw_only=True)
class Card:
    """The scores of a student."""

    suite: str
    """The version of the suite, which fixes worlds, teachers, references and thresholds."""
    digest: str
    """The digest of everything that decides a score."""
    student: str
    """Its spec, with all settings."""
    quick: bool
    key: str
    """The text that determines the seeds; empty: the suite's seeds."""
    lines: Sequence[AbilityLine]
    cost: Mapping[str, float]
    """Episodes and turns of the student; answers, tokens in and out, and USD if it asks a model, 0 if unknown."""
    failures: int
    """Number of failed episodes."""
    error: str
    """The reason of the first failure, with the line of the student's code."""
    versions: Mapping[str, str]
    left_out: Mapping[str, str] = field(default_factory=dict)
    """Experiments that the quick suite left out for want of time, each with the reason."""
    mixed: Mapping[str, str] = field(default_factory=dict)
    """Students and teachers whose code changed between the episodes, each with how many of each version."""

    @classmethod
    def of(
        cls,
        student: str,
        asked: Mapping[str, Any],
        scores: Mapping[str, Score],
        rows: Sequence[Mapping[str, Any]],
        lost: Sequence[Mapping[str, Any]],
        answers: Mapping[str, AnswerSummary] = MappingProxyType({}),
        readable: Mapping[str, Score | None] = MappingProxyType({}),
        **settings: Any,
    ) -> Self:
        """The card of scores, by name as what was asked, from the rows of episodes and failures of this and others.

        Summaries of answers, and scores in the worlds in which each answer was an action, are by name, too. Settings
        are `suite`, `digest`, `key`, `quick`, `left_out` and `mixed`.
        """
        played, failed = ([row for row in each if row["student"] == student] for each in (rows, lost))
        cost = {name: math.fsum(row.get(name) or 0 for row in played) for name in _COUNTED}
        found = list(scores.values())
        tests = sum(each.score is not None for each in found)
        p, moments_p = adjusted([each.p for each in found]), adjusted([each.moments_p for each in found])
        silent_p = adjusted([each.silence.p if each.silence else None for each in found])
        lines = []
        for i, (name, each) in enumerate(scores.items()):
            finds = math.inf if each.score is None else least_effect(each.seeds, each.spread, ALPHA / tests)
            values = vars(each) | {
                "finds": finds if math.isfinite(finds) else None,
                "p": p[i],
                "moments_p": moments_p[i],
            }
            values |= {"silence": each.silence and replace(each.silence, p=silent_p[i])}
            values |= {"answers": answers.get(name, AnswerSummary()), "readable": readable.get(name)}
            lines.append(AbilityLine(name=name, ability=asked[name].ability, **values))
        return cls(
            student=student,
            lines=lines,
            cost=cost | {"episodes": float(len(played))},
            failures=len(failed),
            error=escape_control_chars(failed[0]["error"]) if failed else "",
            versions={"llf-teacher": llf_teacher.__version__, "python": platform.python_version()},
            **settings,
        )

    def sentences(self) -> list[str]:
        """Sentences: the best abilities, at most three, the missing ones, the unmeasured ones, and what was not asked.

        After the first comes a sentence for each ability with different results beside placebo and silence. Abilities
        in whose lessons many answers failed are not called missing; a sentence has them, and one what was answered.
        """
        several = [f"{words}." for words in self.mixed.values()]
        return several + self._findings()

    def _findings(self) -> list[str]:
        measured = [each for each in self.lines if each.score is not None]
        if not measured:
            return ["Nothing was measured.", *self._failed(), *self._not_asked()]
        plain, noted = ([each for each in measured if bool(each.note) == odd] for odd in (False, True))
        # equal regret is weaker evidence: unheard lessons also have equal regret
        shown = sorted(
            (each for each in plain if each.shown),
            key=lambda each: (each.alike is not None, -((each.score or 0) if each.low is None else each.low)),
        )
        best, also = shown[:MOST], shown[MOST:]
        moot = [each for each in plain if (each.above if each.alike is None else each.alike) and not each.shown]
        none = ["No ability was shown significantly."] * (not moot)
        abilities = "; ".join(
            f"{each.ability}{' in part' * ((each.score or 0) < 0.5)}: {each.summary}" for each in best
        )
        said = [f"The student {abilities}{_and_more(also)}."] if best else none
        said += [f"Whether it {each.ability} was not shown: it {each.note}." for each in noted]
        said += [f"Whether it {each.ability} is not decided: {each.summary}." for each in moot]
        odd = [each for each in plain if each.answers.failed or each.too == "too low"]
        less = [each for each in plain if each.high is not None and each.high < 0.5 and each not in odd]
        lacking = sorted(less, key=lambda each: each.high or 0)
        weak = "; ".join(f"{each.ability} ({each.words})" for each in lacking[:MOST])
        if weak:
            said.append(f"Less than half as much as the scripted student: {weak}{_and_more(lacking[MOST:])}.")
        elif not noted and not odd:
            said.append("In no ability does the interval lie below half of the scripted student's score.")
        said += self._failed([*moot, *best])
        names = "; ".join(each.ability for each in self.lines if each.score is None)
        said.append(f"Not measured: {names}." if names else "Everything asked was measured.")
        return said + self._not_asked()

    def _failed(self, said: Sequence[AbilityLine] = ()) -> list[str]:
        """What is said of abilities in whose lessons many answers failed, with a sample of one.

        Those of `said` have their counts in other sentences; the reason of a missing score has them, too.
        """
        failed = [each for each in self.lines if each.answers.failed or each.bias]
        if not failed:
            return []
        rest = [each for each in failed if each.score is not None and not (each in said and each.bias)]
        counts = "; ".join(
            f"{each.ability} ({each.bias}: {each.failing}; {each.elsewhere})"
            if each.bias
            else f"{each.ability} (of {each.answers.turns} {', '.join(each.answers.faults)})"
            for each in rest
        )
        worst = max((each.answers for each in failed), key=lambda each: each.no_action / each.turns)
        wrong = any(each.answers.no_action or each.answers.cut for each in failed)
        what = "failed" if wrong else "repeat the prompt"
        many = f"Many answers {what}, so that scores also show how the student answers, not only what it makes of"
        sentence = f"{many} feedback: {counts}."
        # The sample is an answer that failed if there is one, and one that repeats the prompt only where all do.
        return [sentence] * bool(rest) + [worst.sample] * (wrong or worst.copied == worst.turns)

    def _not_asked(self) -> list[str]:
        """What the card does not say."""
        said = [f"Left out: {all_experiments()[name].ability}, for {why}." for name, why in self.left_out.items()]
        there = {each.name for each in self.lines} | {*self.left_out}
        rest = "; ".join(each.ability for name, each in all_experiments().items() if name not in there)
        if self.quick and rest:
            said.append(f"Only the whole suite asks whether it {rest}.")
        return said

    def as_json(self) -> str:
        """The card as JSON, with a checksum of itself."""
        values = asdict(self)
        return json.dumps(values | {"checksum": checksum(values)}, indent=1) + "\n"

    @classmethod
    def load(cls, path: Path | str) -> Self:
        """The card in a JSON file.

        Raises:
            CardError: the file is not a card, or was changed.
        """
        try:
            values = json.loads(Path(path).read_text(encoding="utf-8-sig"), object_pairs_hook=unique_keys)
            if not isinstance(values, dict) or "checksum" not in values:
                raise ValueError("it has no checksum")
            if values.pop("checksum") != checksum(values):
                raise ValueError("it was changed after it was written: its checksum does not match")
            card: Self = _read(cls, values, "card")
            _check(card)
        except (OSError, ValueError, RecursionError) as error:
            raise CardError(f"{path} is not a card of the suite: {error}; `llf suite --card` writes one") from None
        return card

    def table(self) -> list[list[str]]:
        """The lines as text, below a line of heads; columns about silence are omitted when empty."""
        rows = [["ability", "score", "p", "detects", "against silence", "by environment"]]
        for each in self.lines:
            places = ", ".join(f"{place} {value:.2f}" for place, value in each.places.items())
            silence = f"{each.silence.words}, p {each.silence.chance}" if each.silence else ""
            chance = f"{each.chance}{' (of a loss)' * (each.alike is not None)}"
            rows.append([each.ability, each.cell, chance, each.detects, silence, places])
        silent = any(each.silence is not None for each in self.lines)
        return [row if silent else row[:4] + row[5:] for row in rows]

    def as_markdown(self) -> str:
        """The card as a table, with its sentences and settings."""
        heads, *rows = self.table()
        rows = [[f"{each.name}: {row[0]}", *row[1:]] for each, row in zip(self.lines, rows, strict=True)]
        cells = [[cell.replace("|", "with") for cell in row] for row in (heads, ["---"] * len(heads), *rows)]
        table = [f"| {' | '.join(row)} |" for row in cells]
        told = [part for each in self.lines for part in _told(each)]
        head = [f"# `{self.student}`", "", *self.sentences(), ""]
        return "\n".join([*head, *told, "## Numbers", "", *table, "", self.explained, "", self.settings(), ""])

    @property
    def explained(self) -> str:
        """What the columns are, and the least p that these tests can have."""
        tested = [each for each in self.lines if each.p is not None]
        if not tested:
            return FINDS
        above = f" {ABOVE}" * any(each.score is not None and round(each.score, 2) > 1 for each in tested)
        worlds = max(each.seeds for each in tested)
        ways = 2.0 ** (worlds - 1)
        least = len(tested) * max(1 / ways, 1 / (RESAMPLES + 1))
        tests = f"{len(tested)} tests" if len(tested) > 1 else "one test"
        return f"{FINDS}{above} With {tests} in {worlds} worlds, no p can be below {min(1.0, least):.3f}."

    def settings(self) -> str:
        """The settings and the cost of the scores, in a sentence."""
        cost = self.cost
        played = f"{cost['episodes']:.0f} episodes, {cost['turns']:.0f} turns"
        paid = (
            f", {cost['answers']:.0f} answers, {cost['input_tokens']:.0f} tokens in, {cost['output_tokens']:.0f} out, "
            f"{cost['usd']:.4f} USD"
        )
        failed = f"; {self.failures} episodes failed, the first: {self.error}" if self.failures else ""
        which = f"{self.digest}{', quick' if self.quick else ''}{f', key {self.key!r}' if self.key else ''}"
        versions = ", ".join(f"{name} {version}" for name, version in self.versions.items())
        return f"{self.suite} ({which}); {played}{paid if cost['answers'] else ''}{failed}; {versions}."

    def as_svg(self) -> str:
        """A dot with its interval for each measured ability; 0: no notice is taken, 1: as the reference."""
        from matplotlib import style

        from llf_teacher.studies.report.plots import STYLE, Pane, panel_plot

        file, dots, scale = io.StringIO(), {}, "0: none of it, 1: as the scripted student"
        unsure = {True: " (not measured)", False: " (no interval)"}
        rows = [f"{each.ability}{unsure[each.score is None] * (each.low is None)}" for each in self.lines]
        for row, each in zip(rows, self.lines, strict=True):
            if each.score is not None:
                low, high = (math.nan if end is None else end for end in (each.low, each.high))
                dots[row, "student"] = Estimate(each.score, low, high, each.seeds)
        with style.context(STYLE):
            figure = panel_plot([Pane(f"{self.student:.70}", scale, dots)], rows, ["student"], "score")
            figure.axes[0].axvline(1, color="0.5", linestyle=":", zorder=0)
            figure.savefig(file, format="svg", metadata={"Date": None})
        return file.getvalue()

    def as_html(self) -> str:
        """A self-contained page."""
        from llf_teacher.theme import pages, style

        page, picture = pages("llf_teacher.suite").get_template("card.html.j2"), self.as_svg()
        return page.render(card=self, style=style(), picture=picture[picture.index("<svg") :])

    def write(self, path: Path) -> None:
        """Write the card in the format of the file's suffix.

        Raises:
            ValueError, FileNotFoundError: see `check_file`.
        """
        check_file(path)
        path.write_text(getattr(self, FORMATS[path.suffix])(), encoding="utf-8")


def _told(line: AbilityLine) -> list[str]:
    """An ability in Markdown: what was asked, what the student did, and a lesson to open."""
    answers = line.answers
    parts = [
        f"## {line.name}: {line.ability}",
        "",
        f"{line.asked} **{line.did}** ({line.measured}.) {line.answered}",
        "",
    ]
    if not answers.transcript:
        return parts
    fence = "`" * max(3, 1 + max(map(len, re.findall("`+", answers.transcript)), default=0))
    lesson = [
        "<details><summary>An episode, turn by turn</summary>",
        "",
        fence,
        answers.transcript,
        fence,
        "",
        "</details>",
    ]
    return [*parts, answers.sample, "", *lesson, ""]


def _and_more(rest: Sequence[AbilityLine]) -> str:
    return f"; and {len(rest)} more" if rest else ""


def adjusted(p: Sequence[float | None]) -> list[float | None]:
    """p-values after Holm's correction, over all that exist."""
    there = iter(holm([each for each in p if each is not None]))
    return [None if each is None else next(there) for each in p]


def check_file(path: Path) -> None:
    """Check, before the suite begins, that a card can be written to this file.

    Raises:
        ValueError, FileNotFoundError: there is no such format, or no such folder.
    """
    if path.suffix not in FORMATS:
        raise ValueError(unknown("format of a card", path.suffix, FORMATS))
    if not path.absolute().parent.is_dir():
        raise FileNotFoundError(f"the folder {path.absolute().parent} of the card does not exist; make it first")
    if path.is_dir() or not os.access(path if path.exists() else path.absolute().parent, os.W_OK):
        raise ValueError(f"cannot write the card to {path}: give a file that you may write")
    check_target(path, "the card")


def _read(type_: Any, value: Any, where: str, ends: tuple[float, float] = (-_MOST, _MOST)) -> Any:
    """A JSON value in the type of a card's field, numbers within limits; a ValueError describes the problem."""
    origin, inner, made = get_origin(type_), get_args(type_), is_dataclass(type_)
    if type(None) in inner:
        return None if value is None else _read(inner[0], value, where, ends)
    if isinstance(value, dict) and made:
        there = {each.name for each in fields(type_)}
        if odd := sorted(({*value} - there) | (there - {*value, *_LATER})):
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


def _check(card: Card) -> None:
    """Raise a ValueError for values of a card that have the right types but are impossible."""
    names = [each.name for each in card.lines]
    if not names or len({*names}) < len(names):
        raise ValueError(f"it must have lines of different names, got {', '.join(names) or 'none'}")
    if lacking := sorted({*_COUNTED} - {*card.cost}):
        raise ValueError(f"its cost lacks {', '.join(lacking)}")
    for line in card.lines:
        for each in filter(None, (line, line.silence)):
            ends = [end for end in (each.low, each.score, each.high) if end is not None]
            if len(ends) == 2 or ends != sorted(ends):
                raise ValueError(f"the line {line.name} must have a score in its interval, got {ends}")
            if each.score is not None and each.seeds < LEAST:
                raise ValueError(f"the line {line.name} must have a score by {LEAST} seeds at least, got {each.seeds}")


def checksum(values: Any) -> str:
    """A digest of JSON values."""
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:16]
