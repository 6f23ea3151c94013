"""Tables of families and personalities for the documents, made from the code."""

import dataclasses
import inspect
import sys
from pathlib import Path
from typing import Any

from llf_teacher.tools import markdown
from llf_teacher.tools.markdown import table
from pz_envs.family import Family, all_families
from teachers.personality import PERSONALITIES

_COMMAND = "llf dev tables"
_SEED = 7


def families() -> str:
    """A Markdown table of the families: environments, task, turns."""
    rows: list[tuple[str, ...]] = []
    for family in _own_families():
        names = [f"`llf-{name}`" for name in family.showcase[:1]]
        more = len(family.environments) - len(names)
        ids = f"{names[0]} and {more} more" if more else names[0]
        rows.append((family.name, ids, family.summary, str(family.max_turns)))
    return table(("family", "environments", "task", "turns"), rows)


def oracles() -> str:
    """A Markdown table of the families: unit of regret, what the oracle does."""
    rows: list[tuple[str, ...]] = []
    for family in _own_families():
        doc = inspect.getdoc(family.oracle_class()) or ""
        rows.append((family.name, family.regret_unit, " ".join(doc.partition("\n\n")[0].split())))
    return table(("family", "regret counts", "its oracle"), rows)


def definition(name: str, cls: type) -> str:
    """What a personality, a student or a trait does: the first line of its module, behind its name; else empty."""
    first, _, _ = (sys.modules[cls.__module__].__doc__ or "").partition("\n")
    head, _, said = first.partition(": ")
    return said if head.partition("(")[0] == name else ""


def personalities() -> str:
    """A Markdown table of the personalities: parameters, definition, source, honesty."""
    rows: list[tuple[str, ...]] = []
    for name in PERSONALITIES.names:
        cls: Any = PERSONALITIES[name]
        parameters = ", ".join(f"{field.name}={field.default!r}" for field in dataclasses.fields(cls))
        honest = "yes" if cls().honest else "no"
        rows.append(
            (f"`{name}({parameters})`" if parameters else f"`{name}`", definition(name, cls), cls.source, honest)
        )
    return table(("personality", "what it does", "source", "honest"), rows)


def matrix() -> str:
    """A Markdown table of the families that each personality can teach, with its requirements of an oracle."""
    families = _own_families()
    rows = []
    for name in PERSONALITIES.names:
        served = [_served(family, name) for family in families]
        rows.append((f"`{name}`", ", ".join(sorted(PERSONALITIES[name]().needs)), *served))
    return table(("personality", "needs", *(family.name for family in families)), rows)


def _served(family: Family, personality: str) -> str:
    """Whether a family supports a personality, or the options of its worlds that this needs."""
    if family.serves(personality):
        return "yes"
    needs = family.posterior_needs
    given = ", ".join(f"{name}={value!r}" for name, value in needs.items())
    return f"with `{given}`" if family.serves(personality, **needs) else "-"


def clues() -> str:
    """A Markdown table of the first and the last clue at the opening of an episode of each family, in plain words."""
    rows = []
    for family in _own_families():
        world = family.make_world(**family.environments[family.showcase[0]])
        world.reset(seed=_SEED)
        oracle = family.make_teacher(world).oracle
        oracle.start(world.truth)
        if found := oracle.clues(world.truth):
            told = (
                f"{family.phrasebook().sentences(each)[0]} ({each.kind}, {each.scope})"
                for each in (found[0], found[-1])
            )
            rows.append((family.name, *map(markdown.escape, told)))
    return table(("family", "the first clue", "the last"), rows)


def _own_families() -> list[Family]:
    """The installed families of this distribution."""
    return [family for family in all_families() if not family.version and not family.missing()]


TABLES = {"families": families, "oracles": oracles, "personalities": personalities, "matrix": matrix, "clues": clues}


def update(text: str) -> str:
    """The text with new tables between the markers `<!-- llf dev tables: NAME -->` and `<!-- end -->`.

    Raises:
        ValueError: there are no markers, or a name is not in `TABLES`.
    """
    names = markdown.marked(text, _COMMAND)
    if not names or set(names) - set(TABLES):
        raise ValueError(
            "the document must have markers for tables, `<!-- llf dev tables: NAME -->` and `<!-- end -->`, "
            f"got: {', '.join(names) or 'none'}; allowed names: {', '.join(TABLES)}"
        )
    return markdown.update(text, _COMMAND, {name: TABLES[name]() for name in names})


def documents(folder: Path) -> list[Path]:
    """The documents in a folder, `*.md` and `docs/*.md`, that have markers for tables."""
    paths = sorted([*folder.glob("*.md"), *folder.glob("docs/*.md")])
    return [path for path in paths if markdown.marked(path.read_text(encoding="utf-8"), _COMMAND)]


def write(path: Path) -> None:
    """Write the tables of a file anew.

    Raises:
        ValueError: as in `update`, or the file cannot be read.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"cannot read {path}: {error}; give a Markdown file with markers for tables") from None
    path.write_text(update(text), encoding="utf-8")
