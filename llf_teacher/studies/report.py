"""The report of a study: what a store holds of it, as one HTML page that needs nothing else."""

import hashlib
import json
import os
import sqlite3
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
import numpy as np
from numpy.typing import NDArray

from llf_teacher.student import TAUGHT, parse_student
from llf_teacher.studies import statistics
from llf_teacher.studies.plots import SHADES, curve_plot, dot_plot
from llf_teacher.studies.statistics import Difference, Estimate, Split, variance_split
from llf_teacher.studies.store import Store
from llf_teacher.studies.study import Grid, Study
from pz_envs.family import Family, all_families
from teachers.atoms import FP, KINDS, Label

REFERENCE = "silent"
"""The teacher that others are compared with."""
_KIND_NAMES = {
    "r": "reward",
    "hp": "hindsight positive: what was good",
    "hn": "hindsight negative: what was bad",
    "fp": "future positive: what to do",
    "fn": "future negative: what to avoid",
    None: "instruction or notice",
}
_CURVES = 8
"""Curves in a panel that can be told apart."""
_MARKS = {
    Label.TRUTHFUL: "✓ true",
    Label.LATE: "✓ true, late",
    Label.PLACEBO: "✓ true, placebo",
    Label.DISTORTED: "✗ false",
}


class Played(NamedTuple):
    """An episode as the report needs it."""

    row: sqlite3.Row
    """As `Store.episodes` gives it."""
    curve: NDArray[np.float64]
    """Cumulative regret after each turn, shape (max_turns,); it stays as it is after the end."""
    said: Counter[str]
    """Number of claims by kind."""
    labels: Counter[str]
    """Number of claims by label."""
    advised: int
    """Turns before which the teacher advised actions."""
    followed: int
    """Those of them in which the student took one."""


class Cell(NamedTuple):
    """One teacher with one student: the seeds for which every environment of the section has been played."""

    seeds: tuple[int, ...]
    success: NDArray[np.bool_]
    """Success at the last turn, shape (seeds, environments)."""
    curves: NDArray[np.float64]
    """Cumulative regret averaged over the environments, shape (seeds, max_turns)."""

    @property
    def regrets(self) -> NDArray[np.float64]:
        """Cumulative regret at the end, shape (seeds,)."""
        return self.curves[:, -1]


