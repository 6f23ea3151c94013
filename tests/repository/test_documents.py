"""The documents' examples run, and their two commands are as promised."""

import importlib
import itertools
import re
import runpy
import shlex
import shutil
import tomllib
from collections import Counter
from importlib import resources

import pytest
from commands import llf
from documents import BLOCK, DOCUMENTS, LINKED, ROOT, python_blocks

import llf_teacher
from llf_teacher.tools.tables import documents, families, matrix, update
from pz_envs.family import all_families
from teachers.personality import PERSONALITIES
from worlds.movies.catalogue import shipped

LEARN = "# Needs the extra `learn`"
ELSEWHERE = "# Needs the extra `trl`"  # tests/integrations runs it
BLOCKS = [
    pytest.param(code, id=name, marks=[pytest.mark.full] if code.startswith(LEARN) else [])
    for name, code in python_blocks(shown=False).items()
    if not code.startswith(ELSEWHERE)
]


@pytest.mark.parametrize("code", BLOCKS)
def test_example_runs(code, tmp_path):
    (tmp_path / "example.py").write_text(code, encoding="utf-8")
    runpy.run_path(str(tmp_path / "example.py"))


@pytest.mark.parametrize("path", [path for path in DOCUMENTS if "\n```output\n" in path.read_text(encoding="utf-8")])
def test_shown_output_is_what_the_snippet_before_it_prints(path, tmp_path, capsys):
    blocks = BLOCK.findall(path.read_text(encoding="utf-8"))
    shown = [number for number, (language, _) in enumerate(blocks) if language == "output"]
    for number in shown:
        language, code = blocks[number - 1]
        assert language == "python"
        (tmp_path / "snippet.py").write_text(code, encoding="utf-8")
        runpy.run_path(str(tmp_path / "snippet.py"))
        assert capsys.readouterr().out == blocks[number][1]


def test_loops_of_ones_own_are_short():
    page = (ROOT / "docs" / "loops.md").read_text(encoding="utf-8")
    below = page[page.index("\n## A bandit over personalities\n") :]
    loops = [code for language, code in BLOCK.findall(below) if language == "python"]
    assert len(loops) == 5
    assert all(len(code.splitlines()) <= 30 for code in loops)


