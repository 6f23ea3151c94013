"""Uses praise: acts by what the teacher says was good.

Why: praise says what to keep. Praise (hp) beside a placebo, in 40 bandits and 40 houses. In a house a move cannot be
repeated, but it tells on which side the treasure is. The teacher is silent after a bad action, so it rests on keeping
what was said. Confounds: with a bandit, to repeat what was praised is enough; that the teacher speaks tells of the
good action with the placebo, too, and shows beside silence.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="uses praise",
    better="only(kinds='hp')",
    seeds=40,
    rests_on=("silence",),
)
ASKED = (
    "After a good action the teacher says that it was good; "
    "to compare, it says as many useless words in other episodes."
)
"""What the student is asked, in plain words for a card."""
