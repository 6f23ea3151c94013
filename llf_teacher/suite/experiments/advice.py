"""Takes advice: does what the teacher says to do next.

Lessons of advice (fp) beside as many words that say nothing of the task. A student that does what is advised has no
regret; the score says nothing of whether it understands why.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="takes advice",
    better="only(kinds='fp')",
    worse="only(kinds='fp') | placebo",
    reference="obedient",
)
