"""Speaks when it is needed: the regret that it saves students that hear only three of its turns.

Why: attention is a budget. They forget by chance, and hear the first three turns in which something is said; a teacher
that knows when to speak keeps them for mistakes. 0: it saves nothing; 1: as advice after each mistake, since before a
student has forgotten nothing is to be said, and after it nothing is more urgent. Rests on truth and use, and on
adapting and fading: words after right actions use up attention.
"""

from llf_teacher.suite.mirror.population import ATTENTIVE
from llf_teacher.suite.mirror.quality import Quality, by_world

QUALITY = Quality(
    ability="speaks when it is needed",
    outcome=by_world(lambda world: world.saved),
    absent="it said nothing",
    students=ATTENTIVE,
    reference="only(kinds='fp') | mistake_correcting(budget=100, threshold=0.0)",
    rests_on=("truth", "use", "adapts", "fades"),
)
