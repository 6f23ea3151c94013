"""Fingerprints of users' own code: what decides an episode beside its spec, which names the code only.

The fingerprint of a spec has a digest for each module that it is made of: the module that the spec names, and all
modules beside it that this one imports, in functions, too. Digests are of the parsed code, so that comments, docstrings
and layout do not count; docstrings do count in a module that reads them. Text files beside a module that its code names
count as well, unless the module writes files. Installed packages, the standard library and this package do not count.

`Fingerprint.unseen` says what else may decide what the code does: files that it reads, code that it runs by its text,
and installed packages that it imports.
"""

import ast
import contextlib
import importlib.util
import os
import sys
import sysconfig
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from importlib.machinery import ModuleSpec
from pathlib import Path
from typing import Any, NamedTuple

from llf_teacher.registry import entry
from llf_teacher.studies.definition.live_code import live_code
from llf_teacher.studies.definition.parsed_code import digest_of, plain
from teachers.spec import parse_calls

MAIN = "__main__"
_INSTALLED = ("site-packages", "dist-packages")  # folders of installed packages
_OURS = ("llf_teacher", "pz_envs", "teachers", "worlds")
_STANDARD = tuple(Path(sysconfig.get_path(name)) for name in ("stdlib", "platstdlib"))
_TEXTS = (".txt", ".md", ".json", ".toml", ".yaml", ".yml", ".csv", ".j2", ".jinja", ".jinja2", ".prompt")
_READS = {"open", "read_text", "read_bytes", "exec", "eval", "import_module", "__import__"}
_IMPORTS = {"import_module", "__import__"}
_WRITES = {"write_text", "write_bytes", "dump", "save", "savez", "savetxt", "to_csv", "to_json"}
_DOCS = {"__doc__", "getdoc"}  # names by which code reads docstrings
_NAMED = 4  # greatest number of items in a message


class Fingerprint(NamedTuple):
    """The code behind a spec."""

    modules: Mapping[str, str]
    """A digest of each module, and of each text file that a module names, by its name."""
    unseen: tuple[str, ...] = ()
    """What may decide its behaviour, too, and is not compared."""
    files: Mapping[str, tuple[Path, str]] = {}
    """The file of each of `modules` that has one, and its place below the folder that it is imported from."""


class _Source(NamedTuple):
    """What the file of a module has."""

    digest: str
    imports: tuple[tuple[str, int, tuple[str, ...]], ...]
    """For each import the module, the number of leading dots, and the imported names."""
    texts: tuple[str, ...]
    """Text files that it may read, as its code names them."""
    reads: tuple[str, ...]
    """Calls whose effect cannot be seen here, with their lines."""


def fingerprints(names: Iterable[str]) -> dict[str, Fingerprint]:
    """The fingerprints of users' own code.

    Args:
        names: specs of teachers, students and readers, and ids of environments; those of this package and of installed
            packages have none, and are left out.
    """
    found = {}
    for name in dict.fromkeys(names):
        if own := list(dict.fromkeys(_modules_of(name))):
            made = _fingerprint(own)
            if made.modules:
                found[name] = made
    return found


def _modules_of(name: str) -> Iterator[tuple[str, str]]:
    """The modules that a spec or the id of an environment names, each with the name of the object in it."""
    try:
        calls = parse_calls("spec", name, "a spec or an id", prefixes=2)
    except ValueError:  # an id
        calls = ()
    if calls and not name.startswith("gym:"):
        yield from ((call.prefix[-1], call.name) for call in calls if call.prefix)
        return
    try:
        subject = entry(name).family
    except ValueError:  # its package is missing here
        return
    yield from ((module, "") for module in subject.code_modules if module.partition(".")[0] not in _OURS)


