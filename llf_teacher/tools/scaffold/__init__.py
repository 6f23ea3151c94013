"""First files of a new family, personality, student or trait, from the templates beside this module.

A template has, below its kind, the path of its file; `NAME` in the path and `$name` and `$Name` in the text stand for
the name, `$id` for the name in ids.
"""

import keyword
import string
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path

from teachers.spec import unknown

KINDS = ("family", "personality", "student", "trait")
_SUFFIX = ".txt"


def write(kind: str, name: str, folder: Path) -> list[Path]:
    """Write the files of a new family, personality, student or trait; returns their paths.

    Args:
        kind: one of `KINDS`.
        name: the name of the modules; the classes have it in camel case.
        folder: a clone of the repository.

    Raises:
        ValueError: the kind or the name is not allowed, or the folder is not a clone.
        FileExistsError: a file, or a package of its name, exists; nothing is written.
    """
    if kind not in KINDS:
        raise ValueError(unknown("kind", kind, KINDS))
    if not (name.isidentifier() and name.isascii() and name == name.lower()) or keyword.iskeyword(name):
        raise ValueError(f"the name of a {kind} must be a lower-case Python identifier such as `maze`, got {name!r}")
    cls = "".join(part.capitalize() for part in name.split("_"))
    if not cls.isidentifier():
        raise ValueError(f"the name of a {kind} must have a letter first, got {name!r}")
    files = {
        folder / path.replace("NAME", name): string.Template(text).substitute(name=name, Name=cls, id=id_of(name))
        for path, text in _templates(resources.files(__name__) / kind)
    }
    for path in files:
        if not path.parent.is_dir():
            raise ValueError(f"{path.parent} is not a folder; run it in a clone of the repository, or give --folder")
        if taken := [each for each in (path, path.with_suffix("")) if each.exists()]:
            raise FileExistsError(f"{taken[0]} exists already, and nothing was written; choose another name")
    for path, text in files.items():
        path.write_text(text, encoding="utf-8")
    return list(files)


def id_of(name: str) -> str:
    """The name in the form of ids."""
    return name.replace("_", "-")


def _templates(folder: Traversable, path: str = "") -> list[tuple[str, str]]:
    """The paths below a folder, without the suffix of templates, and their texts."""
    found: list[tuple[str, str]] = []
    for each in sorted(folder.iterdir(), key=lambda each: each.name):
        inner = f"{path}/{each.name}".lstrip("/")
        if each.is_dir():
            found += _templates(each, inner)
        else:
            found.append((inner.removesuffix(_SUFFIX), each.read_text(encoding="utf-8")))
    return found
