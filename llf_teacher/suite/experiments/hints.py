"""Combines hints: acts on clues, none of which names a single action.

Why: a student that infers needs no answers. One new clue a turn, such as a list of arms or a room without a treasure,
beside a placebo, in 20 bandits and 20 houses. Clues are said as advice and warnings, and once all are said the teacher
is silent: it rests on both, and on keeping them. Confounds: many clues leave one action, as an answer does; and a clue
of a bandit names arms, so that a student gains that takes any arm that was named last.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="combines hints, none of which names a single action",
    better="ruler",
    rests_on=("advice", "warnings", "silence"),
)
ASKED = (
    "In each turn the teacher gives one clue that leaves several actions; to compare, it says as many "
    "useless words in other episodes."
)
"""What the student is asked, in plain words for a card."""
