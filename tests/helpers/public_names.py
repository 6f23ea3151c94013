"""The public names of the code, and the list of them in `tests/public.txt`."""

import ast
import dataclasses
import re
from collections.abc import Iterable, Iterator
from importlib.util import find_spec
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import typer

MODULES = """
    llf_teacher llf_teacher.compat llf_teacher.studies
    llf_teacher.testing pz_envs.testing teachers.testing worlds.testing
    worlds.pictures.testing worlds.posteriors.testing
    llf_teacher.students.student llf_teacher.students.trait
    pz_envs.family pz_envs.learning teachers.atoms teachers.oracle teachers.personality worlds.world
""".split()  # noqa: SIM905 (words are easier to read than a list of literals)
"""The front doors: the packages that users import, the conformance kits, and the bases of what users add. None of their
names goes or changes without a word in the changelog.
"""
NAMES = """
    llf_teacher.episodes.loop.play_turns
    llf_teacher.gym.lifetime_statistics.FIELDS
    llf_teacher.gym.vector.StudentVectorEnv
    llf_teacher.integrations.inspect.TASKS
    llf_teacher.integrations.trl.FeedbackEnvironment
    llf_teacher.models.client.connect
    llf_teacher.models.settings.ClientSettings
    llf_teacher.models.testing.ScriptedEndpoint
    llf_teacher.people.PersonLearning llf_teacher.people.PersonTeaching
    llf_teacher.registry.family
    llf_teacher.speakers.rewriter.Rewriter
    llf_teacher.students.parsing.parse_student
    llf_teacher.students.scene.Scene
    llf_teacher.studies.analysis.outcomes.outcomes
    llf_teacher.studies.analysis.overall.overall
    llf_teacher.studies.analysis.statistics.mean_interval llf_teacher.studies.analysis.statistics.paired_difference
    llf_teacher.studies.analysis.time_to_success.attempts
    llf_teacher.studies.execution.episode.play
    llf_teacher.studies.execution.limits.Limits
    llf_teacher.studies.execution.runner.RunOptions
    llf_teacher.studies.export.write_export
    pz_envs.parallel_seats.ParallelSeats
    pz_envs.settings.Settings
    teachers.batches.OracleBatch worlds.batches.WorldBatch
    teachers.common.Syntax
    teachers.planning.Exact teachers.planning.Expert
    teachers.reliability.Reliability
    teachers.rules.TownRule worlds.towns.town_stream
    teachers.spec.Count teachers.spec.Range teachers.spec.Share
    worlds.pictures.Picture worlds.posteriors.Posterior
""".split()  # noqa: SIM905
"""Single names that documents or the templates of `llf new` import from other modules, or mention; all else that these
modules define is private.
"""
_HEAD = re.compile(r"# Public names of llf-teacher (\S+),")


def read_list(file: Path) -> tuple[str, set[str]]:
    """The release of which a list was made, and the names."""
    head, *names = file.read_text(encoding="utf-8").splitlines()
    found = _HEAD.match(head)
    assert found, f"{file} must begin with {_HEAD.pattern!r}, got {head!r}"
    return found[1], set(names)


def changes_since(release: str, changelog: Path) -> str:
    """What the changelog says above the section of a release, and the files of `changes`."""
    recent = changelog.read_text(encoding="utf-8").partition(f"\n## {release}\n")[0]
    files = sorted(changelog.parent.glob("changes/*.*.md"))
    return "\n".join([recent, *(path.read_text(encoding="utf-8") for path in files)])


def unexplained(lost: Iterable[str], changes: str) -> list[str]:
    """The names that changes do not mention.

    Its last word or its module is enough; of a number, such as that of `rules gridworld = 2`, all words before it.
    """

    def mentioned(words: str) -> bool:
        return re.search(rf"(?<![\w-]){re.escape(words)}(?![\w-]|\.\w)", changes) is not None

    def explained(name: str) -> bool:
        before, _, number = name.partition(" = ")
        if number:
            return all(map(mentioned, before.split()))
        module, _, last = name.split()[-1].rpartition(".")
        return mentioned(last) or bool(module and mentioned(module))

    return sorted(name for name in lost if not explained(name))


def public_names() -> Iterator[str]:
    """All public names, one a line, each once."""
    from llf_teacher.cli import app
    from llf_teacher.speakers.parsing import SPEAKERS
    from llf_teacher.students.parsing import STUDENTS
    from llf_teacher.studies.definition.study import Study
    from llf_teacher.studies.store.database import SCHEMA_VERSION
    from pz_envs.family import own_families
    from pz_envs.settings import Settings
    from pz_envs.subject import seating_names
    from teachers.personality import PERSONALITIES
    from teachers.seeds import TREE
    from teachers.voice import voice_names

    for module in MODULES:
        yield from (f"name {module}.{name}" for name in _names_of(module))
    yield from (f"name {name}" for name in NAMES if _is_defined(name))
    yield from _commands(typer.main.get_command(app), "llf")
    for family in own_families():
        yield f"rules {family.name} = {family.rules}"
        yield from (f"id llf-{name}" for name in (*family.environments, *family.aliases))
        if not family.extra:  # whose worlds may not be installed
            yield from (f"option {family.name} {name}" for name in family.options())
    yield from (f"seating {name}" for name in seating_names())
    for name in PERSONALITIES.names:
        yield from _spec("teacher", name, PERSONALITIES[name])
    for name, where in SPEAKERS.items():
        yield from _spec("teacher", name, resolve_name(where))
    for name in STUDENTS.names:
        yield from _spec("student", name, STUDENTS[name])
    yield from (f"voice {name}" for name in voice_names())
    yield from (f"setting {field.name}" for field in dataclasses.fields(Settings))
    yield from (f"study {field.name}" for field in dataclasses.fields(Study))
    yield f"store schema = {SCHEMA_VERSION}"
    yield f"seeds tree = {TREE}"


def _names_of(module: str) -> Iterator[str]:
    """The `__all__` of a module, else what it defines without an underscore; read, as importing may need an extra.

    Raises:
        ValueError: there is no such module.
    """
    found = find_spec(module)
    if found is None or found.origin is None:
        raise ValueError(f"there is no module {module}; correct the list in {__file__}")
    defined: list[str] = []
    for node in ast.parse(Path(found.origin).read_text(encoding="utf-8")).body:
        match node:
            case ast.Assign(targets=[ast.Name(id="__all__")], value=value):
                yield from ast.literal_eval(value)
                return
            case ast.ClassDef(name=name) | ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
                defined.append(name)
            case ast.Assign(targets=targets):
                parts = [part for target in targets for part in ast.walk(target)]
                defined += [part.id for part in parts if isinstance(part, ast.Name)]
            case ast.AnnAssign(target=ast.Name(id=name)):
                defined.append(name)
    yield from (name for name in dict.fromkeys(defined) if not name.startswith("_"))


def _is_defined(name: str) -> bool:
    module, _, last = name.rpartition(".")
    return last in _names_of(module)


def _commands(command: Any, path: str) -> Iterator[str]:
    """A command, its options, and the commands below it."""
    yield f"command {path}"
    for param in command.params:
        names = (*param.opts, *param.secondary_opts)
        yield from (f"command {path} {name}" for name in names if name.startswith("--"))
    for name, below in getattr(command, "commands", {}).items():
        yield from _commands(below, f"{path} {name}")


def _spec(kind: str, name: str, cls: Any) -> Iterator[str]:
    yield f"{kind} {name}"
    yield from (f"{kind} {name} {field.name}" for field in dataclasses.fields(cls))
