"""The pages that are made of the code."""

import sys

import pytest

from llf_teacher.registry import family
from llf_teacher.tools.markdown import escape, table
from llf_teacher.tools.pages import LESSONS, family_page, gallery, gallery_entry, write_film, write_lesson
from llf_teacher.tools.pages.families import examples
from pz_envs.family import own_families
from teachers.oracle import claims_of
from teachers.personality import PERSONALITIES


@pytest.mark.parametrize(
    "one",
    [pytest.param(one, id=one.name, marks=[pytest.mark.full] if one.slow else []) for one in own_families()],
)
def test_a_family_has_a_page(one):
    if why := one.missing():
        pytest.skip(why)
    page = family_page(one, "film.webp")
    assert page.startswith(f"# {one.name}\n")
    assert "](film.webp)" in page
    for cls in claims_of(one.oracle_class().__module__):
        (row,) = [line for line in page.splitlines() if line.startswith(f"| `{cls.__name__}` |")]
        assert all(cell.strip() for cell in (row.split(" | ")[i] for i in (1, 3, 4, 5)))
    for name in one.environments:
        assert f"| `llf-{name}` |" in page
    for option in one.options():
        assert f"| `{option}` |" in page or option == "render_mode"


def test_examples_are_sentences_of_claims_that_were_made():
    made = {cls.__name__: text for cls, text in examples(family("gridworld")).items()}
    assert {"Goal", "Go", "Avoid", "Nearer", "NoNearer", "Route", "TriedWell", "InRoom"} <= made.keys()
    assert not any("{" in text for text in made.values())


def test_a_film_is_small(tmp_path):
    write_film(family("bandits"), tmp_path / "film.webp")
    assert 1000 < (tmp_path / "film.webp").stat().st_size <= 200_000


def test_the_gallery_shows_a_lesson_under_several_personalities(tmp_path, monkeypatch):
    monkeypatch.setattr(sys.modules[gallery.__module__], "gallery_entry", str)
    page = gallery([f"{number}.webp" for number in range(len(LESSONS))])
    assert [line for line in page.splitlines() if line.startswith("`")] == [f"`{spec}`" for spec in LESSONS]
    sizes = set()
    for spec in list(LESSONS)[:2]:
        write_lesson(spec, tmp_path / "film.webp")
        sizes.add((tmp_path / "film.webp").stat().st_size)
    assert len(sizes) == 2


@pytest.mark.parametrize("name", [name for name in PERSONALITIES.names if name != "oracle"])
def test_each_personality_differs_from_the_oracle_somewhere(name):
    entry = gallery_entry(name)
    head, *rows = [line for line in entry.splitlines() if line.startswith("| ")]
    assert head.startswith("| turn | action | `oracle` | `")
    assert name in head
    _, first, *_ = rows
    *_, plain, own, _ = first.split("|") if "\\|" not in first else ("", "", "a", "b", "")
    assert plain.strip() != own.strip()


def test_text_in_tables_means_nothing():
    assert escape("a|b <c> *d* `e|f`\ng") == "a\\|b \\<c\\> \\*d\\* `e|f` g"
    assert table(("x",), [("`e|f`",)]) == "| x |\n| --- |\n| `e\\|f` |\n"
