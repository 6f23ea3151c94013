"""Reports of a small study, played here."""

import os
import re
import subprocess
import sys
import tomllib
from html.parser import HTMLParser

import pytest

from llf_teacher.episodes.record import Record
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.execution.runner import manifest
from llf_teacher.studies.report import check_writable, render, to_toml, write_report
from llf_teacher.studies.store import Store

STUDY = Study(
    ids=("llf-gridworld-v0",),
    teachers=("oracle", "mistake(eps=0.5)", "silent"),
    students=("random", "text_only", "obedient"),
    seeds=(0, 1, 2),
)
EVIL = "<script>alert('x')</script> $x_1$ & \"y\""
VOID = {"meta", "br", "path", "use", "rect", "circle", "line"}


@pytest.fixture(scope="module")
def records():
    return [play(spec) for spec in STUDY.episodes()]


@pytest.fixture
def store(tmp_path):
    with Store(tmp_path / "s.db") as store:
        yield store


@pytest.fixture(scope="module")
def html(records, tmp_path_factory):
    with Store(tmp_path_factory.mktemp("report") / "s.db") as store:
        fill(store, records)
        store.write_manifest(manifest(STUDY))
        return render(store, STUDY)


def fill(store, records):
    for record in records:
        store.add(record)


class Checker(HTMLParser):
    """Collects ids and what refers to them, and checks that elements nest."""

    def __init__(self):
        super().__init__()
        self.open, self.ids, self.used, self.tags = [], [], set(), []

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        for name, value in attrs:
            if name == "id":
                self.ids.append(value)
            elif name in ("href", "xlink:href", "aria-labelledby") and not value.startswith("data:text/csv"):
                self.used.add(value.removeprefix("#"))
            self.used |= set(re.findall(r"url\(#([^)]*)\)", value or ""))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag


def parsed(html):
    checker = Checker()
    checker.feed(html)
    assert checker.open == []
    return checker


def text_of(html):
    """The page without tags, in single spaces."""
    return " ".join(re.sub(r"<[^>]*>", " ", html).split())


def test_everyone_appears(html):
    text = text_of(html)
    for spec in (*STUDY.teachers, *STUDY.students):
        assert spec in text
    for words in ("reads nothing", "reads words", "reads claims", "moves wasted", "3 simulated teachers", "3 seeds"):
        assert words in text
    assert "27 episodes in all" in text
    assert "27 of 27 episodes played" in text
    assert "incomplete" not in text
    assert "numpy" in text


def test_numbers_are_those_of_the_episodes(html, records):
    def cells(caption):
        table = next(table for table in re.findall(r"<table.*?</table>", html, re.DOTALL) if caption in table)
        rows = re.findall(r"<tr>(.*?)</tr>", table, re.DOTALL)
        return {text_of(row).split()[0]: text_of(row) for row in rows}

    mine = [record for record in records if (record.spec.teacher, record.spec.student) == ("silent", "text_only")]
    assert len({record.episode.regret for record in mine}) > 1
    assert f"{sum(record.episode.regret for record in mine) / 3:.1f}" in cells("Success and regret")["silent"]
    assert (
        "100 % no interval , 3 seeds: 100 (3 times) 0.0 no interval , 3 seeds: 0.0 (3 times)"
        in cells("Success and regret")["oracle"]
    )
    assert cells("claims per turn")["oracle"].startswith("oracle gridworld 1.00 ")
    assert " 4.00 100.0 0.0 0.0 0.0 0.0 0 100 % " in cells("claims per turn")["oracle"]  # all true, all followed
    assert cells("claims per turn")["silent"].startswith(
        "silent gridworld 0.00 0.00 0.00 0.00 0.00 0.00" + 5 * " \N{EN DASH}" + " 0 \N{EN DASH} 0.0 0 "
    )
    changes = cells("What a teacher changes")
    assert "silent" not in changes
    assert "\N{MINUS SIGN}" in changes["oracle"]
    assert re.search(r"no interval , 3 seeds: .*, p = \d\.\d{3}", changes["oracle"])


