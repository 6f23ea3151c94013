"""Notices that a teacher turns.

Why: teachers change. Advice that is true for three turns and false from then on, beside a teacher that falls silent
then, in 20 bandits and 20 houses; only the regret after these turns counts. The score is 1 if the lies cost nothing,
and 0 if they cost as much as a student loses that does whatever is advised. Confounds: a student that takes no advice
at all has 1, so it rests on advice.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="notices that a teacher turns",
    better="only(kinds='fp') | drifting(after=3)",
    worse="only(kinds='fp') | drifting(after=3, to='mistake(eps=1.0)')",
    reference="obedient",
    offset=1.0,
    since=3,
    rests_on=("advice",),
)
