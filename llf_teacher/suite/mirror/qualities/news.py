"""Says news: of its claims about the task, the share that says something that the student could not know.

Why: what was said or seen already is a waste. A claim is news if it is improbable by at least a tenth of a bit in the
worlds that agree with all that the student saw and heard. 0: nothing is news; 1: as much as of clues, each said once.
Prerequisite: a family with a posterior. Rests on use, since what helps not must be said again, on timing, adapting
and fading: what comes late or after a right action is mostly known, and on hints: once the answer is given, there is
little left that is news. Confounds: false claims are news, too; truth tells them apart.
"""

from llf_teacher.suite.mirror.population import OBEDIENT, REASONER
from llf_teacher.suite.mirror.quality import Quality, TaughtWorld, by_world, is_new, mean


def _new(world: TaughtWorld) -> float:
    found = [is_new(atom) for each in world.taught for atom in each.claims()]
    return mean([each for each in found if each is not None])


QUALITY = Quality(
    ability="says news",
    outcome=by_world(_new),
    absent="it made no claim whose information is known",
    students=(OBEDIENT, REASONER),
    reference="ruler",
    bits=32,
    rests_on=("use", "timing", "adapts", "fades", "hints"),
)
