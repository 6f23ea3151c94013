"""What the `alfworld` package ships, which only its game files and TextWorld's engine need: the rules."""

import os
from functools import cache
from importlib.util import find_spec
from pathlib import Path

__all__ = ["installed", "package", "rules"]


def installed() -> bool:
    """Whether there is an `alfworld` package."""
    return find_spec("alfworld") is not None


@cache
def package() -> Path:
    """The folder of the `alfworld` package, and its modules importable.

    Importing it writes an environment variable and a folder into the user's home; here it does neither.

    Raises:
        ModuleNotFoundError: it is not installed; the message has the pip line.
    """
    if not installed():
        raise ModuleNotFoundError(
            "engine='textworld' and ALFWorld's own game files need the package 'alfworld', which is not installed; run:"
            " pip install 'llf-teacher[alfworld]', or have engine='exact' and games='generated'",
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
    """The domain in PDDL and the grammar that the package ships."""
    data = package() / "data"
    return (data / "alfred.pddl").read_text(encoding="utf-8"), (data / "alfred.twl2").read_text(encoding="utf-8")
