"""A check that Python imports this distribution's packages, and no folders or files of the same names elsewhere."""

import sys
from importlib.util import find_spec
from pathlib import Path

_HOME = Path(__file__).resolve().parents[1]
_PACKAGES = ("worlds", "teachers", "pz_envs")


def check_packages() -> None:
    """Check where the packages beside this one come from, before they are imported.

    Raises:
        ImportError: another file or folder hides one; the message names it.
    """
    for name in _PACKAGES:
        if name in sys.modules:
            file = getattr(sys.modules[name], "__file__", None)
        else:
            spec = find_spec(name)
            file = spec and spec.origin
        if file is None or Path(file).resolve().parent.parent != _HOME:
            where = file or f"a folder {name!r}"  # which precedes a package of an editable installation
            raise ImportError(
                f"llf_teacher needs its own package {name!r} in {_HOME}, but Python finds {where} first; "
                "rename it, or start Python in another folder",
                name=name,
                path=file,
            )


check_packages()
