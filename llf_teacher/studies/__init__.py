"""Feedback studies: a study is a frozen value; running, storing, statistics and reporting are separate modules.

`load` gives what a store holds, `run` plays a study and gives that.
"""

from llf_teacher.studies.definition.study import Study, load_study
from llf_teacher.studies.results import Results, load, run

__all__ = ["Results", "Study", "load", "load_study", "run"]