def _fingerprint(own: Iterable[tuple[str, str]]) -> Fingerprint:
    digests: dict[str, str] = {}
    unseen: dict[str, None] = {}
    files: dict[str, tuple[Path, str]] = {}
    installed: dict[str, None] = {}
    todo: list[str] = []
    for module, name in own:
        if module == MAIN:
            live = live_code(getattr(sys.modules[MAIN], name, None))
            digests[f"{MAIN}:{name}"] = live.digest
            todo += live.modules
            unseen |= dict.fromkeys(live.unseen)
        else:
            todo += _with_parents(module)
    seen: set[str] = set()
    while todo:
        module = todo.pop(0)
        if module in seen:
            continue
        seen.add(module)
        spec = _find(module)
        path = _file_of(spec)
        if spec is None or path is None:
            continue
        if not _is_own(path):
            top = module.partition(".")[0]
            if _is_installed(path) and top not in _OURS:
                installed[top] = None
            continue
        try:
            source = _read(path, path.stat().st_mtime_ns, path.stat().st_size)
        except OSError as error:
            unseen[f"the module {module}, whose file cannot be read ({error})"] = None
            continue
        digests[module] = source.digest
        files[module] = path, "/".join(path.parts[-len(_with_parents(module)) - (path.stem == "__init__") :])
        for text in source.texts:
            place = os.path.normpath(f"{Path(files[module][1]).parent}/{text}")
            files[f"{module}: {text}"] = path.parent / text, place.replace(os.sep, "/")
            digests[f"{module}: {text}"] = digest_of((path.parent / text).read_bytes())
        unseen |= dict.fromkeys(f"what `{call} of {module} reads or runs" for call in source.reads)
        package = module if spec.submodule_search_locations is not None else module.rpartition(".")[0]
        for imported in source.imports:
            todo += _names_of(*imported, package)
    if installed:
        unseen[f"the installed packages {', '.join(sorted(installed))}"] = None
    return Fingerprint(dict(sorted(digests.items())), tuple(unseen), files)


def _with_parents(module: str) -> list[str]:
    """A module after the packages that it is in, whose code runs first."""
    parts = module.split(".")
    return [".".join(parts[: i + 1]) for i in range(len(parts))]


def _names_of(module: str, dots: int, names: tuple[str, ...], package: str) -> list[str]:
    """The modules that an import may load."""
    try:
        whole = importlib.util.resolve_name(f"{'.' * dots}{module}", package) if dots else module
    except ImportError:
        return []
    if whole.partition(".")[0] in _OURS:
        return []
    return _with_parents(whole) + [f"{whole}.{name}" for name in names]


def _find(module: str) -> ModuleSpec | None:
    """The spec of a module, found without importing its packages; None if there is none."""
    spec: ModuleSpec | None = None
    within = None
    for name in _with_parents(module):
        if spec is not None and (within := spec.submodule_search_locations) is None:
            return None
        spec = _found(name, within)
        if spec is None:
            return None
        if name == module:
            return spec
        if (path := _file_of(spec)) is not None and not _is_own(path):
            return spec
    return spec


def _found(module: str, within: Sequence[str] | None) -> ModuleSpec | None:
    """The spec of a module in its package, of which these are the folders."""
    for finder in sys.meta_path:
        with contextlib.suppress(Exception):  # a finder may be another package's own
            if (spec := finder.find_spec(module, within)) is not None:
                return spec
    return None


def _file_of(spec: ModuleSpec | None) -> Path | None:
    """The file of a module; None if it has none, as a namespace and what is built in."""
    if spec is None or not spec.has_location or not spec.origin:
        return None
    return Path(spec.origin)


def _is_installed(path: Path) -> bool:
    return any(part in _INSTALLED for part in path.parts)


def _is_own(path: Path) -> bool:
    """Whether a file is neither installed, nor of the standard library, nor of this package."""
    ours = Path(__file__).parents[3]
    if any(path.is_relative_to(ours / name) for name in _OURS):
        return False
    return not _is_installed(path) and not any(map(path.is_relative_to, _STANDARD))


