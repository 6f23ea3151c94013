"""Understands a teacher in another voice.

Why: teachers talk differently. The same claims in a curt voice beside the plain one, in 20 bandits and 20 houses. The
score is 1 if both save as much, and less if the curt voice saves less; the unit is what the plain voice saves beside a
placebo. Without advice both are alike, so it rests on that. Confounds: one other voice stands for all.
"""

from llf_teacher.suite.experiment import Experiment

EXPERIMENT = Experiment(
    ability="understands another voice as well",
    better="oracle",
    worse="oracle | voice(tone='curt')",
    margin=0.2,
    unit=("oracle", "oracle | placebo"),
    rests_on=("advice",),
)
ASKED = "The teacher says the same in a few curt words as in whole sentences."
"""What the student is asked, in plain words for a card."""
