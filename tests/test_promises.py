"""What documents name as evidence exists: each test, and each command with its options."""

import re

import pytest
from documents import DOCUMENTS, ROOT
from evidence import missing_command, missing_test, named

PROMISES = (ROOT / "docs" / "promises.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| (?!promise )([^|]+) \| ([^|]+) \|$", PROMISES, re.MULTILINE)


def test_every_promise_is_shown_by_something_that_exists():
    assert len(ROWS) >= 40
    for promise, evidence in ROWS:
        tests = [code for code in named(evidence) if code.startswith("tests/")]
        assert tests, promise
        for code in named(evidence):
            if code.startswith("llf "):
                assert not missing_command(code), promise
            else:
                assert code.startswith(("tests/", ".ci/")), promise
                assert not missing_test(code), promise


def test_documents_name_commands_that_exist():
    found = [(path.name, code) for path in DOCUMENTS for code in named(path.read_text(encoding="utf-8"))]
    commands = [(name, code) for name, code in found if re.match(r"llf [a-z-]", code)]
    assert len(commands) > 100
    for name, code in commands:
        assert not missing_command(code), name


@pytest.mark.parametrize(
    ("code", "why"),
    [
        ("llf study run x.toml --workers 3", ""),
        ("llf study x.toml --store x.db", ""),
        ("llf studdy", "no command studdy"),
        ("llf dev golde", "no command golde"),
        ("llf play x --sed 3", "no option --sed"),
        ("llf study run --seeds=3", "no option --seeds=3"),
    ],
)
def test_what_is_no_command_is_found(code, why):
    assert why in missing_command(code)
    assert bool(why) == bool(missing_command(code))


def test_what_is_no_test_is_found():
    assert not missing_test("tests/test_promises.py::test_what_is_no_test_is_found")
    assert missing_test("tests/test_promises.py::test_nothing") == "tests/test_promises.py has no test_nothing"
    assert missing_test("tests/test_promise.py") == "there is no tests/test_promise.py"
