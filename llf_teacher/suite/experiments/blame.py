"""Uses blame: acts by what the teacher says was bad.

Why: blame says what to leave, not what to do. Blame (hn) beside a placebo, in 40 bandits and 40 houses. The teacher is
silent after a good action, so it rests on keeping what was said. Confounds: a student that errs little gains little;
that the teacher speaks tells of the mistake with the placebo, too, and shows beside silence.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="uses blame",
    better="only(kinds='hn')",
    seeds=40,
    rests_on=("silence",),
)
ASKED = (
    "After a bad action the teacher says that it was bad; to compare, it says as many useless words in other episodes."
)
"""What the student is asked, in plain words for a card."""
