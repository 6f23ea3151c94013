"""The parts of a report, each a module with a template of the same name; here is their order."""

from llf_teacher.studies.report.parts import accounting, families, findings, introduction, manifest, notes
from llf_teacher.studies.report.parts.part import Part

PARTS: tuple[Part, ...] = (
    introduction.PART,
    findings.PART,
    notes.PART,
    families.PART,
    accounting.PART,
    manifest.PART,
)
