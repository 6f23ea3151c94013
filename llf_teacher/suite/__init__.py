"""The suite: what a student can do with feedback, one ability an experiment, each scored in regret."""

from llf_teacher.suite.card import Card
from llf_teacher.suite.comparing import check, compare
from llf_teacher.suite.experiment import Experiment, all_experiments
from llf_teacher.suite.taking import VERSION, digest, studies_of, take

__all__ = ["VERSION", "Card", "Experiment", "all_experiments", "check", "compare", "digest", "studies_of", "take"]