def test_the_readme_shows_what_each_snippet_prints():
    blocks = BLOCK.findall((ROOT / "README.md").read_text(encoding="utf-8"))
    languages = [language for language, _ in blocks if language in ("python", "output")]
    assert languages == ["python", "output"] * (len(languages) // 2) != []


def test_the_two_commands():
    readme = (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
    assert '    pip install -e ".[all]" -c constraints.txt && llf study' in readme
    assert '    pip install -e ".[all,test]" -c constraints.txt && pytest' in readme
    assert 'pip install -e ".[all,test]" -c constraints.txt && pytest' in (ROOT / ".ci" / "run").read_text()


def test_the_readme_begins_with_a_lesson_that_is_marked():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (command,) = re.findall(r"^    llf (play .+)$", readme, re.MULTILINE)
    shown = llf(*shlex.split(command)).stdout
    assert shown.count("[✗ false]") == int(re.search(r"(\d+) of the \d+ checked sentences were false", shown)[1]) > 0
    assert "[✓ true]" in shown


def test_the_two_commands_compile_nothing():
    """TextWorld's engine would be."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    wanted = {re.match(r"[\w-]+", each)[0] for each in project["dependencies"] + extras["all"] + extras["test"]}
    assert "pettingzoo" in wanted
    assert not wanted & {"alfworld", "textworld", project["name"]}


def test_each_environment_of_learners_and_frameworks_has_an_extra_and_pins():
    """Names and versions only, so that they hold wherever the packages come from."""
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    rooms = [path for room in ("rl", "integrations") for path in (ROOT / "tests" / room).iterdir() if path.is_dir()]
    files = {
        room.name: ROOT / f"constraints-{room.name}.txt" if room.parent.name == "rl" else room / "constraints.txt"
        for room in rooms
        if room.name[0] != "_"
    }
    assert {"learn", "trl", "openenv"} <= files.keys()
    for name, file in files.items():
        pins = file.read_text(encoding="utf-8").splitlines()[1:]
        assert all(re.fullmatch(r"[\w.-]+==[\w.]+", pin) for pin in pins)
        pinned = {re.sub(r"[-_.]+", "-", pin.partition("==")[0]).lower() for pin in pins}
        assert {re.match(r"[\w-]+", each)[0] for each in extras[name]} <= pinned


def test_the_lesson_of_the_concepts_was_given():
    """Each sentence, with its kind and its label, stands in the golden transcript."""
    page = (ROOT / "docs" / "concepts.md").read_text(encoding="utf-8")
    golden = (ROOT / "tests" / "golden" / "llf-gridworld-v0.txt").read_text(encoding="utf-8")
    (lesson,) = [code for language, code in BLOCK.findall(page) if language == "text"]
    opening, first, second = re.split(r"^student +(?:south|west)$", lesson, flags=re.MULTILINE)
    assert " ".join(opening.removeprefix("teacher").split()).removesuffix(" ...") in golden
    turns = re.findall(r"^== turn [12]\naction: (\d).*?feedback: '(.*?)'$(.*?)^$", golden, re.DOTALL | re.MULTILINE)
    assert [action for action, *_ in turns] == ["3", "2"]  # south, west
    for told, (_, feedback, claims) in zip((first, second), turns, strict=True):
        said = " ".join(told.partition("teacher")[2].split())
        sentences = re.findall(r"(.+?) (r|hp|hn|fp|fn) true ?", said)
        assert said.count(" true") == len(sentences) > 0
        for sentence, kind in sentences:
            assert sentence in feedback
            assert re.search(rf"^  {kind} .* holds$", claims, re.MULTILINE)


def test_badges_and_citation_are_those_of_the_project():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    badges = (ROOT / "docs" / "badges.svg").read_text(encoding="utf-8")
    assert f">{project['requires-python'].replace('>', '&gt;')}<" in badges
    assert f">{project['license']}<" in badges
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {llf_teacher.__version__}\n" in citation
    assert f"\nlicense: {project['license']}\n" in citation
    assert f'repository-code: "{project["urls"]["Repository"]}"' in citation


def test_the_texts_for_lists_name_the_versions_that_are_tested():
    page = (ROOT / "docs" / "internals" / "releasing.md").read_text(encoding="utf-8")
    pins = dict(line.split("==") for line in (ROOT / "constraints.txt").read_text().splitlines() if "==" in line)
    for name in ("Gymnasium", "PettingZoo"):
        assert f"/badge/{name}-v{pins[name.lower()]}-blue" in page


SITE = runpy.run_path(str(ROOT / "docs" / "__main__.py"))
MADE = {
    "docs/families/README",
    "docs/families/*",
    "docs/personality-gallery",
    "docs/reference/README",
    "docs/reference/*",
}
"""Pages that are made as the site is."""


def test_the_site_is_pinned():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    pinned = (ROOT / "constraints.txt").read_text(encoding="utf-8").lower()
    assert all(f"\n{re.match(r'[a-z-]+', each)[0]}==" in pinned for each in extras["docs"] + extras["notebook"])
    assert "| 112,056 |" in SITE["figures"]("gridworld")
    assert not SITE["figures"]("bandit")
    for module in itertools.chain(*SITE["API"].values()):
        assert importlib.import_module(module).__doc__


def test_the_site_has_five_groups_of_at_most_seven_entries_and_each_page_once():
    groups = SITE["GROUPS"]
    assert [group.partition(",")[0] for group in groups] == ["Start", "Guides", "Results", "Reference", "Internals"]
    assert all(0 < len(entries) <= 7 for entries in groups.values())
    listed = [page for entries in groups.values() for entry, below in entries.items() for page in (entry, *below)]
    named = [page for page in listed if page not in MADE and "*" not in page]
    folders = [page.removesuffix("*") for page in listed if "*" in page]
    there = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "docs" / "quickstart").glob("*.py")]
    pages = {path.relative_to(ROOT).with_suffix("").as_posix() for path in there}
    pages -= {page for page in pages if page not in named and page.startswith(tuple(folders))} | {"README"}
    assert sorted(named) == sorted(pages | {"changes/README"})


def test_users_read_some_twenty_pages():
    """All else is for those who change the code, or is made or looked up."""
    groups = SITE["GROUPS"]
    read = [
        page
        for name in ("Start", "Guides", "Results")
        for entry, below in groups[name].items()
        for page in (entry, *below)
    ]
    pages = [page for page in read if (ROOT / f"{page}.md").exists() and page != "docs/personalities"]
    assert 16 <= len(pages) <= 23
    for page in [*pages, "docs/questions"]:
        title = (ROOT / f"{page}.md").read_text(encoding="utf-8").partition("\n")[0]
        assert title.endswith("?"), f"{page}: the title must be the question that the page answers"


BEFORE = """
a-teacher-that-reads-the-moment bring-your-agent catalogue coming-from-llf-bench concepts environments
for-reviewers how-claims-are-checked in-the-browser integrations internals known-results learn-to-teach
learners metaworld personalities pictures promises questions quickstart/README reading-a-study releasing
results speed statistics studies-at-scale study-feedback suite teach-your-own-environment teaching-as-a-game
teaching-on-a-budget train-a-model what-personalities-do words write-your-own-loop
"""
"""The pages in `docs` of the site before it had internals."""


def test_addresses_of_before_lead_to_the_page_of_today(tmp_path):
    """Each page of before is there, or leads to one that is, and to its heading."""
    redirects = SITE["REDIRECTS"]
    assert not [old for old in redirects if (ROOT / f"{old}.md").exists()]
    before = {f"docs/{name}" for name in BEFORE.split()}
    assert len(before) == 35
    assert not [page for page in before if page not in redirects and not (ROOT / f"{page}.md").exists()]
    assert set(redirects) <= before
    for new in redirects.values():
        page, _, anchor = new.partition("#")
        assert not anchor or anchor in headings(ROOT / f"{page}.md"), new
        path = tmp_path / f"{page}.html"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("", encoding="utf-8")
    SITE["redirect"](tmp_path)
    for old, new in redirects.items():
        (address,) = re.findall(r'url=([^"]+)"', (tmp_path / f"{old}.html").read_text(encoding="utf-8"))
        file, _, anchor = address.partition("#")
        page, _, wanted = new.partition("#")
        assert ((tmp_path / old).parent / file).resolve() == (tmp_path / f"{page}.html").resolve()
        assert anchor == wanted
    with pytest.raises(ValueError, match="must lead from an address that is free to a page, got: docs/"):
        SITE["redirect"](tmp_path)


def test_the_page_of_words_has_what_people_look_for():
    words = (ROOT / "docs" / "words.md").read_text(encoding="utf-8")
    for word in (
        "quickstart",
        "FAQ",
        "Taxi",
        "FrozenLake",
        "p-value",
        "wandb",
        "pandas",
        "PPO",
        "Ollama",
        "GIF",
        "seed",
    ):
        assert re.search(rf"\b{word}\b.*\]\(", words), word


def test_the_search_finds_the_words_that_people_use(tmp_path):
    """Each word of the page is an entry of the index, below the heading that answers."""
    shutil.copytree(ROOT / "docs", tmp_path / "docs", ignore=shutil.ignore_patterns("*.png", "*.gif"))
    for name in ("README", "CONTRIBUTING"):
        shutil.copy(ROOT / f"{name}.md", tmp_path)
    SITE["add_words"](tmp_path)
    for word, page, heading in (
        ("Taxi", "docs/teach-your-own-environment", "# Your own environment: how does it get a teacher?"),
        ("oracle", "docs/questions", "## What is an oracle?"),
        ("LLM", "docs/language-models", "# Language models: how does a model learn, or teach?"),
        ("install", "README", "## Run it"),
        ("FAQ", "docs/questions", "# Questions: what do people ask?"),
        ("quickstart", "docs/quickstart/README", "# Start here: what can I see in ten minutes?"),
        ("reward", "docs/teach-your-own-environment", "## Rewards in words"),
    ):
        before, entry, _ = (tmp_path / f"{page}.md").read_text("utf-8").partition(f"\n   ! single: {word}\n")
        assert entry, word
        assert re.findall(r"^#+ .+$", before, re.MULTILINE)[-1] == heading


def test_the_readme_counts_the_personalities():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (least,) = re.findall(r"more than (\d+) personalities of teachers", readme)
    assert len(PERSONALITIES.names) > int(least)


def test_the_study_files_of_the_page_on_studies_are_studies(tmp_path):
    from llf_teacher.studies.definition.study import load_study

    page = (ROOT / "docs" / "studies.md").read_text(encoding="utf-8")
    numbers = []
    studies = [code for language, code in BLOCK.findall(page) if language == "toml" and "ids = " in code]
    for text in studies:
        (tmp_path / "study.toml").write_text(text)
        numbers.append(len(list(load_study(tmp_path / "study.toml").episodes())))
    assert numbers == [210, 240]


def test_the_tables_of_families_and_personalities_are_those_of_the_code():
    """If not, run `llf dev tables`."""
    texts = {path.name: path.read_text(encoding="utf-8") for path in documents(ROOT)}
    assert {"README.md", "personalities.md"} <= texts.keys()
    assert {name: update(text) for name, text in texts.items()} == texts
    for name in PERSONALITIES.names:
        assert f"| `{name}` |" in matrix()
    for family in all_families():
        assert f"| {family.name} |" in families()


@pytest.mark.parametrize("text", ["no place", "<!-- llf dev tables: shelves -->\n<!-- end -->"])
def test_a_document_needs_markers_for_tables(text):
    with pytest.raises(
        ValueError,
        match=r"the document must have markers for tables, .* got: (none|shelves); allowed names: families, ",
    ):
        update(text)


def test_links_lead_somewhere():
    assert len(LINKED) > len(DOCUMENTS)
    for path in LINKED:
        for target in re.findall(r"\]\(([^)]+)\)", path.read_text(encoding="utf-8")):
            if not target.startswith("https://"):
                file, _, heading = target.partition("#")
                if path.name == "CHANGELOG.md":  # it names pages of its time, and the site leads to those of today
                    file = SITE["today"](file)
                there = path.parent / file if file else path
                assert there.is_file(), f"{path.name}: {target}"
                assert not heading or heading in headings(there), f"{path.name}: {target}"


def headings(path):
    """The names under which a document's headings can be linked."""
    found = re.findall(r"^#+ (.+)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", text).lower().replace(" ", "-") for text in found}


def test_the_version_is_in_the_changelog():
    """What is not released yet has its changes in files of their own."""
    if ".dev" in llf_teacher.__version__:
        assert [path for path in (ROOT / "changes").glob("*.*.md") if path.read_text(encoding="utf-8").strip()]
    else:
        assert f"## {llf_teacher.__version__}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_the_page_on_films_tells_the_numbers_of_the_catalogue():
    text = (ROOT / "docs" / "internals" / "catalogue.md").read_text(encoding="utf-8")
    entries = list(shipped())
    series = sum(entry.series for entry in entries)
    assert f"{len(entries) - series:,} films and\n{series:,} series" in text
    assert f"empty for {sum(entry.certificate is None for entry in entries)} films" in text
    for source, count in Counter(entry.source for entry in entries).items():
        assert f"| {source} | {count:,} |" in text


def test_the_suites_page_lists_the_wordings_of_the_range_of_arms():
    page = (ROOT / "docs" / "suite.md").read_text("utf-8")
    phrases = tomllib.loads(resources.files("teachers.phrases").joinpath("bandits.toml").read_text("utf-8"))
    for wording in phrases["plain"]["Answer"]:
        assert f"- {wording.format(last=9)}\n" in page
