"""Combines hints: acts on words that are vague at first.

Lessons of a teacher that hints and is precise only if that does not help, beside a placebo. It rests on advice, which
the last hint is.
"""

from llf_teacher.suite.experiment import Experiment
from llf_teacher.suite.places import ARMS, HOUSE, OPTIONS

EXPERIMENT = Experiment(
    ability="acts on hints",
    better="hinter",
    worse="hinter | placebo",
    reference="obedient",
    rests_on=("advice",),
    ids=(ARMS, HOUSE),
    options=OPTIONS,
)
