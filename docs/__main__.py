"""Make the site: `python docs [FOLDER]`. Needs the extra `docs`; warnings are errors.

The documents are gathered in a folder that is thrown away, with pages that are made of the code, so that nothing is
left in the source tree and the documents stay as a code host shows them.
"""

import os
import re
import shutil
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
USERS = ("study-feedback", "train-teachers", "have-an-agent")
"""A page for each kind of user."""
API = {
    "llf_teacher": ("llf_teacher", "llf_teacher.studies", "llf_teacher.students.student", "llf_teacher.testing"),
    "pz_envs": (
        "pz_envs.family",
        "pz_envs.seatings.tutoring",
        "pz_envs.seatings.classroom",
        "pz_envs.seatings.panel",
        "pz_envs.rewards",
        "pz_envs.parallel_seats",
        "pz_envs.testing",
    ),
    "teachers": ("teachers.atoms", "teachers.oracle", "teachers.personality", "teachers.teacher", "teachers.testing"),
    "worlds": ("worlds.world", "worlds.spaces", "worlds.pictures", "worlds.testing"),
}
"""The modules of the reference, by package."""


def gather(into: Path) -> None:
    """Put all that Sphinx reads into a folder."""
    shutil.copytree(ROOT / "docs", into / "docs", ignore=shutil.ignore_patterns("*.py", "__pycache__"))
    for name in ("changes", "examples"):
        shutil.copytree(ROOT / name, into / name, ignore=shutil.ignore_patterns("__pycache__"))
    for path in (*ROOT.glob("*.md"), ROOT / "CITATION.cff"):
        shutil.copy(path, into)
    (into / "README.md").rename(into / "index.md")
    for path in into.rglob("*.md"):
        text = path.read_text(encoding="utf-8")
        path.write_text(re.sub(r"(\]\((?:\.\./)?)README\.md", r"\1index.md", text), encoding="utf-8")
    families, reference = into / "docs" / "families", into / "docs" / "reference"
    families.mkdir()
    reference.mkdir()
    made = write_pages(families)
    for package, modules in API.items():
        parts = "".join(
            f"## {name}\n\n```{{eval-rst}}\n.. automodule:: {name}\n   :members:\n```\n\n" for name in modules
        )
        (reference / f"{package}.md").write_text(f"# {package}\n\n{parts}", encoding="utf-8")
    listed = {
        "Begin": [*USERS, "how-claims-are-checked"],
        "Families": [f"families/{name}" for name in made],
        "Reference": [f"reference/{package}" for package in API],
    }
    told = {name for names in listed.values() for name in names}
    listed["Guides"] = sorted({path.stem for path in (ROOT / "docs").glob("*.md")} - told)
    trees = "".join(_tree(caption, names) for caption, names in listed.items())
    others = "\n".join(
        [
            *sorted(path.stem for path in into.glob("*.md") if path.stem != "index"),
            "changes/README",
            "docs/readings/README",
        ]
    )
    index = into / "index.md"
    text = index.read_text(encoding="utf-8")
    index.write_text(f"{text}\n{trees}```{{toctree}}\n:hidden:\n:caption: Project\n\n{others}\n```\n", encoding="utf-8")


def _tree(caption: str, names: list[str]) -> str:
    listed = "\n".join(f"docs/{name}" for name in names)
    return f"```{{toctree}}\n:hidden:\n:caption: {caption}\n\n{listed}\n```\n\n"


def write_pages(folder: Path) -> list[str]:
    """Write what is made of the code, and name it."""
    from llf_teacher.tools.pages import family_page, gallery, write_film
    from pz_envs.family import own_families

    names = []
    for family in own_families():
        if family.missing():
            continue
        film = folder / f"{family.name}.webp"
        try:
            write_film(family, film)
        except RuntimeError as error:  # of a simulator without OpenGL
            print(f"{family.name} is not filmed: {error}", file=sys.stderr)  # noqa: T201 (a command's own words)
        page = family_page(family, film.name if film.exists() else "") + figures(family.name)
        (folder / f"{family.name}.md").write_text(page, encoding="utf-8")
        names.append(family.name)
    (folder / "gallery.md").write_text(gallery(), encoding="utf-8")
    return [*names, "gallery"]


def figures(family: str) -> str:
    """What the documents have measured: the rows of their tables of families, with their heads."""
    found = []
    for path in sorted((ROOT / "docs").glob("*.md")):
        for name, head, rows in TABLE.findall(path.read_text(encoding="utf-8")):
            own = [row for row in rows.splitlines() if row.startswith(f"| {family} |")]
            if name == "family" and own and len(re.findall(r"\| -?[\d.,]+ ", own[0])) > 1:
                lines = [f"| family |{head}", "|---" * (1 + head.count("|")) + "|", *own]
                found.append(f"From [{path.stem}](../{path.name}):\n\n" + "\n".join(lines) + "\n\n")
    return "\n## Published figures\n\n" + "".join(found) if found else ""


TABLE = re.compile(r"^\| (\w+) \|(.*)\n\|[-| ]+\n((?:\|.*\n)+)", re.MULTILINE)
"""A table of a document: its first head, its others, its rows."""


def main() -> int:
    """Gather and build; the status is Sphinx's."""
    from sphinx.cmd.build import main as build

    site = sys.argv[1] if len(sys.argv) > 1 else "site"
    with tempfile.TemporaryDirectory() as folder:
        gather(Path(folder))
        return int(build(["-b", "html", "-W", "--keep-going", "-q", "-c", str(ROOT / "docs"), folder, site]))


if __name__ == "__main__":
    if sys.platform == "linux":
        os.environ.setdefault("MUJOCO_GL", "egl")
    sys.path[:] = [path for path in sys.path if Path(path).resolve() != ROOT / "docs"]
    sys.exit(main())
