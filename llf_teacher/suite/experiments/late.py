"""Credits late feedback to the turn that it is about.

Praise and blame that come two turns after the action, and name the turn, beside a placebo. It rests on praise and
blame, without which it cannot be had.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="credits late feedback to the right turn",
    better="only(kinds='hp+hn') | delayed(turns=2)",
    worse="only(kinds='hp+hn') | delayed(turns=2) | placebo",
    reference="reasoner(worlds=64)",
    seeds=40,
    rests_on=("praise", "blame"),
)