def test_transcripts_mark_what_holds(html):
    assert "✓ true" in html
    assert "✗ false" in html
    assert "Go(action=" in html
    assert len(re.findall(r"<details>", html)) == 3  # one a teacher


def test_page_is_sound_and_needs_nothing_else(html):
    page = parsed(html)
    assert len(page.ids) == len(set(page.ids))
    assert page.used <= set(page.ids)
    assert set(re.findall(r"https?://[^\"'\s<]*", html)) == {
        "http://www.w3.org/1999/xlink",
        "http://www.w3.org/2000/svg",
    }
    assert not {tag for tag, _ in page.tags} & {"link", "img", "iframe", "image"}
    assert not re.search(r"@import|url\((?!#)", html)
    assert all("scope" in attributes for tag, attributes in page.tags if tag == "th")
    images = [attributes for _, attributes in page.tags if attributes.get("role") == "img"]
    assert len(images) == 10  # five in two widths
    assert all(attributes["aria-label"] for attributes in images)


def test_same_episodes_give_the_same_bytes(html, records, tmp_path):
    path = tmp_path / "s.db"
    with Store(path) as store:
        fill(store, reversed(records))
        store.write_manifest(manifest(STUDY))
    (tmp_path / "study.toml").write_text(to_toml(STUDY))
    code = (
        "import sys; from pathlib import Path; from llf_teacher.studies.report import write_report; "
        "from llf_teacher.studies.store import Store; from llf_teacher.studies.definition.study import load_study; "
        "write_report(Store(Path(sys.argv[1])), load_study(Path(sys.argv[2])), Path(sys.argv[3]))"
    )
    report = tmp_path / "r.html"
    (tmp_path / "matplotlibrc").write_text("font.size: 30\nsvg.fonttype: path\n")
    subprocess.run(
        [sys.executable, "-c", code, path, tmp_path / "study.toml", report],
        check=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONHASHSEED": "12"},
    )
    assert report.read_text(encoding="utf-8") == html


def test_text_of_others_is_escaped(store, records):
    fill(store, [edited(record) for record in records])
    html = render(store, STUDY)
    page = parsed(html)
    assert "No action could be read from:" in html
    assert [tag for tag, _ in page.tags].count("script") == 1
    assert html.count("&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt; $x_1$ &amp;") >= 4


def edited(record):
    first, second, *rest = record.turns
    second = second._replace(action=None, parse_failure=EVIL, feedback=EVIL, observation=EVIL, atoms=[])
    return Record(record.spec, record.episode, (first._replace(instruction=EVIL), second, *rest))


def test_silence_is_said(store, records):
    fill(store, records)
    quiet = Study(ids=STUDY.ids, teachers=("silent",), students=("text_only",), seeds=STUDY.seeds)
    assert "(silence)" in render(store, quiet)


def test_incomplete_study_says_so(store, records):
    fill(store, records[:5])
    text = text_of(render(store, STUDY))
    assert "This study is incomplete. 5 of its 27 episodes have been played." in text
    assert "n = 2" in text
    assert "\N{EN DASH}" in text


def test_one_seed_has_no_interval(store, records):
    one = Study(ids=STUDY.ids, teachers=STUDY.teachers, students=STUDY.students, seeds=1)
    fill(store, records)
    text = text_of(render(store, one))
    assert "one seed" in text
    assert "nan" not in text


def test_other_episodes_do_not_count(store, records):
    fill(store, records)
    text = text_of(render(store, Study(ids=STUDY.ids, teachers=("oracle",), students=("random",), seeds=(0, 2))))
    assert "2 episodes in all" in text
    assert "mistake(" not in text
    assert "What a teacher changes" not in text


