"""What a document names as evidence: tests, and commands of the command line."""

import ast
import re
import shlex
from functools import cache

import typer
from documents import ROOT

from llf_teacher.cli import app

CODE = re.compile(r"`([^`\n]+)`|^ {4}(\S.*)$", re.MULTILINE)
"""Code within a line, or a line of code."""


def named(text):
    """The pieces of code in a document, but for its fenced blocks."""
    plain = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    return [inline or line for inline, line in CODE.findall(plain)]


@cache
def tests_of(path):
    """The names of the tests in a file."""
    tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}


def missing_test(name):
    """Why there is no such test, as in `tests/test_x.py::test_y`; empty if there is one. A file or a folder will do."""
    path, _, function = name.partition("::")
    if not (ROOT / path).exists():
        return f"there is no {path}"
    return f"{path} has no {function}" if function and function not in tests_of(path) else ""


def missing_command(line):
    """Why `llf ...` is no command line; empty if it is one. Arguments are not looked at, names of options are."""
    command, words = typer.main.get_command(app), shlex.split(line.partition("#")[0])[1:]
    while words and words[0] in getattr(command, "commands", {}):
        command, words = command.commands[words[0]], words[1:]
    if words and words[0].isalpha() and hasattr(command, "commands"):
        return f"{line!r}: there is no command {words[0]}"
    options = {name for param in command.params for name in (*param.opts, *param.secondary_opts)} | {"--help", "-h"}
    wrong = [word for word in words if re.match(r"--\w", word) and word.partition("=")[0] not in options]
    return f"{line!r}: there is no option {', '.join(wrong)}" if wrong else ""
