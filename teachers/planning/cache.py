"""What was explored of environments, in files of the user's cache folder, which all processes share.

The variable LLF_CACHE names the folder; if it is empty, nothing is stored. By default it is `llf-teacher` in
XDG_CACHE_HOME or `~/.cache`. Files hold numbers and JSON, and no code.
"""

import contextlib
import hashlib
import inspect
import json
import os
import tempfile
import time
import zipfile
from collections.abc import Hashable
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

from teachers.planning.known import is_patched
from teachers.planning.transitions import Transition, Transitions
from worlds.wrapped.snapshots import layers

FOLDER = "LLF_CACHE"
"""The variable that names the folder."""
MOST = 256_000_000
"""Greatest size of all files, in bytes; those that were used last stay."""
_ENDING, _HALF = ".npz", ".half"
_OLD = 86_400  # seconds after which the half-written file of a process that ended is deleted
_BUILT_IN = {"abc", "builtins", "typing"}
_INSTALLED = {"site-packages", "dist-packages"}
_PLAIN = (str, int, float, bool, type(None))


def folder() -> Path | None:
    """The folder; None: nothing is stored."""
    given = os.environ.get(FOLDER)
    if given is None:
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "llf-teacher"
    return Path(given) if given else None


def key_of(env: gymnasium.Env[Any, Any], *more: Any) -> str:
    """The key of what was found out about an environment; empty if it must not be stored.

    It is made of the environment's spec, its options included, of the source files of its classes, of the versions of
    the distributions that these come from, and of our own code. An environment without a spec, with wrappers whose
    arguments the spec lacks, with methods that are not its class's, or that is not installed, has none.

    Args:
        env: the environment.
        more: whatever else decides what is found, as JSON values, tuples or bytes.
    """
    classes = {base for layer in layers(env) for base in type(layer).__mro__ if base.__module__ not in _BUILT_IN}
    files = {inspect.getsourcefile(base) or "" for base in classes}
    if env.spec is None or not all(_INSTALLED.intersection(Path(file).parts) for file in files):
        return ""
    if any(map(is_patched, layers(env))) or any(wrapper.kwargs is None for wrapper in env.spec.additional_wrappers):
        return ""
    try:
        versions = sorted({_version(base.__module__.partition(".")[0]) for base in classes})
        code = [_ours(), *map(_digest, sorted(files))]
        parts = [env.spec.to_json(), gymnasium.__version__, versions, code, _plain(more)]
        return hashlib.sha256(json.dumps(parts).encode()).hexdigest()
    except (OSError, TypeError, ValueError, metadata.PackageNotFoundError):
        return ""


def load(key: str) -> Transitions | None:
    """The transitions of a key; None if there are none, or the file is damaged."""
    path = _path(key)
    if path is None:
        return None
    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            found = _unpack({name: file[name] for name in file.files})
        os.utime(path)
    except (OSError, EOFError, KeyError, IndexError, TypeError, ValueError, zipfile.BadZipFile):
        return None
    return found


def save(key: str, transitions: Transitions) -> None:
    """Store transitions under a key, if there is one and the folder can be written.

    They are written to a file of their own, which takes the name at once when it is whole.
    """
    path = _path(key)
    if path is None:
        return
    try:
        arrays = _pack(transitions)
    except TypeError:  # states that JSON does not have
        return
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        number, name = tempfile.mkstemp(_HALF, dir=path.parent)
        try:
            with os.fdopen(number, "wb") as file:
                np.savez_compressed(file, **arrays)
            os.replace(name, path)
        except BaseException:
            os.unlink(name)
            raise
        _clear(path.parent)


def _path(key: str) -> Path | None:
    where = folder()
    return where / f"plan-{key}{_ENDING}" if key and where else None


def _clear(where: Path) -> None:
    """Delete the files that were used least lately, if all are too large, and what was left half-written."""
    size = 0
    files = [(path.stat(), path) for path in where.iterdir() if path.suffix in (_ENDING, _HALF)]
    for stat, path in sorted(files, key=lambda each: -each[0].st_mtime):
        half = path.suffix == _HALF
        size += 0 if half else stat.st_size
        if (time.time() - stat.st_mtime > _OLD) if half else (size > MOST):
            path.unlink(missing_ok=True)


@cache
def _version(package: str) -> str:
    """The name and version of the distribution of a package."""
    try:
        return f"{package} {metadata.version(package)}"
    except metadata.PackageNotFoundError:
        (name, *_) = metadata.packages_distributions().get(package, [package])
        return f"{name} {metadata.version(name)}"


@cache
def _digest(file: str) -> str:
    return hashlib.sha256(Path(file).read_bytes()).hexdigest()


@cache
def _ours() -> str:
    """A digest of the code that plans."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _plain(value: Any) -> Any:
    """A value as JSON has it: tuples as lists, bytes as a dict.

    Raises:
        TypeError: JSON would not give it back.
    """
    if type(value) is tuple:
        return [_plain(each) for each in value]
    if type(value) is bytes:
        return {"bytes": value.hex()}
    if type(value) not in _PLAIN:
        raise TypeError(f"{value!r} is neither a tuple, text, bytes, a number, a truth value nor None")
    return value


def _given_back(value: Any) -> Hashable:
    """The value of which `_plain` made this."""
    if isinstance(value, list):
        return tuple(map(_given_back, value))
    return bytes.fromhex(value["bytes"]) if isinstance(value, dict) else value


def _pack(transitions: Transitions) -> dict[str, Any]:
    """Transitions as arrays: the states as JSON, how many transitions each action has there, and these in one row."""
    index = {state: number for number, state in enumerate(transitions)}
    each = [transition for row in transitions.values() for action in row for transition in action]
    return {
        "states": np.frombuffer(json.dumps([_plain(state) for state in transitions]).encode(), np.uint8),
        "counts": np.array([[len(action) for action in row] for row in transitions.values()], np.int32),
        "chances": np.array([one.probability for one in each]),
        "after": np.array([-1 if one.state is None else index[one.state] for one in each], np.int32),
        "rewards": np.array([one.reward for one in each]),
    }


def _unpack(arrays: dict[str, Any]) -> Transitions:
    """The transitions of arrays; errors of many kinds if they are none."""
    states = [_given_back(state) for state in json.loads(arrays["states"].tobytes())]
    counts, after = arrays["counts"].tolist(), [*states, None]
    if not len(states) == len(counts) == len(set(states)):
        raise ValueError("the states are others than those with transitions")
    columns = (arrays[name].tolist() for name in ("chances", "after", "rewards"))
    flat = [Transition(chance, after[place], reward) for chance, place, reward in zip(*columns, strict=True)]
    if sum(map(sum, counts)) != len(flat):
        raise ValueError("there are not as many transitions as the counts say")
    rest = iter(flat)
    return {
        state: [[next(rest) for _ in range(number)] for number in row]
        for state, row in zip(states, counts, strict=True)
    }
