"""Discounts a liar.

A teacher all of whose advice is false beside silence. The score is 1 if the lies cost nothing, and 0 if they cost as
much as a student loses that does whatever it is told; a student that does the opposite can exceed 1.
"""

from llf_teacher.suite.experiment import Experiment
from llf_teacher.suite.places import ARMS, HOUSE, OPTIONS

EXPERIMENT = Experiment(
    ability="discounts a teacher that lies",
    better="silent",
    worse="only(kinds='fp') | mistake(eps=1.0)",
    reference="obedient",
    offset=1.0,
    unit=None,
    ids=(ARMS, HOUSE),
    options=OPTIONS,
)
