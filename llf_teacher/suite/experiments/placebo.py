"""Is not moved by words that say nothing of the task.

A placebo beside silence. The score is 1 if both lose as much, and less if the placebo costs; the unit is what a
truthful teacher saves beside silence.
"""

from llf_teacher.suite.experiment import Experiment
from llf_teacher.suite.places import ARMS, HOUSE, OPTIONS

EXPERIMENT = Experiment(
    ability="is not moved by words that say nothing",
    better="silent",
    worse="oracle | placebo",
    reference="obedient",
    offset=1.0,
    margin=0.2,
    unit=("oracle", "silent"),
    ids=(ARMS, HOUSE),
    options=OPTIONS,
)
