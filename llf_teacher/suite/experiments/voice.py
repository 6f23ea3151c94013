"""Understands a teacher in another voice.

The same claims in a curt voice beside the plain one. The score is 1 if both save as much, and less if the curt voice
saves less; the unit is what the plain voice saves beside a placebo.
"""

from llf_teacher.suite.experiment import Experiment
from llf_teacher.suite.places import ARMS, HOUSE, OPTIONS

EXPERIMENT = Experiment(
    ability="understands another voice as well",
    better="oracle",
    worse="oracle | voice(tone='curt')",
    reference="obedient",
    offset=1.0,
    margin=0.2,
    unit=("oracle", "oracle | placebo"),
    rests_on=("advice",),
    ids=(ARMS, HOUSE),
    options=OPTIONS,
)
