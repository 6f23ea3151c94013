"""Notices that a teacher turns.

Why: teachers change. Advice that is true for three turns and false from then on, beside a teacher that falls silent
then, in 20 bandits and 20 houses; only the regret after these turns counts. The score is 1 if the lies cost nothing,
and 0 if they cost as much as a student loses that does whatever is advised. Where a student does no better after the
true advice than with a silent teacher, lies have nothing to take from it, and nothing is measured: it rests on advice,
and on keeping it in silence. Confounds: a student that learns from rewards soon does well in spite of lies.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="notices that a teacher turns",
    better="only(kinds='fp') | drifting(after=3)",
    worse="only(kinds='fp') | drifting(after=3, to='mistake(eps=1.0)')",
    reference="obedient",
    since=3,
    margin=0.2,
    rests_on=("advice", "silence"),
)
ASKED = (
    "The teacher gives good advice for three turns and bad advice from then on; to compare, it falls silent "
    "then in other episodes."
)
"""What the student is asked, in plain words for a card."""
