"""Takes advice: does what the teacher says to do next.

Why: advice says all that the next action needs. Advice (fp) beside a placebo, as many words that say nothing of the
task, in 20 bandits and with 20 lists of films. Without help no student does well in these; in a house one that reads
the plan does, so that advice saves it less than one that only obeys. Confounds: a student that only obeys has no
regret; whether it understands why does not count.
"""

from llf_teacher.suite.environments import ARMS, FILMS
from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="takes advice",
    better="only(kinds='fp')",
    reference="obedient",
    ids=(ARMS, FILMS),
)
ASKED = (
    "Before each turn the teacher says which action is best; to compare, it says as many useless words in "
    "other episodes."
)
"""What the student is asked, in plain words for a card."""
