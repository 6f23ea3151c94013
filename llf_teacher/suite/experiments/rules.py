"""Carries rules to new worlds of a town.

A test without a teacher in another world of the same town as the lesson before, which had clues, some of them rules of
the town, or a placebo. The rules say which arms pay more by their looks, or in what rooms treasures lie. Only the test
counts. They are said as advice and warnings, on which it rests, and, since the test has no teacher, on keeping what was
said in silence. A student that forgets between episodes is not measured.
"""

from llf_teacher.suite.experiment import Experiment
from llf_teacher.suite.places import TOWN

EXPERIMENT = Experiment(
    ability="carries rules to new worlds of a town",
    better="ruler",
    worse="ruler | placebo",
    reference="reasoner(worlds=64, forget=False)",
    lessons=1,
    worlds="next",
    rests_on=("advice", "warnings", "silence"),
    options=TOWN,
)
