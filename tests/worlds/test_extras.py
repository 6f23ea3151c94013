"""Messages about what is not installed say what to do in a clone, too."""

import tomllib
from pathlib import Path

from worlds.extras import pip_install

ROOT = Path(__file__).parents[2]


def test_both_commands_name_the_extra():
    assert pip_install("llm") == "pip install 'llf-teacher[llm]' (in a clone: pip install -e '.[llm]')"


def test_no_message_has_a_command_of_its_own():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    for package in ("worlds", "teachers", "pz_envs", "llf_teacher"):
        for path in (ROOT / package).rglob("*.py"):
            text = path.read_text("utf-8")
            assert path.name == "extras.py" or "pip install 'llf-teacher[" not in text, path
            for part in text.split("pip_install(")[1:]:
                named = part.split(")")[0].strip("\"'").split(",")
                assert extras.keys() >= {*named} or not part.startswith(("'", '"')), (path, named)
