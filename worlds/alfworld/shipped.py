"""What the `alfworld` package ships: rules, goals, floor plans, and lists of what may lie where."""

import os
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any


@cache
def package() -> Path:
    """The folder of the `alfworld` package, and its modules importable.

    Importing it writes an environment variable and a folder into the user's home; here it does neither.
    """
    before = os.environ.get("ALFWORLD_DATA")
    os.environ["ALFWORLD_DATA"] = str(Path(__file__).parent)
    try:
        import alfworld
    finally:
        if before is None:
            del os.environ["ALFWORLD_DATA"]
        else:
            os.environ["ALFWORLD_DATA"] = before
    return Path(alfworld.__file__).parent


@cache
def rules() -> tuple[str, str]:
    """The domain in PDDL and the grammar that the package ships."""
    data = package() / "data"
    return (data / "alfred.pddl").read_text(encoding="utf-8"), (data / "alfred.twl2").read_text(encoding="utf-8")


def constants() -> ModuleType:
    """The lists of the package: types of things, what may lie where, floor plans."""
    package()
    return import_module("alfworld.gen.constants")


def goals() -> dict[str, dict[str, Any]]:
    """Per type of task its goal in PDDL and its templates in English."""
    package()
    from alfworld.gen.goal_library import gdict

    found: dict[str, dict[str, Any]] = gdict
    return found
