"""Keeps what it was taught after the teacher falls silent.

A teacher that advises before the first turn and says nothing after, beside a placebo; the regret from the third turn on
counts. In bandits the named arm stays the best one; in a house the student has to know what the words say about the
treasure. It rests on advice.
"""

from llf_teacher.suite.experiment import Experiment
from llf_teacher.suite.places import ARMS, HOUSE, OPTIONS

EXPERIMENT = Experiment(
    ability="keeps what it was taught when the teacher falls silent",
    better="early(budget=1)",
    worse="early(budget=1) | placebo",
    reference="reasoner(worlds=64)",
    since=2,
    rests_on=("advice",),
    ids=(ARMS, HOUSE),
    options=OPTIONS,
)
