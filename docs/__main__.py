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
GROUPS = {
    "Start": {
        "docs/quickstart/README": ("docs/quickstart/study", "docs/quickstart/learning", "docs/quickstart/agent"),
        "docs/concepts": (),
        "docs/environments": ("docs/families/README", "docs/families/*"),
        "docs/teachers": ("docs/personality-gallery", "docs/personalities"),
        "docs/students": (),
        "docs/language-models": ("docs/model-options",),
        "docs/claims": (),
    },
    "Guides": {
        "docs/studies": ("docs/reading-a-study", "docs/studies-at-scale"),
        "docs/train-teachers": ("docs/seats", "docs/arrays", "docs/loops"),
        "docs/train-a-model": ("docs/integrations",),
        "docs/suite": (),
        "docs/teach-your-own-environment": (),
        "docs/coming-from-llf-bench": (),
        "docs/in-the-browser": (),
    },
    "Results": {
        "docs/results": (),
        "docs/known-results": (),
    },
    "Reference": {
        "docs/questions": (),
        "docs/words": (),
        "docs/reference/README": ("docs/reference/*",),
        "CHANGELOG": ("SECURITY",),
    },
    "Internals, for those who change the code": {
        "CONTRIBUTING": ("changes/README",),
        "docs/internals/README": ("docs/internals/*",),
    },
}
"""The site: groups of at most seven entries, each with the pages below it; a star stands for all others of a folder."""
REDIRECTS = {
    "docs/a-teacher-that-reads-the-moment": "docs/loops#a-teacher-that-reads-the-moment",
    "docs/bring-your-agent": "docs/students#your-own-agent",
    "docs/catalogue": "docs/internals/catalogue",
    "docs/for-reviewers": "docs/internals/for-reviewers",
    "docs/how-claims-are-checked": "docs/claims",
    "docs/internals": "docs/internals/README",
    "docs/learn-to-teach": "docs/internals/learn-to-teach",
    "docs/learners": "docs/arrays",
    "docs/metaworld": "docs/internals/metaworld",
    "docs/pictures": "docs/environments#pictures",
    "docs/promises": "docs/internals/promises",
    "docs/releasing": "docs/internals/releasing",
    "docs/speed": "docs/internals/speed",
    "docs/statistics": "docs/reading-a-study#statistics-in-one-page",
    "docs/study-feedback": "docs/studies",
    "docs/teaching-as-a-game": "docs/train-teachers",
    "docs/teaching-on-a-budget": "docs/results#when-to-give-advice",
    "docs/what-personalities-do": "docs/results#what-personalities-do",
    "docs/write-your-own-loop": "docs/loops",
}
"""Pages of before, each with the page that has its content now, and perhaps a heading there."""
API = {
    "llf_teacher": ("llf_teacher", "llf_teacher.studies", "llf_teacher.students.student", "llf_teacher.testing"),
    "pz_envs": (
        "pz_envs.family",
        "pz_envs.seatings.tutoring",
        "pz_envs.seatings.classroom",
        "pz_envs.seatings.panel",
        "pz_envs.seatings.curriculum",
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
    unread = shutil.ignore_patterns("__main__.py", "conf.py", "static", "__pycache__")
    shutil.copytree(ROOT / "docs", into / "docs", ignore=unread)
    for name in ("changes", "examples"):
        shutil.copytree(ROOT / name, into / name, ignore=shutil.ignore_patterns("__pycache__"))
    for path in (*ROOT.glob("*.md"), ROOT / "CITATION.cff"):
        shutil.copy(path, into)
    (into / "README.md").rename(into / "index.md")
    for path in (*into.glob("*.md"), *(into / "docs").rglob("*.md")):
        text, up = path.read_text(encoding="utf-8"), "../" * (len(path.relative_to(into).parts) - 1)
        path.write_text(text.replace(f"]({up}README.md", f"]({up}index.md"), encoding="utf-8")
    changelog = into / "CHANGELOG.md"
    links = re.sub(r"(?<=\]\()docs/[^)#]+", lambda link: today(link[0]), changelog.read_text(encoding="utf-8"))
    changelog.write_text(links, encoding="utf-8")
    add_words(into)
    families, reference = into / "docs" / "families", into / "docs" / "reference"
    families.mkdir()
    reference.mkdir()
    write_pages(families)
    write_gallery(into / "docs")
    for package, modules in API.items():
        parts = "".join(
            f"## {name}\n\n```{{eval-rst}}\n.. automodule:: {name}\n   :members:\n```\n\n" for name in modules
        )
        (reference / f"{package}.md").write_text(f"# {package}\n\n{parts}", encoding="utf-8")
    (reference / "README.md").write_text(REFERENCE, encoding="utf-8")
    for caption, entries in GROUPS.items():
        _add_tree(into / "index.md", into, list(entries), caption)
        for entry, below in entries.items():
            if names := [name for pattern in below for name in _named(pattern, into)]:
                _add_tree(into / f"{entry}.md", into, names)


def today(file: str) -> str:
    """The file that has the content of a page of before, such as `docs/speed.md`; of every other page its own."""
    new = REDIRECTS.get(file.removesuffix(".md"))
    return f"{new.partition('#')[0]}.md" if new else file


def add_words(folder: Path) -> None:
    """Enter the words of `words.md` into the index, at the places that it names: the search shows these first."""
    for words, links in WORDS.findall((folder / "docs" / "words.md").read_text(encoding="utf-8")):
        entries = "".join(f"   ! single: {word}\n" for word in words.split(", "))
        name, anchor = re.findall(r"\]\(([^)#]+)#?([^)]*)\)", links)[0]
        page = (folder / "docs" / name).resolve()
        text = page.read_text(encoding="utf-8")
        heads = {re.sub(r"[^\w -]", "", head[1]).lower().replace(" ", "-"): head.end() for head in HEADS.finditer(text)}
        at = heads[anchor] if anchor else min(heads.values())
        directive = f"\n```{{eval-rst}}\n.. index::\n{entries}```\n"
        page.write_text(f"{text[:at]}{directive}{text[at:]}", encoding="utf-8")


HEADS = re.compile(r"^#+ (.*)\n", re.MULTILINE)
WORDS = re.compile(r"^\| ([^|`]+) \|[^|]+\| (.*\]\(.*) \|$", re.MULTILINE)
"""A row of `words.md`: what people look for, and its pages, of which the first is meant."""


def _named(pattern: str, folder: Path) -> list[str]:
    """The pages of a pattern, without their suffix."""
    found = sorted(path.relative_to(folder).with_suffix("").as_posix() for path in folder.glob(f"{pattern}.md"))
    return [name for name in found if not name.endswith("/README")] if "*" in pattern else [pattern]


def _add_tree(page: Path, folder: Path, names: list[str], caption: str = "") -> None:
    """Add a hidden list of pages to a page; the site's navigation shows it."""
    options = f":hidden:\n:caption: {caption}\n" if caption else ":hidden:\n"
    listed = "\n".join(_entry(folder, name) for name in names)
    with page.open("a", encoding="utf-8") as file:
        file.write(f"\n```{{toctree}}\n{options}\n{listed}\n```\n")


def _entry(folder: Path, name: str) -> str:
    """A line of a list of pages: of `Seats: how ...?` the subject alone; a long title gives way to the file's name."""
    path = folder / f"{name}.md"
    title = path.read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ") if path.exists() else ""
    subject, colon, _ = title.partition(": ")
    if colon and title.endswith("?"):
        return f"{subject} </{name}>"
    return f"{path.stem.replace('_', ' ')} </{name}>" if len(title) > LONGEST else f"/{name}"


LONGEST = 60
"""Characters of a title in the site's navigation."""
REFERENCE = """# Modules and classes

What can be imported, by package, made from the docstrings: [llf_teacher](llf_teacher.md), with studies and students;
[pz_envs](pz_envs.md), seats; [teachers](teachers.md), claims, oracles, personalities; [worlds](worlds.md).
"""


def write_pages(folder: Path) -> None:
    """Write a page and a film of each family, and a gallery of all."""
    from llf_teacher.tools.pages import family_page, write_film
    from pz_envs.family import own_families

    shown = [
        "# Gallery of families\n\nA lesson of each, by a teacher that errs now and then: each sentence is marked.\n"
    ]
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
        picture = f"![A lesson of {family.name}]({film.name})\n" if film.exists() else ""
        words = f"{family.summary[:1].upper()}{family.summary[1:]}: [all about {family.name}]({family.name}.md)."
        shown.append(f"## {family.name}\n\n{words}\n\n{picture}")
    (folder / "README.md").write_text("\n".join(shown), encoding="utf-8")


def write_gallery(folder: Path) -> None:
    """Write the gallery of personalities, with films of one lesson under several of them."""
    from llf_teacher.tools.pages import LESSONS, gallery, write_lesson

    films = folder / "lessons"
    films.mkdir()
    for number, spec in enumerate(LESSONS):
        write_lesson(spec, films / f"{number}.webp")
    page = gallery([f"lessons/{number}.webp" for number in range(len(LESSONS))])
    (folder / "personality-gallery.md").write_text(page, encoding="utf-8")


def figures(family: str) -> str:
    """What the documents have measured: the rows of their tables of families, with their heads."""
    found = []
    for path in sorted((ROOT / "docs").rglob("*.md")):
        for name, head, rows in TABLE.findall(path.read_text(encoding="utf-8")):
            own = [row for row in rows.splitlines() if row.startswith(f"| {family} |")]
            if name == "family" and own and len(re.findall(r"\| -?[\d.,]+ ", own[0])) > 1:
                lines = [f"| family |{head}", "|---" * (1 + head.count("|")) + "|", *own]
                page = path.relative_to(ROOT / "docs").as_posix()
                found.append(f"From [{path.stem}](../{page}):\n\n" + "\n".join(lines) + "\n\n")
    return "\n## Published figures\n\n" + "".join(found) if found else ""


TABLE = re.compile(r"^\| (\w+) \|(.*)\n\|[-| ]+\n((?:\|.*\n)+)", re.MULTILINE)
"""A table of a document: its first head, its others, its rows."""


def redirect(site: Path) -> None:
    """Write a page at each address of before, which leads to the new one.

    Raises:
        ValueError: the new page is missing, or the address of before is in use.
    """
    for old, new in REDIRECTS.items():
        page, _, anchor = new.partition("#")
        path, target = site / f"{old}.html", site / f"{page}.html"
        if not target.exists() or path.exists():
            raise ValueError(f"the redirect from {old} must lead from an address that is free to a page, got: {new}")
        address = os.path.relpath(target, path.parent) + (f"#{anchor}" if anchor else "")
        path.write_text(REDIRECT.format(address=address), encoding="utf-8")


REDIRECT = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="robots" content="noindex"><title>This page has moved</title>
<link rel="canonical" href="{address}"><meta http-equiv="refresh" content="0; url={address}"></head>
<body><p>This page has moved: <a href="{address}">go to the new one</a>.</p></body></html>
"""


def main() -> int:
    """Gather and build; the status is Sphinx's."""
    from sphinx.cmd.build import main as build

    site = sys.argv[1] if len(sys.argv) > 1 else "site"
    with tempfile.TemporaryDirectory() as folder:
        gather(Path(folder))
        status = int(build(["-b", "html", "-W", "--keep-going", "-q", "-c", str(ROOT / "docs"), folder, site]))
    if not status:
        redirect(Path(site))
    return status


if __name__ == "__main__":
    if sys.platform == "linux":
        os.environ.setdefault("MUJOCO_GL", "egl")
    sys.path[:] = [path for path in sys.path if Path(path).resolve() != ROOT / "docs"]
    sys.exit(main())
