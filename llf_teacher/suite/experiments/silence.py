"""Keeps what it was taught after the teacher falls silent.

A teacher that gives advice before the first turn and says nothing after, beside a placebo; the regret from the third
turn on counts. The advice, an arm or films, stays the best to the end, so that only keeping it is measured: in a house
each room asks for another move, and to keep the first advice does harm. It rests on advice.
"""

from llf_teacher.suite.experiment import Experiment
from llf_teacher.suite.places import ARMS, FILMS

_TEACHER = "only(kinds='fp') | early(budget=1)"
EXPERIMENT = Experiment(
    ability="keeps what it was taught when the teacher falls silent",
    better=_TEACHER,
    worse=f"{_TEACHER} | placebo",
    reference="obedient",
    since=2,
    rests_on=("advice",),
    ids=(ARMS, FILMS),
)
