"""Benchmarks: each kind of work runs in its own process; compared kinds alternate on fresh episodes."""

from llf_teacher.tools.benchmark.speed import ALLOWED, Speed, compare_speed
from llf_teacher.tools.benchmark.timings import RUNS, forms, imports, seats, simple_families, steps, worlds

__all__ = [
    "ALLOWED",
    "RUNS",
    "Speed",
    "compare_speed",
    "forms",
    "imports",
    "seats",
    "simple_families",
    "steps",
    "worlds",
]