@dataclass(frozen=True, kw_only=True)
class Section:
    """What a study says of one family under one instruction type and feedback type."""

    family: Family
    instruction_type: str
    feedback_type: str
    ids: tuple[str, ...]
    """Environments that have been played at all."""
    grid: Grid
    """The teachers, students and seeds that the study has for them."""
    cells: Mapping[tuple[str, str], Cell]
    """By teacher and student; one without a complete seed is missing."""
    episodes: tuple[Played, ...]

    part: int
    """Counts the sections of the same family and types from 0: environments with other grids are told apart."""

    @property
    def anchor(self) -> str:
        """The section's id within the page."""
        name = f"{self.family.name}-{self.instruction_type}-{self.feedback_type}".replace("+", "-")
        return f"{name}-{self.part}" if self.part else name

    @property
    def digits(self) -> int:
        """Decimals for regrets: three figures of the greatest mean."""
        greatest = max((estimate.mean for estimate in self.regret.values()), default=0)
        return 1 if greatest >= 10 else 2

    @cached_property
    def success(self) -> dict[tuple[str, str], Estimate]:
        """Share of successes, 0 to 1, per cell."""
        return {key: statistics.success_interval(cell.success) for key, cell in self.cells.items()}

    @cached_property
    def regret(self) -> dict[tuple[str, str], Estimate]:
        """Final cumulative regret, in the family's unit, per cell."""
        return {key: statistics.mean_interval(cell.regrets) for key, cell in self.cells.items()}

    @cached_property
    def differences(self) -> dict[tuple[str, str], Difference]:
        """Regret less that under `REFERENCE` on the same seeds, for students whom teachers can reach; p-values are
        adjusted for the number of these differences.
        """  # noqa: D205
        found = {}
        for (teacher, student), cell in self.cells.items():
            other = self.cells.get((REFERENCE, student))
            if teacher == REFERENCE or other is None or reads(student) not in TAUGHT:
                continue
            seeds = [seed for seed in cell.seeds if seed in other.seeds]
            if seeds:
                pair = (c.regrets[[c.seeds.index(seed) for seed in seeds]] for c in (cell, other))
                found[teacher, student] = statistics.paired_difference(*pair)
        adjusted = statistics.holm([difference.p for difference in found.values()])
        return {key: found[key]._replace(p=p) for key, p in zip(found, adjusted, strict=True)}

    @property
    def dots(self) -> str:
        """Plot of success and regret, as SVG."""
        names = self.grid.teachers, self.grid.students
        return dot_plot(*names, self.success, self.regret, self.family.regret_unit, f"{self.anchor}-d")

    @property
    def curves(self) -> str:
        """Plot of cumulative regret over turns, as SVG."""
        panels = {
            label(student): {
                teacher: statistics.mean_band(self.cells[teacher, student].curves)
                for teacher in self.drawn
                if (teacher, student) in self.cells
            }
            for student in self.grid.students
        }
        return curve_plot(panels, self.drawn, self.family.regret_unit, f"{self.anchor}-c")

    @cached_property
    def drawn(self) -> tuple[str, ...]:
        """The teachers whose curves are drawn: all, or if they are too many to be told apart, `REFERENCE` and others
        from the one with whom the regret of `reader` is least to the one with whom it is greatest, evenly spread.
        """  # noqa: D205
        if len(self.grid.teachers) <= _CURVES:
            return self.grid.teachers
        others = [t for t in self.grid.teachers if t != REFERENCE and (t, self.reader) in self.cells]
        ranked = sorted(others, key=lambda teacher: self.regret[teacher, self.reader].mean)
        room = min(_CURVES - (REFERENCE in self.grid.teachers), len(ranked))
        chosen = {ranked[rank] for rank in np.linspace(0, len(ranked) - 1, room).round().astype(int)} | {REFERENCE}
        return tuple(teacher for teacher in self.grid.teachers if teacher in chosen)

    @cached_property
    def split(self) -> Split | None:
        """How the variance of regret splits between teachers and students; None unless every cell has been played."""
        pairs = [self.cells.get(pair) for pair in product(self.grid.teachers, self.grid.students)]
        cells = [cell for cell in pairs if cell is not None]
        seeds = set.intersection(*(set(cell.seeds) for cell in cells)) if len(cells) == len(pairs) else set()
        if not seeds:
            return None
        regrets = [[r for seed, r in zip(cell.seeds, cell.regrets, strict=True) if seed in seeds] for cell in cells]
        return variance_split(np.reshape(regrets, (len(self.grid.teachers), len(self.grid.students), len(seeds))))

    @cached_property
    def reader(self) -> str:
        """The student to look at closely: one who reads words if any, else atoms, else any."""
        played = [student for student in self.grid.students if any(e.row["student"] == student for e in self.episodes)]
        return min(played, key=lambda student: (*TAUGHT, reads(student)).index(reads(student)))

    @cached_property
    def contrast(self) -> tuple[str, ...]:
        """Two teachers of `reader`: of the truthful ones the one with whom regret is least, and the one whose claims
        hold least. If all are truthful, the second is the one with whom regret is greatest; if one has played, it.
        """  # noqa: D205
        ranks = {}
        for teacher in self.grid.teachers:
            taught = [e for e in self.episodes if (e.row["teacher"], e.row["student"]) == (teacher, self.reader)]
            if taught:
                ranks[teacher] = (share_held(taught), -np.mean([episode.curve[-1] for episode in taught]))
        spoke = [teacher for teacher, (held, _) in ranks.items() if held is not None] or list(ranks)
        order = sorted(spoke, key=lambda teacher: ranks[teacher], reverse=True)
        return tuple(dict.fromkeys((order[0], order[-1])))

    @property
    def transcripts(self) -> list[Played]:
        """The first episode of `reader` with each teacher of `contrast`."""
        pairs = [(teacher, self.reader) for teacher in self.contrast]
        return [next(e for e in self.episodes if (e.row["teacher"], e.row["student"]) == pair) for pair in pairs]


class Account(NamedTuple):
    """What a teacher said, over all episodes of some sections."""

    teacher: str
    episodes: int
    per_turn: dict[str, float]
    """Claims per turn of the student, by kind; what is said at the opening counts."""
    labels: dict[str, float]
    """Share of the claims by label; none if there are no claims."""
    uptake: float | None
    """Of the turns before which a student who can be reached was advised an action, the share in which it took one;
    None if there are none.
    """
    words: float
    """Words of feedback per turn of the student."""
    parse_failures: int
    """Answers of students that were no action."""
    turns: int


