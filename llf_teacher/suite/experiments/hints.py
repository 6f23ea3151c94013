"""Combines hints: acts on clues, none of which names the action.

One new clue a turn, such as a list of arms or a room without a treasure, beside a placebo. Clues are said as advice
and warnings, so that it rests on both; and once all are said the teacher is silent, so that it rests on keeping them.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="combines hints that name no action",
    better="ruler",
    worse="ruler | placebo",
    reference="reasoner(worlds=64)",
    rests_on=("advice", "warnings", "silence"),
)
