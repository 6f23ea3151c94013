"""Leaves something for new worlds: the regret that it saves in the next world of a town, where it is absent.

Why: advice serves once, a rule again. A student that keeps rules has one lesson in a world, then plays for 24 turns in
another of the same town without a teacher. Each seed has a town of its own. 0: as after a lesson in silence; 1: as
after a lesson of rules and clues. Prerequisite: a family with towns. Confounds: the student keeps rules that are
claims, and no others.
"""

import numpy as np

from llf_teacher.suite.mirror.population import KEEPER
from llf_teacher.suite.mirror.quality import Quality, TaughtWorld, by_world


def _later(world: TaughtWorld) -> float:
    return float(np.sum(world.silent[0].regrets) - np.sum(world.taught[0].regrets))


QUALITY = Quality(
    ability="leaves something for new worlds",
    outcome=by_world(_later),
    absent="no test was played",
    students=(KEEPER,),
    reference="ruler",
    town=True,
    turns=24,
)
