"""Conformance kits: `check_oracle` for an oracle with its phrases, `check_personality` for a personality."""

from teachers.testing.oracles import (
    CHECKS,
    check_claims,
    check_determinism,
    check_distortion,
    check_hints,
    check_honesty,
    check_instructions,
    check_judging_changes_nothing,
    check_kinds,
    check_oracle,
    check_plans,
)
from teachers.testing.personalities import (
    PERSONALITY_CHECKS,
    check_copies,
    check_draws,
    check_meaning,
    check_personality,
    check_promise,
    check_speaking_changes_nothing,
    check_spec,
    check_stages,
    check_words,
)
from teachers.testing.pupil import Pupil, Taught

__all__ = [
    "CHECKS",
    "PERSONALITY_CHECKS",
    "Pupil",
    "Taught",
    "check_claims",
    "check_copies",
    "check_determinism",
    "check_distortion",
    "check_draws",
    "check_hints",
    "check_honesty",
    "check_instructions",
    "check_judging_changes_nothing",
    "check_kinds",
    "check_meaning",
    "check_oracle",
    "check_personality",
    "check_plans",
    "check_promise",
    "check_speaking_changes_nothing",
    "check_spec",
    "check_stages",
    "check_words",
]
