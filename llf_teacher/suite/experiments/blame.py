"""Uses blame: acts by what the teacher says was bad.

Lessons of blame (hn) beside a placebo. The teacher is silent after a good action, so it rests on keeping what was said.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="uses blame",
    better="only(kinds='hn')",
    worse="only(kinds='hn') | placebo",
    reference="reasoner(worlds=64)",
    seeds=40,
    rests_on=("silence",),
)
