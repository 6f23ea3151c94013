"""Heeds warnings: does not do what the teacher says to avoid next.

Lessons of warnings (fn) beside a placebo. A warning leaves several actions, so the reference weighs in which worlds the
warning would be said.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="heeds warnings",
    better="only(kinds='fn')",
    worse="only(kinds='fn') | placebo",
    reference="reasoner(worlds=64)",
)
