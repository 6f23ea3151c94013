"""Is not distracted by words that say nothing of the task.

Why: much of what people say is no feedback. The truth among three truisms a turn beside the bare truth, in 20 bandits
and 20 houses. The score is 1 if both lose as much, and 0 if the truisms cost as much as the reference loses in silence.
Confounds: a student that takes no advice has less to be distracted from, so it rests on advice.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="is not distracted by words that say nothing",
    better="oracle",
    worse="oracle | verbose",
    margin=0.2,
    unit=("oracle", "silent"),
    rests_on=("advice",),
)
ASKED = "The teacher puts what is true among three sentences a turn that say nothing of the task."
"""What the student is asked, in plain words for a card."""
