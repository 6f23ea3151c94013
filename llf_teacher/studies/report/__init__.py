"""The report of a study: `columns` and `data` read the store, and `parts` are the sections of the page."""

from llf_teacher.studies.definition.study import to_toml
from llf_teacher.studies.report.page import Report, check_writable, findings, render, write_figures, write_report

__all__ = ["Report", "check_writable", "findings", "render", "to_toml", "write_figures", "write_report"]