def reads(student: str) -> str:
    """What a student learns from, one of `llf_teacher.student.READS`."""
    return parse_student(student).reads


def label(student: str) -> str:
    """A student's spec and what it reads."""
    return f"{student} (reads {reads(student)})"


def digest(spec: str) -> str:
    """Short hash of a spec."""
    return hashlib.sha256(spec.encode()).hexdigest()[:8]


def share_held(episodes: Iterable[Played]) -> float | None:
    """Share of the claims of episodes that hold, 0 to 1; None if there are none."""
    counts = [(episode.row["claims_held"], episode.row["claims"]) for episode in episodes]
    held, said = (sum(count) for count in zip(*counts, strict=True)) if counts else (0, 0)
    return held / said if said else None


def to_toml(study: Study) -> str:
    """The study as a file for `llf study run`."""
    values = study.as_dict()
    fewer = values.pop("fewer")
    lines = _assignments(values)
    for pattern, lists in fewer.items():
        lines += ["", f"[fewer.{json.dumps(pattern)}]", *_assignments(lists)]
    return "\n".join(lines) + "\n"


def _assignments(values: Mapping[str, Any]) -> list[str]:
    lines = []
    for name, value in values.items():
        if name == "seeds" and value == list(range(len(value))):
            lines.append(f"{name} = {len(value)}")
        elif isinstance(value, list) and len(value) > 1:
            items = "".join(f"    {json.dumps(item)},\n" for item in value)
            lines.append(f"{name} = [\n{items}]")
        elif value is not None:
            lines.append(f"{name} = {json.dumps(value)}")
    return lines


def check_writable(path: Path) -> None:
    """Refuse a path where no report can be written, before time is spent on a study.

    Raises:
        ValueError: it is a folder, or its folder is missing or cannot be written.
    """
    if path.is_dir():
        raise ValueError(f"cannot write the report to {path}: it is a folder; give the name of a file")
    folder = path.absolute().parent
    if not folder.is_dir():
        raise ValueError(f"cannot write the report to {path}: there is no folder {folder}; make it first")
    if not os.access(folder, os.W_OK):
        raise ValueError(f"cannot write the report to {path}: the folder {folder} is not writable")


def write_report(store: Store, study: Study, path: Path) -> None:
    """Write what a store holds of a study as one HTML file; the file is replaced as a whole.

    Raises:
        ValueError: no episode of the study has been played, or the path cannot be written.
    """
    check_writable(path)
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        draft.write_text(render(store, study), encoding="utf-8", newline="\n")
        os.replace(draft, path)
    finally:
        draft.unlink(missing_ok=True)


def render(store: Store, study: Study) -> str:
    """The report as HTML; the same episodes give the same text.

    Raises:
        ValueError: no episode of the study has been played.
    """
    specs = list(study.episodes())
    rows = store.episodes({spec.key for spec in specs})
    if not rows:
        raise ValueError(f"{store.path} holds no episode of this study; run it first")
    found = list(_sections(study, [_played(store, row) for row in rows]))
    pairs = dict.fromkeys((section.instruction_type, section.feedback_type) for section in found)
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("llf_teacher", "studies"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"digest": digest, "label": label, "reads": reads, "number": _number, "percent": _percent}
    return environment.get_template("report.html.j2").render(
        study=study,
        sections=found,
        accounts={pair: list(_accounts(study, _of_pair(found, pair))) for pair in pairs},
        present=len(rows),
        expected=len(specs),
        manifest=store.manifest(),
        toml=to_toml(study),
        shades=SHADES,
        kinds=KINDS,
        kind_names=_KIND_NAMES,
        marks=_MARKS,
        taught=TAUGHT,
        labels=tuple(_MARKS),
        reference=REFERENCE,
        turns=lambda episode: _turns(store, episode),
    )


def _played(store: Store, row: sqlite3.Row) -> Played:
    regrets = np.zeros(row["max_turns"])
    said: Counter[str] = Counter()
    labels: Counter[str] = Counter()
    advised = followed = 0
    advice: list[Any] = []
    for turn in store.turns(row["key"]):
        if turn["turn"]:
            regrets[turn["turn"] - 1] = turn["regret"]
            advised += bool(advice)
            followed += turn["action"] in advice
        feedback = [atom for atom in turn["atoms"] if atom["kind"] is not None]
        said.update(atom["kind"] for atom in feedback)
        labels.update(atom["label"] for atom in feedback)
        current = (atom for atom in feedback if atom["kind"] == FP and atom["about_turn"] == turn["turn"])
        advice = [atom["fields"]["action"] for atom in current if "action" in atom["fields"]]
    return Played(row, np.cumsum(regrets), said, labels, advised, followed)


