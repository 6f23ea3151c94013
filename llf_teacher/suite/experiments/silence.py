"""Keeps what it was taught after the teacher falls silent.

A teacher that shows the next optimal actions before the first turn and says nothing after, beside a placebo; the regret
from the third turn on counts. In bandits the actions are one arm, again and again; in a house they are the way to the
treasure. It rests on advice.
"""

from llf_teacher.suite.experiment import TURNS, Experiment

_TEACHER = f"only(kinds='fp') | worked_example(n={TURNS}) | early(budget=1)"
EXPERIMENT = Experiment(
    ability="keeps what it was taught when the teacher falls silent",
    better=_TEACHER,
    worse=f"{_TEACHER} | placebo",
    reference="reasoner(worlds=64)",
    since=2,
    rests_on=("advice",),
)
