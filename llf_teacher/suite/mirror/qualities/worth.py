"""Is worth its words: the regret that it saves beside silence, a word.

Why: reading costs, and a student stops. With the students that words can help. 0: it saves nothing; 1: as much a word
as advice after mistakes only. Rests on truth, use, and all that saves words: timing, news, adapting and fading.
Confounds: students that combine hints need fewer words, and the mean is over all; a teacher that says one word that
saves all has many times the reference.
"""

import numpy as np

from llf_teacher.suite.mirror.population import HEARERS
from llf_teacher.suite.mirror.quality import Quality, TaughtWorld, by_world


def _per_word(world: TaughtWorld) -> float:
    words = sum(each.words for each in world.taught)
    return world.saved / words if words else np.nan


QUALITY = Quality(
    ability="is worth its words",
    outcome=by_world(_per_word),
    absent="it said nothing",
    students=HEARERS,
    reference="only(kinds='fp') | mistake_correcting(budget=100, threshold=0.0)",
    rests_on=("truth", "use", "timing", "news", "adapts", "fades"),
)
