"""Keeps what it was taught after the teacher falls silent.

Why: teachers leave. Advice before the first turn and none after, beside a placebo, in 20 bandits and with 20 lists of
films; the regret from the third turn on counts. The advice stays the best to the end, so that only keeping it is
measured: in a house each room asks for another move, and to keep the first does harm. Rests on advice. Confounds: a
student that repeats its first action by habit keeps the advice, too.
"""

from llf_teacher.suite.environments import ARMS, FILMS
from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="keeps what it was taught when the teacher falls silent",
    better="only(kinds='fp') | early(budget=1)",
    reference="obedient",
    since=2,
    rests_on=("advice",),
    ids=(ARMS, FILMS),
)
ASKED = (
    "The teacher says once, before the first turn, which action is best, and then nothing; what is done "
    "from the third turn on counts."
)
"""What the student is asked, in plain words for a card."""
