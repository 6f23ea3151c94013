"""Says what its students can use: the regret that it saves beside silence, a bit.

Why: what is new and of no use is a burden. With students that do what is named, and nothing else. The bits are those of
all claims, the regret is that of all turns; over worlds it is the ratio of their means, of which each world has its
linear part (Cochran 1977, section 6.4). 0: it saves nothing; 1: as much a bit as advice. Prerequisite: a family with a
posterior. Rests on truth and timing, and on calibration, since a false certainty has more bits and saves no more.
Confounds: what is known has no bits, and costs nothing here; students that combine hints can use more. The bits of
words that were read are not known: a world in which there are some does not count.
"""

from collections.abc import Sequence

import numpy as np

from llf_teacher.suite.mirror.population import OBEDIENT, READER
from llf_teacher.suite.mirror.quality import Quality, TaughtWorld, bits_of
from llf_teacher.suite.score import Numbers


def _per_bit(worlds: Sequence[TaughtWorld]) -> Numbers:
    saved = np.array([world.saved for world in worlds])
    said = ([atom for each in world.taught for atom in each.claims()] for world in worlds)
    heard = [sum((bits_of(atom) or 0.0) if "information" in atom else np.nan for atom in atoms) for atoms in said]
    bits = np.where(np.isnan(saved), np.nan, heard)
    saved = np.where(np.isnan(bits), np.nan, saved)
    if not np.nansum(bits) > 0:
        return np.full(len(worlds), np.nan)
    ratio = np.nansum(saved) / np.nansum(bits)
    return np.asarray(ratio + (saved - ratio * bits) / np.nanmean(bits))


QUALITY = Quality(
    ability="says what its students can use",
    outcome=_per_bit,
    absent="it made no claim whose information is known",
    students=(OBEDIENT, READER),
    reference="only(kinds='fp')",
    bits=32,
    rests_on=("truth", "calibration", "timing"),
)
