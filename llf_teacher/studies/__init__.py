"""Feedback studies: a study is a frozen value; running, storing, statistics and reporting are separate modules.

`load` returns the results in a store, `run` plays a study and returns its results.
"""

from llf_teacher.studies.definition.study import Study, load_study
from llf_teacher.studies.results import Results, load, read_csv, run

__all__ = ["Results", "Study", "load", "load_study", "read_csv", "run"]
