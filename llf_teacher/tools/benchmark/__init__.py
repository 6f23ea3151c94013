"""Benchmarks: what is compared is fresh work, played in turns in one run, each by a process of its own."""

from llf_teacher.tools.benchmark.against import Compared, compare
from llf_teacher.tools.benchmark.tables import forms, imports, seats, simple_families, steps, worlds

__all__ = ["Compared", "compare", "forms", "imports", "seats", "simple_families", "steps", "worlds"]
