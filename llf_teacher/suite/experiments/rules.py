"""Carries rules to new worlds of a town.

Why: advice serves in one world, a rule in many. A test without a teacher in another world of the same town as the
lesson before, of clues and rules of the town, or of a placebo, in 20 bandits and 20 houses, each in a town of its own;
only the test counts. The rules say which arms pay more by their looks, or in what rooms treasures lie. They are said as
advice and warnings, on which it rests, and, since the test has no teacher, on keeping what was said. Confounds: from
rewards a rule is inferred with the placebo, too. Prerequisite: memory between episodes.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="carries rules to new worlds of a town",
    better="ruler",
    reference="reasoner(worlds=64, forget=False)",
    lessons="next",
    rests_on=("advice", "warnings", "silence"),
    town=True,
)
ASKED = (
    "The teacher says in an episode what the rule of this town is; then the student plays another world of "
    "the town without a teacher."
)
"""What the student is asked, in plain words for a card."""
