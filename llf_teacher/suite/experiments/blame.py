"""Uses blame: acts by what the teacher says was bad.

Lessons of blame (hn) beside a placebo.
"""

from llf_teacher.suite.experiment import Experiment
from llf_teacher.suite.places import ARMS, HOUSE, OPTIONS

EXPERIMENT = Experiment(
    ability="uses blame",
    better="only(kinds='hn')",
    worse="only(kinds='hn') | placebo",
    reference="reasoner(worlds=64)",
    ids=(ARMS, HOUSE),
    options=OPTIONS,
)
