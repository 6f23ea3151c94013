"""Uses praise: acts by what the teacher says was good.

Lessons of praise (hp) beside a placebo. In bandits a student can repeat the arm; in a house a move cannot be repeated,
but it tells on which side the treasure is. The teacher is silent after a bad action, so it rests on keeping what was
said.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="uses praise",
    better="only(kinds='hp')",
    worse="only(kinds='hp') | placebo",
    reference="reasoner(worlds=64)",
    seeds=40,
    rests_on=("silence",),
)
