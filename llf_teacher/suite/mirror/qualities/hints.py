"""Hints without giving the answer away: of its help, the share that says something new and leaves the action open.

Why: what a student finds itself it can find again. Help is advice and warnings (fp, fn) that are news, as in `news`,
and every advice that names the action, which is an answer. 0: answers only; 1: hints only, as of the reference.
Prerequisite: a family with a posterior. Confounds: whether the student can use a hint does not count; `worth` has it.
"""

from llf_teacher.suite.mirror.population import OBEDIENT, REASONER
from llf_teacher.suite.mirror.quality import Quality, TaughtWorld, by_world, is_new, mean


def _open(world: TaughtWorld) -> float:
    helps = [atom for each in world.taught for atom in each.claims("fp", "fn") if "information" in atom]
    answers = [atom["kind"] == "fp" and atom["action"] is not None for atom in helps]
    return mean([not answer for answer, atom in zip(answers, helps, strict=True) if answer or is_new(atom)])


QUALITY = Quality(
    ability="hints without giving the answer away",
    outcome=by_world(_open),
    absent="it gave no advice and no clue whose information is known",
    students=(OBEDIENT, REASONER),
    reference="ruler",
    bits=32,
)