def _sections(study: Study, episodes: Sequence[Played]) -> Iterator[Section]:
    pairs = product(study.instruction_types, study.feedback_types)
    for family, (instruction_type, feedback_type) in product(all_families(), pairs):
        group = (family.name, instruction_type, feedback_type)
        mine = [e for e in episodes if (e.row["family"], e.row["instruction_type"], e.row["feedback_type"]) == group]
        ids = [id for id in study.ids if any(episode.row["id"] == id for episode in mine)]
        for part, grid in enumerate(dict.fromkeys(map(study.grid, ids))):
            alike = tuple(id for id in ids if study.grid(id) == grid)
            played = [episode for episode in mine if episode.row["id"] in alike]
            cells = {}
            for teacher, student in product(grid.teachers, grid.students):
                cell = _cell([e for e in played if (e.row["teacher"], e.row["student"]) == (teacher, student)], alike)
                if cell.seeds:
                    cells[teacher, student] = cell
            yield Section(
                family=family,
                instruction_type=instruction_type,
                feedback_type=feedback_type,
                ids=alike,
                grid=grid,
                part=part,
                cells=cells,
                episodes=tuple(played),
            )


def _cell(episodes: Iterable[Played], ids: Sequence[str]) -> Cell:
    table = {(episode.row["seed"], episode.row["id"]): episode for episode in episodes}
    seeds = tuple(seed for seed in sorted({seed for seed, _ in table}) if all((seed, id) in table for id in ids))
    complete = [[table[seed, id] for id in ids] for seed in seeds]
    return Cell(
        seeds,
        np.array([[bool(episode.row["success"]) for episode in row] for row in complete]),
        np.array([np.mean([episode.curve for episode in row], axis=0) for row in complete]),
    )


def _of_pair(sections: Iterable[Section], pair: tuple[str, str]) -> list[Played]:
    fitting = (section for section in sections if (section.instruction_type, section.feedback_type) == pair)
    return [episode for section in fitting for episode in section.episodes]


def _accounts(study: Study, episodes: Sequence[Played]) -> Iterator[Account]:
    for teacher in study.teachers:
        mine = [episode for episode in episodes if episode.row["teacher"] == teacher]
        if not mine:
            continue
        turns = sum(episode.row["turns"] for episode in mine)
        said = sum((episode.said for episode in mine), Counter())
        labels = sum((episode.labels for episode in mine), Counter())
        reached = [episode for episode in mine if episode.row["reads"] in TAUGHT]
        advised = sum(episode.advised for episode in reached)
        yield Account(
            teacher=teacher,
            episodes=len(mine),
            per_turn={kind: said[kind] / turns for kind in KINDS},
            labels={label: labels[label] / labels.total() for label in _MARKS} if labels else {},
            uptake=sum(episode.followed for episode in reached) / advised if advised else None,
            words=sum(episode.row["words"] for episode in mine) / turns,
            parse_failures=sum(episode.row["parse_failures"] for episode in mine),
            turns=turns,
        )


def _turns(store: Store, episode: Played) -> Iterator[dict[str, Any]]:
    """The turns of an episode for a transcript, with `said`, atoms by kind, each with its claim as `code`, and
    `spelled_out`, whether these make up all of the text.
    """  # noqa: D205
    for turn in store.turns(episode.row["key"]):
        atoms = turn["atoms"]
        for atom in atoms:
            fields = ", ".join(f"{name}={_plain(value)}" for name, value in atom["fields"].items())
            atom["code"] = f"{atom['claim']}({fields})"
        text = " ".join(filter(None, (turn["instruction"], turn["feedback"])))
        turn["said"] = {kind: said for kind in (None, *KINDS) if (said := [a for a in atoms if a["kind"] == kind])}
        turn["spelled_out"] = text == " ".join(atom["text"] for atom in atoms)
        turn["did"] = turn["action_words"] or turn["action"]
        yield turn


def _plain(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)


def _number(value: float, digits: int = 1) -> str:
    """A number with a proper minus sign, and no sign at zero."""
    text = f"{value:.{digits}f}"
    return text.removeprefix("-") if float(text) == 0 else text.replace("-", "\N{MINUS SIGN}")


def _percent(share: float) -> str:
    return f"{100 * share:.0f}"
