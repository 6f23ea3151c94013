"""Credits late feedback to the right turn.

Why: much is said after the fact. Praise two turns after the action beside a placebo, in 40 bandits and 40 houses. Rests
on praise. Confounds: the words name the turn, but also the arm, or the room and the move, so that a student can use
them that does not know what it did in that turn.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="credits late feedback to the right turn",
    better="only(kinds='hp') | delayed(turns=2)",
    seeds=40,
    rests_on=("praise",),
)
