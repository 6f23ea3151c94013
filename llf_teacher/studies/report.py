"""The report of a study: what a store holds of it, as one HTML page that needs nothing else."""

import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import jinja2

from llf_teacher.students.student import TAUGHT
from llf_teacher.studies.plots import SHADES
from llf_teacher.studies.sections import (
    CHECKED,
    REFERENCE,
    Played,
    Section,
    accounts,
    label,
    played,
    reads,
    sections,
)
from llf_teacher.studies.store import Store
from llf_teacher.studies.study import Study
from llf_teacher.visible import visible
from teachers.atoms import KINDS, Label

_KIND_NAMES = {
    "r": "reward",
    "hp": "hindsight positive: what was good",
    "hn": "hindsight negative: what was bad",
    "fp": "future positive: what to do",
    "fn": "future negative: what to avoid",
    None: "instruction or notice",
}
_MARKS = {
    Label.TRUTHFUL: "✓ true",
    Label.LATE: "✓ true, late",
    Label.PLACEBO: "✓ true, placebo",
    Label.DISTORTED: "✗ false",
}


def digest(spec: str) -> str:
    """Short hash of a spec."""
    return hashlib.sha256(spec.encode()).hexdigest()[:8]


def to_toml(study: Study) -> str:
    """The study as a file for `llf study run`."""
    values = study.as_dict()
    fewer = values.pop("fewer")
    tables = {name: table for name in ("looks", "transfer") if (table := values.pop(name))}
    lines = _assignments(values)
    for name, table in tables.items():
        lines += ["", f"[{name}]", *_assignments(table)]
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
        ValueError: no episode of the study has been played, or parts of one are missing.
    """
    specs = list(study.episodes())
    store.check()
    rows = store.episodes({spec.key for spec in specs})
    if not rows:
        raise ValueError(f"{store.path} holds no episode of this study; run it first")
    found = list(sections(study, [played(row) for row in rows]))
    pairs = dict.fromkeys((section.instruction_type, section.feedback_type) for section in found)
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("llf_teacher", "studies"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"digest": digest, "label": label, "reads": reads, "number": _number, "percent": _percent}
    page = environment.get_template("report.html.j2").render(
        study=study,
        sections=found,
        accounts={pair: list(accounts(study, _of_pair(found, pair))) for pair in pairs},
        present=len(rows),
        expected=len(specs),
        manifest=store.manifest(),
        toml=to_toml(study),
        shades=SHADES,
        kinds=KINDS,
        kind_names=_KIND_NAMES,
        marks=_MARKS,
        taught=TAUGHT,
        labels=CHECKED,
        reference=REFERENCE,
        turns=lambda episode: _turns(store, episode),
    )
    return visible(page)


def _of_pair(found: Iterable[Section], pair: tuple[str, str]) -> list[Played]:
    fitting = (section for section in found if (section.instruction_type, section.feedback_type) == pair)
    return [episode for section in fitting for episode in section.episodes]


def _turns(store: Store, episode: Played) -> Iterator[dict[str, Any]]:
    """The turns of an episode for a transcript, with `said`, atoms by kind, each with its claim as `code`, and
    `spelled_out`, whether these make up all of the text.
    """  # noqa: D205
    for turn in store.turns(episode.row["key"]):
        atoms = turn["atoms"]
        for atom in atoms:
            fields = ", ".join(f"{name}={_plain(value)}" for name, value in atom["fields"].items())
            name = atom["claim"].removeprefix(f"{episode.row['family']}.")
            atom["code"] = f"{name}({fields})"
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
