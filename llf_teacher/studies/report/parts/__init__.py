"""The parts of a report in their order; each is a module with a template of the same name."""

from llf_teacher.studies.report.parts import (
    ablation,
    accounting,
    families,
    findings,
    information,
    introduction,
    manifest,
    matrix,
    models,
    notes,
    overall,
    samples,
    time_to_success,
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
    time_to_success.PART,
    ablation.PART,
    matrix.PART,
    transfer.PART,
    accounting.PART,
    information.PART,
    models.PART,
    manifest.PART,
)
