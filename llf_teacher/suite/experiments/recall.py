"""Recalls in a later episode what it was taught in an earlier one.

Why: a student that forgets is taught anew. A test without a teacher in the world of the lesson before, of advice or of
a placebo, in 20 bandits and 20 houses; only the test counts. It rests on advice, and, since the test has no teacher, on
keeping what was said. Confounds: to repeat the lesson's actions is enough. Prerequisite: memory between episodes.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="recalls in a later episode what it was taught",
    better="only(kinds='fp')",
    reference="obedient(forget=False)",
    lessons="same",
    rests_on=("advice", "silence"),
)
ASKED = (
    "The teacher says in an episode which action is best; "
    "then the student plays the same world again without a teacher."
)
"""What the student is asked, in plain words for a card."""
