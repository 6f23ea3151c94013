"""The benchmark runs every form of the seats; how fast they are is not a matter of tests."""

import io
import operator

from rich.console import Console

from llf_teacher.tools import benchmark


def test_every_form_is_measured(monkeypatch):
    monkeypatch.setattr(benchmark, "_STEPS", 10)
    monkeypatch.setattr(benchmark, "_ROUNDS", 1)
    monkeypatch.setattr(benchmark, "_alone", lambda function, *arguments: function(*arguments))
    families = benchmark.simple_families()
    assert len(families) >= 2
    console = Console(file=io.StringIO(), width=160)
    table = benchmark.forms()
    assert table.row_count == 7 * len(families)
    console.print(table)
    text = console.file.getvalue()
    for form in (
        "raw_env",
        "env",
        "StudentEnv",
        "TeacherEnv",
        "ClassroomEnv(1)",
        "ClassroomEnv(8)",
        "ClassroomEnv(64)",
    ):
        assert text.count(f" {form} ") == len(families)


def test_a_fresh_process_answers():
    assert benchmark._alone(operator.mul, 6, 7) == 42
