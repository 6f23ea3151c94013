"""Screenshots of what people read, to be looked at: `.ci/screenshots FOLDER`.

README as a code host shows it, the site's start page, ten of its pages and a family's, the report in three places, the
page of `llf serve` in three seats, and a frame of a film: each at three widths, on a light and on a dark screen.
"""

import argparse
import base64
import contextlib
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

from llf_teacher.studies import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.report import render
from llf_teacher.studies.store import Store
from llf_teacher.theme import style
from llf_teacher.tools.film import film

try:
    from browsing import browsing, programs, serving
    from markdown_it import MarkdownIt
except ModuleNotFoundError as error:
    sys.exit(f"screenshots need {error.name}: pip install -e '.[all,browser,docs,web]' -c constraints.txt")

ROOT = Path(__file__).resolve().parents[2]
WIDTHS = (390, 768, 1200)
"""A phone, a tablet, a screen."""
_HEIGHTS = {390: 844, 768: 1024, 1200: 900}
_MOST = 2400  # pixels of a page that are shown
_STUDY = Study(
    ids=("llf-bandits-BanditTenArmedGaussian-v0", "llf-gridworld-v0"),
    teachers=("oracle", "mistake(eps=0.3)", "delayed(turns=2)", "only(kinds='hn')", "retry_only", "silent"),
    students=("random", "text_only", "obedient"),
    seeds=12,
)
_HEAD = (
    '<!DOCTYPE html><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
    f"<style>{style()} img {{ max-width: 100%; height: auto; }}</style>"
)
_GUIDES = (
    "concepts",
    "environments",
    "language-models",
    "reading-a-study",
    "results",
    "students",
    "studies",
    "suite",
    "teachers",
    "train-teachers",
)
_SEATS = {"student": ["west"], "teacher": ["Let oracle speak"], "watch": ["Next turn"] * 3}


def main() -> int:
    """Take all of them, or those whose names contain a word."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="for the pictures, which are named PAGE-WIDTH-THEME.png")
    parser.add_argument("--site", type=Path, help="a site that `python docs FOLDER` has made; else it is made")
    parser.add_argument("--only", default="", help="a part of the names of the pages to take")
    arguments = parser.parse_args()
    try:
        programs()
    except RuntimeError as error:
        print(error, file=sys.stderr)
        return 1
    arguments.folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch, contextlib.ExitStack() as stack:
        pages = written(Path(scratch), arguments.only, arguments.site)
        seats = {f"seat-{seat}": seat for seat in _SEATS if arguments.only in f"seat-{seat}"}
        address = stack.enter_context(serving()) if seats else ""
        for width in WIDTHS:
            for theme in ("light", "dark"):
                with browsing(width, _HEIGHTS[width], theme == "dark") as visitor:
                    for name, (page, place) in pages.items():
                        visitor.driver.get(page.resolve().as_uri())
                        show(visitor, place)
                        take(visitor, arguments.folder / f"{name}-{width}-{theme}.png", width)
                    for name, seat in seats.items():
                        sit(visitor, address, seat)
                        take(visitor, arguments.folder / f"{name}-{width}-{theme}.png", width, _HEIGHTS[width])
    return 0


def written(folder: Path, only: str, site: Path | None) -> dict[str, tuple[Path, str]]:
    """The files of pages, each with the place in it that is shown, by name."""
    pages: dict[str, tuple[Path, str]] = {}
    if only in "readme":
        body = MarkdownIt("commonmark").enable("table").render((ROOT / "README.md").read_text(encoding="utf-8"))
        head = f"{_HEAD}<base href={ROOT.as_uri()}/>"
        pages["readme"] = _file(folder / "readme.html", f"{head}{body}"), ""
    site_pages = {"site-start": "index", "site-family": "docs/families/gridworld"}
    site_pages |= {f"site-{name}": f"docs/{name}" for name in _GUIDES}
    if any(only in name for name in site_pages):
        if site is None:
            site = folder / "site"
            subprocess.run([sys.executable, "docs", f"{site}"], cwd=ROOT, check=True)
        pages |= {name: (site / f"{page}.html", "") for name, page in site_pages.items()}
    reports = {"report-top": "", "report-figures": "#gridworld-b-a", "report-transcript": "#gridworld-b-a-transcripts"}
    if any(only in name for name in reports):
        store = Store(folder / "study.db")
        for spec in _STUDY.episodes():
            store.add(play(spec))
        report = _file(folder / "report.html", render(store, _STUDY))
        pages |= {name: (report, place) for name, place in reports.items()}
    if only in "film-frame":
        for theme in ("light", "dark"):
            frames = film(
                "llf-gridworld-v0",
                student="obedient",
                seed=7,
                teacher="mistake(eps=0.4)",
                theme=theme,
                privileged_info=True,
            )
            Image.fromarray(frames[3]).save(folder / f"{theme}.png")
        sources = '<source srcset="dark.png" media="(prefers-color-scheme: dark)"><img src="light.png">'
        pages["film-frame"] = _file(folder / "film.html", f"{_HEAD}<picture>{sources}</picture>"), ""
    return {name: page for name, page in pages.items() if only in name}


def _file(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def show(visitor, place: str) -> None:
    """Go to a place of the page, and open what is folded there."""
    script = """
        const place = arguments[0] && document.querySelector(arguments[0]);
        if (!place) return scrollTo(0, 0);
        if (arguments[0].endsWith("-transcripts"))
          for (const each of [...place.closest("section").querySelectorAll("details")].slice(-2)) each.open = true;
        place.scrollIntoView();
    """
    visitor.driver.execute_script(script, place)


def sit(visitor, address: str, seat: str) -> None:
    """Begin a lesson, and play a few turns."""
    teacher = "oracle" if seat == "teacher" else "mistake(eps=0.4)"
    visitor.begin(address, seat=seat, teacher=teacher, seed=7)
    for turn, button in enumerate(_SEATS[seat], 1):
        visitor.press(button)
        visitor.shows("#status", f"Turn {turn} ")
    visitor.drawn()
    visitor.driver.execute_script("document.activeElement.blur(); scrollTo(0, 0)")


def take(visitor, path: Path, width: int, most: int = _MOST) -> None:
    """A picture from the place that is shown downwards."""
    top, whole = visitor.driver.execute_script("return [scrollY, document.documentElement.scrollHeight]")
    clip = {"x": 0, "y": top, "width": width, "height": min(most, whole - top), "scale": 1}
    settings = {"format": "png", "captureBeyondViewport": True, "clip": clip}
    shot = visitor.driver.execute_cdp_cmd("Page.captureScreenshot", settings)
    path.write_bytes(base64.b64decode(shot["data"]))
    print(path)


if __name__ == "__main__":
    sys.exit(main())