def test_environments_of_a_family_are_averaged_and_types_kept_apart(store):
    study = Study(
        ids=("llf-bandits-BanditTwoArmedHighLowFixed-v0", "llf-bandits-BanditTwoArmedDeterministicFixed-v0"),
        teachers=("oracle", "silent"),
        students=("obedient",),
        feedback_types=("a", "r+fp"),
        seeds=2,
        max_turns=3,
    )
    fill(store, [play(spec) for spec in study.episodes()])
    html = render(store, study)
    page = parsed(html)
    for anchor in ("bandits-b-a", "bandits-b-r-fp"):
        assert anchor in page.ids
    assert len(page.ids) == len(set(page.ids))
    assert html.count("2 seeds: 100 (2 times)</span>") >= 2  # two seeds, not four episodes


def test_environments_with_other_grids_are_kept_apart(store):
    study = Study(
        ids=("llf-bandits-BanditTwoArmedHighLowFixed-v0", "llf-bandits-BanditTwoArmedDeterministicFixed-v0"),
        teachers=("oracle", "silent"),
        students=("obedient", "random"),
        seeds=2,
        max_turns=2,
        fewer={"*HighLow*": {"students": ("obedient",), "seeds": 1}},
    )
    fill(store, [play(spec) for spec in study.episodes()])
    html = render(store, study)
    assert "incomplete" not in html
    assert {"bandits-b-a", "bandits-b-a-1"} <= set(parsed(html).ids)
    first, second = (html.split(f'id="bandits-b-a{part}"')[1].split("</section>")[0] for part in ("", "-1"))
    assert "HighLow" in first
    assert "1 seed" in first
    assert "<code>random</code>" not in first
    assert "Deterministic" in second
    assert "<code>random</code>" in second


def test_of_many_teachers_a_few_are_drawn_from_the_best_to_the_worst(store):
    study = Study(
        ids=("llf-bandits-BanditTenArmedRandomFixed-v0",),
        teachers=[*(f"mistake(eps={eps / 10})" for eps in range(1, 11)), "silent", "oracle"],
        students=("obedient",),
        seeds=12,
        max_turns=8,
    )
    fill(store, [play(spec) for spec in study.episodes()])
    html = render(store, study)
    said = "6 of 12 teachers: those of the question and your own, <code>silent</code>, and others from the best"
    caption = re.search(said, html)
    assert caption
    curves = html[: caption.start()].rpartition("<svg")[2]
    drawn = [teacher for teacher in study.teachers if f">{teacher}<" in curves]
    assert {"oracle", "mistake(eps=1.0)", "silent"} <= set(drawn)
    assert len(drawn) == 6


def test_nothing_played_is_an_error(store, tmp_path):
    with pytest.raises(ValueError, match=r"s\.db holds no episode of this study; run it first"):
        write_report(store, STUDY, tmp_path / "r.html")
    assert not list(tmp_path.glob("*r.html*"))


def test_file_is_replaced_as_a_whole(store, records, tmp_path, monkeypatch):
    fill(store, records)
    study = Study(ids=STUDY.ids, teachers=("oracle",), students=("random",), seeds=1)
    path = tmp_path / "r.html"
    path.write_text("old")

    def fail(*args):
        raise OSError("disk full")

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", fail)
        with pytest.raises(OSError, match="disk full"):
            write_report(store, study, path)
    assert path.read_text() == "old"
    write_report(store, study, path)
    assert path.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert sorted(tmp_path.glob("*r.html*")) == [path]


def test_path_is_checked_beforehand(tmp_path):
    check_writable(tmp_path / "r.html")
    with pytest.raises(ValueError, match="it is a folder"):
        check_writable(tmp_path)
    with pytest.raises(ValueError, match="there is no folder"):
        check_writable(tmp_path / "no" / "r.html")


@pytest.mark.parametrize(
    "extra",
    [
        {},
        {"seeds": (3, 5), "max_turns": 4, "feedback_types": ("r+hp", "n")},
        {"fewer": {"llf-*": {"teachers": ("oracle",), "seeds": 2}}},
    ],
)
def test_definition_round_trips(extra):
    study = Study(**{**STUDY.as_dict(), **extra})
    assert Study(**tomllib.loads(to_toml(study))) == study
