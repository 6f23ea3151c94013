"""The rules in the `alfworld` package, for its game files and TextWorld's engine."""

import os
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from worlds.extras import pip_install

__all__ = ["installed", "package", "rules"]


def installed() -> bool:
    """Whether the `alfworld` package is installed."""
    return find_spec("alfworld") is not None


@cache
def package() -> Path:
    """Import the `alfworld` package; returns its folder.

    The import would set an environment variable and create a folder in the user's home; both are prevented.

    Raises:
        ModuleNotFoundError: it is not installed; the message has the pip command.
    """
    if not installed():
        raise ModuleNotFoundError(
            "engine='textworld' and ALFWorld's own game files need the package 'alfworld', which is not installed; run:"
            f" {pip_install('alfworld')}, or have engine='exact' and games='generated'",
            name="alfworld",
        )
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
    """The package's domain in PDDL and its grammar."""
    data = package() / "data"
    return (data / "alfred.pddl").read_text(encoding="utf-8"), (data / "alfred.twl2").read_text(encoding="utf-8")
