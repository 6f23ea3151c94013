"""That the packages of this distribution are its own: a folder or file of the same name elsewhere would go first."""

import sys
from importlib.util import find_spec
from pathlib import Path

_HOME = Path(__file__).resolve().parents[1]
_PACKAGES = ("worlds", "teachers", "pz_envs")


def check_origins() -> None:
    """Check where the packages beside this one come from, before they are imported.

    Raises:
        ImportError: one is hidden by something of the user's; the message names the file.
    """
    for name in _PACKAGES:
        if name in sys.modules:
            file = getattr(sys.modules[name], "__file__", None)
        else:
            spec = find_spec(name)
            file = spec and spec.origin
        if file is None or Path(file).resolve().parent.parent != _HOME:
            where = file or f"a folder {name!r}"  # which goes before a package of an editable installation
            raise ImportError(
                f"llf_teacher needs its own package {name!r} in {_HOME}, but Python finds {where} first; "
                "rename that, or start Python in another folder",
                name=name,
                path=file,
            )


check_origins()
