"""The report of a study: `columns` and `data` gather what a store holds, `parts` say what the page has."""

from llf_teacher.studies.definition.study import to_toml
from llf_teacher.studies.report.page import Report, check_writable, render, write_figures, write_report

__all__ = ["Report", "check_writable", "render", "to_toml", "write_figures", "write_report"]
