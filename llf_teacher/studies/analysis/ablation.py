"""Ablation of kinds of feedback: what each kind adds to the others.

A study whose feedback types are all subsets of some kinds (`feedback_types = "subsets"`: of all five) measures for each
subset how much regret it saves a student beside no feedback. A kind's share of this gain is its Shapley value (Shapley
1953): what it adds to the kinds before it, averaged over all orders of the kinds. The shares sum to the gain of all
kinds.
"""

import itertools
from collections.abc import Iterator, Mapping
from math import factorial
from typing import NamedTuple

import numpy as np

from llf_teacher.studies.analysis.outcomes import Group, Numbers, Outcomes, Pair, paired
from llf_teacher.studies.analysis.statistics import Estimate, mean_interval
from llf_teacher.studies.definition.design import SUBSETS
from teachers.atoms import KINDS
from teachers.feedback import MIXED, format_kinds, parse_kinds


class Ablation(NamedTuple):
    """The gains of one student with one teacher, by kinds of feedback."""

    group: Group
    """Its feedback type has all kinds of the ablation."""
    teacher: str
    student: str
    gains: dict[str, Estimate]
    """Regret without feedback minus that with a subset on the same seeds, by feedback type, in the family's unit."""
    shares: dict[str, Estimate]
    """Each kind's part of the gain of all, in the family's unit."""
    total: Estimate
    """The gain of all kinds."""


def shapley(values: Mapping[frozenset[str], Numbers]) -> dict[str, Numbers]:
    """Shapley values of the players of a game.

    Args:
        values: the worth of each subset of the players, a number or an array; every subset must be there.

    Raises:
        ValueError: a subset is missing.
    """
    players = sorted(frozenset().union(*values))
    n = len(players)
    subsets = [frozenset(chosen) for size in range(n + 1) for chosen in itertools.combinations(players, size)]
    if missing := [sorted(subset) for subset in subsets if subset not in values]:
        raise ValueError(f"values must have every subset of {', '.join(players)}, got none for {missing[0]}")
    found = {}
    for player in players:
        without = [subset for subset in subsets if player not in subset]
        added = [
            (values[subset | {player}] - values[subset])
            * (factorial(len(subset)) * factorial(n - len(subset) - 1) / factorial(n))
            for subset in without
        ]
        found[player] = np.sum(added, axis=0)
    return found


def ablations(found: Outcomes) -> Iterator[Ablation]:
    """The ablations of a study: one wherever all subsets of at least two kinds were played on a common seed."""
    together: dict[Group, list[Group]] = {}
    for group in found:
        if group.feedback_type != MIXED:
            together.setdefault(group._replace(feedback_type=""), []).append(group)
    for common, groups in together.items():
        by_kinds = {frozenset(map(str, parse_kinds(group.feedback_type))): group for group in groups}
        kinds = frozenset().union(*by_kinds)
        if len(kinds) < 2 or len(by_kinds) < 2 ** len(kinds):
            continue
        whole = common._replace(feedback_type=format_kinds(kinds))
        for pair in found[by_kinds[kinds]]:
            if all(pair in found[group] for group in by_kinds.values()):
                yield from _ablation(found, whole, by_kinds, pair)


def _place(kinds: frozenset[str]) -> int:
    return SUBSETS.index(format_kinds(kinds))


def _ablation(
    found: Outcomes, whole: Group, by_kinds: Mapping[frozenset[str], Group], pair: Pair
) -> Iterator[Ablation]:
    cells = dict(zip(by_kinds, paired(*(found[group][pair] for group in by_kinds.values())), strict=True))
    nothing = cells[frozenset()].regret
    if not len(nothing):
        return
    gains = {kinds: nothing - cell.regret for kinds, cell in cells.items()}
    shares = shapley(gains)
    yield Ablation(
        whole,
        *pair,
        gains={format_kinds(kinds): mean_interval(gains[kinds]) for kinds in sorted(gains, key=_place)},
        shares={kind: mean_interval(shares[kind]) for kind in KINDS if kind in shares},
        total=mean_interval(gains[frozenset(shares)]),
    )