@lru_cache(maxsize=4096)
def _read(path: Path, changed: int, size: int) -> _Source:
    """What a file has, read again when its time or its size has changed."""
    content = path.read_bytes()
    if path.suffix != ".py":
        return _Source(digest_of(content), (), (), ())
    try:
        tree = ast.parse(content)
    except (SyntaxError, ValueError):
        return _Source(digest_of(content), (), (), ())
    names = {each.attr if isinstance(each, ast.Attribute) else each.id for each in _references(tree)}
    imports: list[tuple[str, int, tuple[str, ...]]] = []
    reads: list[str] = []
    writes = bool(names & _WRITES)
    for each in ast.walk(tree):
        if isinstance(each, ast.Import):
            imports += [(alias.name, 0, ()) for alias in each.names]
        elif isinstance(each, ast.ImportFrom):
            imports.append((each.module or "", each.level, tuple(alias.name for alias in each.names)))
        elif isinstance(each, ast.Call) and (called := _called(each)) in _READS:
            given = [value.value for value in each.args if isinstance(value, ast.Constant)]
            constants = [value for value in given if isinstance(value, str)]
            if called in _IMPORTS and constants[:1] == given[:1] and constants and len(each.args) == 1:
                imports.append((constants[0], 0, ()))
                continue
            writes |= called == "open" and _writes(each)
            reads.append(f"{called}` in line {each.lineno}")
    texts = set() if writes else {text for text in _strings(tree) if _is_text(path.parent, text)}
    code = repr(plain(tree, docs=bool(names & _DOCS))).encode()
    return _Source(digest_of(code), tuple(imports), tuple(sorted(texts)), tuple(reads))


def _references(tree: ast.AST) -> Iterator[ast.Attribute | ast.Name]:
    return (each for each in ast.walk(tree) if isinstance(each, ast.Attribute | ast.Name))


def _called(call: ast.Call) -> str:
    """The name of a called function or method; empty without one."""
    function = call.func
    return function.id if isinstance(function, ast.Name) else getattr(function, "attr", "")


def _writes(call: ast.Call) -> bool:
    """Whether a call of `open` names a mode of writing."""
    values = [*call.args[isinstance(call.func, ast.Name) :], *(each.value for each in call.keywords)]
    modes = [each.value for each in values if isinstance(each, ast.Constant) and isinstance(each.value, str)]
    return any(len(mode) <= 3 and {*mode} & {*"wax+"} for mode in modes)


def _strings(tree: ast.AST) -> Iterator[str]:
    for each in ast.walk(tree):
        if isinstance(each, ast.Constant) and isinstance(each.value, str):
            yield each.value


def _is_text(folder: Path, name: str) -> bool:
    """Whether a string names a text file in a folder or below."""
    if not name.endswith(_TEXTS) or len(name) > 200 or Path(name).is_absolute():
        return False
    try:
        return (folder / name).is_file()
    except (OSError, ValueError):
        return False


def differing(now: Mapping[str, str], before: Mapping[str, str] | None) -> str:
    """What differs between the modules of two fingerprints, in words; empty if nothing does.

    Args:
        now: `Fingerprint.modules`.
        before: the same of a stored episode; None: unknown.
    """
    if before is None:
        return "its code was not recorded"
    names = [name for name in {**before, **now} if before.get(name) != now.get(name)]
    more = f" and {len(names) - _NAMED} more" * (len(names) > _NAMED)
    return f"changed: {', '.join(names[:_NAMED])}{more}" if names else ""


def mixed(
    definitions: Mapping[int, Mapping[str, Any]],
    rows: Iterable[tuple[Iterable[str], int, int]],
    newest: Mapping[str, Mapping[str, str]],
) -> dict[str, list[int]]:
    """The specs and ids that have several versions: for each version its number of episodes.

    Args:
        definitions: the definitions of a store, by revision.
        rows: the specs and ids of episodes, their revision, and their number.
        newest: the code of the last run, by spec and id; it may have played none of these episodes.
    """
    counts: dict[str, Counter[tuple[tuple[str, str], ...] | None]] = {}
    for names, revision, number in rows:
        code = definitions.get(revision, {}).get("code", {})
        for name in names:
            version = tuple(sorted(code[name].items())) if name in code else None
            counts.setdefault(name, Counter())[version] += number
    for name in counts.keys() & newest.keys():
        counts[name][tuple(sorted(newest[name].items()))] += 0
    return {name: sorted(each.values(), reverse=True) for name, each in sorted(counts.items()) if len(each) > 1}


def mixed_words(name: str, numbers: Sequence[int]) -> str:
    """Several versions of a spec, in words: what a result must say first."""
    episodes = [f"{number:,}" for number in numbers if number]
    if len(episodes) == 1:
        return f"Old code: {name} has changed since its {episodes[0]} episodes were played"
    *first, last = episodes
    return (
        f"Not one result: {name} has changed between episodes, {', '.join(first)} and {last} were played with "
        "different code" + (", none with that of the last run" if len(episodes) < len(numbers) else "")
    )
