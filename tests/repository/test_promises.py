"""What documents name as evidence exists: each test, and each command with its options."""

import re
import shlex

import pytest
from commands import llf
from documents import BLOCK, DOCUMENTS, ROOT
from evidence import missing_command, missing_test, named

PROMISES = (ROOT / "docs" / "internals" / "promises.md").read_text(encoding="utf-8")
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
    here = "tests/repository/test_promises.py"
    assert not missing_test(f"{here}::test_what_is_no_test_is_found")
    assert missing_test(f"{here}::test_nothing") == f"{here} has no test_nothing"
    assert missing_test("tests/test_promise.py") == "there is no tests/test_promise.py"


def test_reviewers_see_what_their_page_shows(tmp_path):
    """Of each command in a block `console`, up to white space; `...` stands for anything."""
    blocks = BLOCK.findall((ROOT / "docs" / "internals" / "for-reviewers.md").read_text(encoding="utf-8"))
    (study,) = [code for language, code in blocks if language == "toml"]
    (tmp_path / "review.toml").write_text(study, encoding="utf-8")
    consoles = [code for language, code in blocks if language == "console"]
    assert len(consoles) >= 3
    for code in consoles:
        first, _, shown = code.partition("\n")
        result = llf(*shlex.split(first.removeprefix("$ llf ")), cwd=tmp_path)
        assert result.returncode == 0, result.stderr
        pattern = ".*".join(re.escape(" ".join(part.split())) for part in shown.split("..."))
        assert re.search(pattern, " ".join(f"{result.stdout} {result.stderr}".split())), result.stdout + result.stderr
    again = llf("study", "review.toml", "--store", "review.db", "--report", "review.html", cwd=tmp_path)
    assert "Played 0 episodes; review.db now has 48." in again.stderr
    damaged = bytearray((tmp_path / "review.db").read_bytes())
    damaged[len(damaged) // 2] ^= 255
    (tmp_path / "copy.db").write_bytes(damaged)
    assert llf("study", "check", "copy.db", cwd=tmp_path).returncode > 0
