"""Takes advice: does what the teacher says to do next.

Why: advice says all that the next action needs. Advice (fp) beside a placebo, as many words that say nothing of the
task, in 20 bandits and 20 houses. Confounds: a student that only obeys has no regret; whether it understands why does
not count.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="takes advice",
    better="only(kinds='fp')",
    reference="obedient",
)
