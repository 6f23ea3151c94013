"""Keeps what it was taught after the teacher falls silent.

A teacher that says all in three turns and nothing after, beside a placebo; only the regret after these turns counts.
In bandits the named arm stays the best one; in a house the student has to know what the words say about the treasure.
Most of what is said is advice, so it rests on that.
"""

from llf_teacher.suite.experiment import Experiment
from llf_teacher.suite.places import ARMS, HOUSE, OPTIONS

EXPERIMENT = Experiment(
    ability="keeps what it was taught when the teacher falls silent",
    better="early(budget=3)",
    worse="early(budget=3) | placebo",
    reference="reasoner(worlds=64)",
    since=3,
    rests_on=("advice",),
    ids=(ARMS, HOUSE),
    options=OPTIONS,
)
