"""The parts of a report, each a module with a template of the same name; here is their order."""

from llf_teacher.studies.report.parts import (
    ablation,
    accounting,
    attempts,
    families,
    findings,
    introduction,
    manifest,
    matrix,
    models,
    notes,
    overall,
    samples,
    transfer,
)
from llf_teacher.studies.report.parts.part import Part

PARTS: tuple[Part, ...] = (
    introduction.PART,
    findings.PART,
    notes.PART,
    overall.PART,
    families.PART,
    samples.PART,
    attempts.PART,
    ablation.PART,
    matrix.PART,
    transfer.PART,
    accounting.PART,
    models.PART,
    manifest.PART,
)
