"""Hedges by as much as it knows: of what it calls 80 % probable, 80 % holds.

Why: a hedge says how far to trust. With students that leave a teacher in doubt. The squared difference between what is
said and what holds, in tenths of probability, estimated without bias by products of different worlds, since the
hedges of a world depend on each other. 0: as a teacher that knows what `partial` knows and claims 99 % of all; 1: no
difference. Confounds: a teacher that hedges only what is near 50 % risks little; the hedges of a house depend on each
other, so that few houses say little.
"""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from llf_teacher.suite.mirror.population import DEAF, LEARNER, OBEDIENT
from llf_teacher.suite.mirror.quality import Quality, TaughtWorld
from llf_teacher.suite.score import Numbers
from teachers.atoms import Label


def _agreement(worlds: Sequence[TaughtWorld]) -> Numbers:
    """Less the squared difference, for each world the product of its own with the mean of the others."""
    off: defaultdict[int, Numbers] = defaultdict(lambda: np.zeros(len(worlds)))
    said = np.zeros(len(worlds))
    for i, world in enumerate(worlds):
        for atom in (atom for each in world.taught for atom in each.claims() if atom["label"] == Label.HEDGED):
            p = atom["fields"]["p"]
            off[int(p * 10)][i] += p - atom["holds"]
            said[i] += 1
    there = said > 0
    n = int(there.sum())
    if n < 2:  # no others
        return np.full(len(worlds), np.nan)
    found = sum(-each * (each.sum() - each) / (n - 1) for each in off.values()) / said[there].mean() ** 2
    return np.where(there, found, np.nan)


QUALITY = Quality(
    ability="hedges by as much as it knows",
    outcome=_agreement,
    absent="it hedged nothing",
    students=(OBEDIENT, LEARNER, DEAF),
    reference="partial",
    zero="partial | overconfident(by=100.0)",
)
