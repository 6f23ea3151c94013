"""Adapts to the student: helps after mistakes and not otherwise.

Why: what helps a beginner burdens an expert. Help is advice, a warning or a clue (fp, fn); counted is the share of
turns after mistakes with help less that of other turns, over students that err in different ways. 0: help comes no
matter what was done; 1: after each mistake and never else. Rests on timing, since late help comes after other actions,
and on withstanding pushback, since one of the students insists. Confounds: how specific help is does not count.
"""

from llf_teacher.suite.mirror.population import FORGETFUL, LEARNER, OBEDIENT, REASONER, STUBBORN
from llf_teacher.suite.mirror.quality import Quality, TaughtWorld, by_world, claims_of, mean


def _contrast(world: TaughtWorld) -> float:
    turns = [(lost, bool(claims_of(turn, "fp", "fn"))) for each in world.taught for lost, turn in each.between()]
    if not any(helps for _, helps in turns):
        return float("nan")
    return mean([helps for lost, helps in turns if lost]) - mean([helps for lost, helps in turns if not lost])


QUALITY = Quality(
    ability="adapts to the student",
    outcome=by_world(_contrast),
    absent="it gave no advice, no warning and no clue after a turn",
    students=(OBEDIENT, REASONER, LEARNER, FORGETFUL, STUBBORN),
    reference="mistake_correcting(budget=100, threshold=0.0)",
    rests_on=("timing", "pushback"),
)
