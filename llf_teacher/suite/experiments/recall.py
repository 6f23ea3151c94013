"""Recalls in a later episode what it was taught in an earlier one.

A test without a teacher, in the same world as the lesson before, which had advice or a placebo. Only the test counts.
It rests on advice, and, since the test has no teacher, on keeping what was said in silence. A student that forgets
between episodes is not measured.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="recalls in a later episode what it was taught",
    better="only(kinds='fp')",
    worse="only(kinds='fp') | placebo",
    reference="obedient(forget=False)",
    lessons=1,
    rests_on=("advice", "silence"),
)
