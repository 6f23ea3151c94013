"""The information of teachers' claims in bits, and the regret that it saved, by family."""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from llf_teacher.registry import entry
from llf_teacher.studies.analysis.statistics import Estimate, ratio_interval
from llf_teacher.studies.definition.design import main_types
from llf_teacher.studies.report.columns import INFORMATION, columns
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.parts.part import Part
from teachers.atoms import KINDS

Numbers = NDArray[np.float64]


class Informed(NamedTuple):
    """The information of a teacher's claims in a family, over the seeds at which each of its settings was measured."""

    teacher: str
    claims: int
    """Number of measured claims."""
    unmeasured: int
    """Number of claims without a measurement: too few worlds were found."""
    at_least: int
    """Number of claims that were false in all worlds."""
    per_turn: Estimate | None
    """Bits in a turn of the student; None without turns, and likewise below."""
    kinds: dict[str, float]
    """Bits in a turn of the student, by kind."""
    per_word: Estimate | None
    """Bits in a word."""
    saved: Estimate | None
    """Regret that a bit saves in the next action."""


class _Group(NamedTuple):
    """A table of the information in a family under one instruction type and feedback type."""

    family: str
    instruction_type: str
    feedback_type: str


def _informed(teacher: str, seeds: Iterable[Iterable[Numbers]]) -> Informed | None:
    """The account of a teacher, of the columns of `INFORMATION` by seed and episode; None without a whole seed."""
    tables = [np.array(list(rows)) for rows in seeds]
    most = max(map(len, tables))
    sums = np.array([table.sum(axis=0) for table in tables if len(table) == most and not np.isnan(table).any()])
    if not sums.size:
        return None
    of = dict(zip(INFORMATION, sums.T, strict=True))
    return Informed(
        teacher=teacher,
        claims=int(of["measured"].sum()),
        unmeasured=int(of["unmeasured"].sum()),
        at_least=int(of["at_least"].sum()),
        per_turn=ratio_interval(of["bits"], of["turns"]),
        kinds={kind: of[f"bits_{kind}"].sum() / of["turns"].sum() for kind in KINDS},
        per_word=ratio_interval(of["bits"], of["measured_words"]),
        saved=ratio_interval(of["saved"], of["valued_bits"]),
    )


def _values(data: Data) -> Mapping[str, Any] | None:
    if not data.study.draws:
        return None
    found: dict[_Group, dict[str, dict[int, list[Numbers]]]] = {}
    reasons: dict[tuple[str, str], list[str]] = {}
    types = main_types(data.study.feedback_types)
    with columns(data.store, data.planned) as there:
        for setting, seed, why, values in there.information():
            family = entry(setting.id).family.name
            if why:
                alike = reasons.setdefault((family, why), [])
                alike += [setting.id] * (setting.id not in alike)
            elif not setting.lessons and setting.feedback_type in types:
                group = _Group(family, setting.instruction_type, setting.feedback_type)
                found.setdefault(group, {}).setdefault(setting.teacher, {}).setdefault(seed, []).append(values)
    tables = {
        group: [each for name in data.study.teachers if name in rows and (each := _informed(name, rows[name].values()))]
        for group, rows in sorted(found.items())
    }
    return {"tables": tables, "reasons": dict(sorted(reasons.items())), "kinds": KINDS, "draws": data.study.draws}


PART = Part("information", _values, "How much was said")
