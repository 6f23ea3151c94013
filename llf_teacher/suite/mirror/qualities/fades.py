"""Fades: says less as the student learns, and only then.

Why: who is always helped does not learn to do without. Counted are claims about the task in the first half of the turns
less those in the second, as a share of both, with students that learn; less the same with one that learns nothing, so
that falling silent by the clock is no fading. 0: as much to the end; 1: as a teacher that speaks after mistakes only.
Rests on truth, timing and use, without which nothing is learned, and on adapting. With films in place of a house,
where each room asks for another move, so that the students need help to the end.
"""

from collections.abc import Sequence

import numpy as np

from llf_teacher.suite.mirror.population import DEAF, OBEDIENT, READER
from llf_teacher.suite.mirror.quality import Quality, TaughtEpisode, TaughtWorld, by_world, claims_of
from llf_teacher.suite.places import ARMS, FILMS


def _fading(episodes: Sequence[TaughtEpisode]) -> float:
    early = late = 0
    for each in episodes:
        said = [len(claims_of(turn)) for _, turn in each.between()]
        half = len(said) // 2
        early, late = early + sum(said[:half]), late + sum(said[len(said) - half :])
    return (early - late) / (early + late) if early + late else np.nan


def _contrast(world: TaughtWorld) -> float:
    return _fading(world.taught[:-1]) - float(np.nan_to_num(_fading(world.taught[-1:])))


QUALITY = Quality(
    ability="says less as the student learns",
    outcome=by_world(_contrast),
    absent="it made no claim after a turn",
    students=(OBEDIENT, READER, DEAF),
    reference="mistake_correcting(budget=100, threshold=0.0)",
    rests_on=("truth", "use", "timing", "adapts"),
    ids=(ARMS, FILMS),
)
