"""Heeds warnings: does not do what the teacher says to avoid next.

Why: some teachers only forbid. Warnings (fn) beside a placebo, in 20 bandits and 20 houses. A warning leaves several
actions, so the reference weighs in which worlds the warning is said. Confounds: to shun what was named last is a part
of it.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="heeds warnings",
    better="only(kinds='fn')",
)
ASKED = (
    "Before each turn the teacher says which action to avoid; to compare, it says as many useless words in "
    "other episodes."
)
"""What the student is asked, in plain words for a card."""
