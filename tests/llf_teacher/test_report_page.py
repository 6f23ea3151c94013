"""What a page of a report promises: findings first, nothing from outside, data and transcripts at hand, little room."""

import base64
import csv
import hashlib
import io
import re
from dataclasses import replace
from html import unescape
from urllib.parse import unquote

import pytest
from commands import llf
from studying import stored

from llf_teacher.studies.definition.study import Study, load_study
from llf_teacher.studies.report import page, render, to_toml
from llf_teacher.studies.report.data import read
from llf_teacher.studies.report.parts import findings
from llf_teacher.studies.store import Store
from teachers.personality import personality

STUDY = Study(
    ids=("llf-bandits-BanditTenArmedRandomFixed-v0", "llf-gridworld-v0"),
    teachers=("oracle", "silent", "mistake(eps=1.0)"),
    students=("obedient", "random"),
    seeds=7,
    max_turns=8,
)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return stored(tmp_path_factory.mktemp("page") / "s.db", STUDY)


@pytest.fixture(scope="module")
def html(path):
    return render(Store(path), STUDY)


def told(html):
    text = html[html.index('id="findings"') : html.index("<nav")]
    return " ".join(re.sub(r"<[^>]*>|&nbsp;", " ", text).split())


def test_findings_come_first_and_are_computed(html, path):
    data = read(Store(path), STUDY)
    assert html.index('id="findings"') < html.index('id="bandits-b-a"')
    assert [each.compared[:2] for each in data.primary] == [
        (teacher, "obedient") for teacher in ("oracle", "mistake(eps=1.0)")
    ]
    largest = max(data.significant, key=lambda each: abs(each.mean))
    better = sum(each.mean > 0 for each in data.significant)
    assert better > 0
    text = told(html)
    assert "Primary test: 2 comparisons with silent over 2 families and 7 seeds, by sign flips" in text
    worse = len(data.significant) - better
    assert f"(p ≤ 0.05) in {better} and significantly worse in {worse};" in text.replace("&le;", "≤")
    assert f"Largest difference that is significant: {largest.compared.teacher} for obedient is better than" in text
    assert f"(score {largest.mean:.2f} " in text
    assert "Too few" not in text
    assert "Most helpful" not in text


def test_with_too_few_seeds_findings_say_so_at_once(path):
    few = Study(**{**STUDY.as_dict(), "seeds": 4})
    html = render(Store(path), few)
    text = told(html)
    assert re.search(r"Whether obedient loses more with oracle or with silent, over 2 families, is not decided", html)
    assert "Not decided: 4 seeds are too few for any difference to be significant." in text
    assert "Too few seeds. With 4 seeds and 2 primary comparisons the smallest possible p is 0.25" in text
    assert "It takes at least 7 seeds." in text
    assert "No primary comparison is significant. That is no proof that teachers are alike." in text
    assert "Needed: of the 2 comparisons that are not decided the nearest, oracle for obedient" in text


def test_the_largest_surprise_contradicts_what_is_said(path):
    data = read(Store(path), replace(STUDY, baseline="oracle"))
    (liar,) = [each for each in data.significant if each.compared.teacher == "mistake(eps=1.0)"]
    assert findings._surprise(data, [liar]) is None
    better = liar._replace(score=liar.score._replace(estimate=liar.score.estimate._replace(mean=0.4)))
    surprise = findings._surprise(data, [liar, better])
    assert surprise.found is better
    assert surprise.teacher.truthful < surprise.baseline.truthful
    assert surprise.baseline.distorted == 0


@personality()
def picky(claims, view):
    """Looks for a kind that there is not."""
    return [claim for claim in claims if claim.kind == "prais"]


def test_a_teacher_that_said_nothing_is_named(tmp_path):
    picky_ = f"{__name__}:picky"
    study = Study(ids=STUDY.ids[:1], teachers=["silent", picky_, "oracle"], students=["obedient"], seeds=1, max_turns=2)
    text = told(render(Store(stored(tmp_path / "s.db", study)), study))
    assert f"{picky_} said nothing in any episode: its results are those of silence." in text
    assert text.count("said nothing") == 1


def test_findings_without_a_baseline_say_what_they_need(path):
    lonely = replace(STUDY, teachers=("oracle", "mistake(eps=1.0)"))
    text = told(render(Store(path), lonely))
    assert "Findings need a baseline" in text
    assert "Add it to teachers , or name one of them in the study's file" in text.replace("&#39;", "'")
    deaf = replace(STUDY, students=("random",))
    assert "findings need a student that reads what teachers say" in told(render(Store(path), deaf))


def test_what_is_not_final_says_so_and_tests_nothing(path):
    more = Study(**{**STUDY.as_dict(), "seeds": 8})
    html = render(Store(path), more)
    assert '<span class="tag">not final</span>' in html
    assert "nothing is tested before all are there" in html
    assert "p &lt; 0.001" not in html
    assert not re.search(r", p = \d", html)


def test_policy_allows_the_pages_own_style_and_script_only(html):
    policy = re.search(r'<meta http-equiv="Content-Security-Policy" content="([^"]*)">', html)[1]
    for tag in ("style", "script"):
        (text,) = re.findall(rf"<{tag}>(.*?)</{tag}>", html, re.DOTALL)
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"{tag}-src 'sha256-{digest}'" in policy
    assert policy.startswith("default-src 'none'")
    assert "unsafe" not in policy
    assert not re.search(r"\s(style|on\w+)=", re.sub(r"<script>.*?</script>", "", html, flags=re.DOTALL))


def test_each_figure_has_its_data_and_leads_to_its_transcripts(html, path):
    figures = re.findall(r'<figure id="([^"]*)">(.*?)</figure>', html, re.DOTALL)
    assert len(figures) == 7
    for name, figure in figures:
        address = re.search(rf'download="{name}.csv" href="data:text/csv;charset=utf-8,([^"]*)"', figure)[1]
        rows = list(csv.DictReader(io.StringIO(unquote(address.replace("&#39;", "'").replace("&amp;", "&")))))
        assert {row["teacher"] for row in rows} <= set(STUDY.teachers)
        anchor = re.search(r'<a href="#([^"]*)">', figure)[1]
        assert f'id="{anchor}"' in html
    _, dots = read(Store(path), STUDY).sections
    (row,) = [row for row in rows if (row["teacher"], row["student"], row["turn"]) == ("silent", "obedient", "8")]
    assert float(row["regret"]) == pytest.approx(dots.regret["silent", "obedient"].mean, rel=1e-4)


def test_a_study_chooses_its_transcripts(path, tmp_path):
    wanted = ({"teacher": "mis*", "id": "*grid*", "seeds": [3, 5, 99]}, {"teacher": "silent", "student": "random"})
    study = Study(**{**STUDY.as_dict(), "transcripts": wanted})
    (tmp_path / "study.toml").write_text(to_toml(study))
    assert load_study(tmp_path / "study.toml") == study
    html = render(Store(path), study)
    shown = re.findall(
        r"<summary><code>([^<]*)</code> teaches <code>(\w+)</code>\s*<span[^>]*>in (\S+), seed (\d)", html
    )
    bandits, grid = STUDY.ids
    mistaken = [("mistake(eps=1.0)", student, grid, seed) for student in ("obedient", "random") for seed in "35"]
    assert sorted(shown) == sorted([*mistaken, ("silent", "random", bandits, "0"), ("silent", "random", grid, "0")])


def test_wishes_that_are_none_are_refused():
    for wish, problem in (
        ("oracle", "transcripts must be a list of tables"),
        ([{"teachers": "x"}], "transcripts: unknown key 'teachers'; did you mean teacher"),
        ([{"seeds": "0"}], "transcripts: seeds must be a list of seeds, got '0'"),
        ([{"id": 3}], "transcripts: id must be a pattern"),
        ([3], "transcripts must be tables with some of id, teacher, student, seeds, got 3"),
    ):
        with pytest.raises(ValueError, match=problem):
            Study(**{**STUDY.as_dict(), "transcripts": wish})


def test_a_page_has_little_room(path, html, monkeypatch):
    monkeypatch.setattr(page, "_FIGURES", 30_000)
    monkeypatch.setattr(page, "_SHOWN", 10)
    small = render(Store(path), STUDY)
    assert len(small) < len(html) - 50_000
    assert 0 < small.count("</svg>") < html.count("</svg>")
    assert "<code>llf study figures</code> draws it" in small
    assert re.search(r"<code>llf study transcript s\.db [0-9a-f]{32}</code>", small)
    assert "<details>" not in small


def test_print_opens_only_what_is_open(html):
    style = re.search(r"<style>(.*?)</style>", html, re.DOTALL)[1]
    assert "details:not([open])" in style[style.index("@media print") :]
    assert "::details-content" not in style


def test_the_terminal_has_the_findings_of_the_page(tmp_path):
    (tmp_path / "study.toml").write_text(
        'ids = ["llf-gridworld-v0"]\nteachers = ["oracle", "silent"]\nstudents = ["text_only"]\nseeds = 8\n'
    )
    result = llf("study", "study.toml", "--workers", "1", cwd=tmp_path, COLUMNS="200")
    assert result.returncode == 0, result.stderr
    listed = [line.removeprefix("- ") for line in result.stderr.splitlines() if line.startswith("- ")]
    html = unescape(re.sub(r"<[^>]+>", "", (tmp_path / "study.html").read_text(encoding="utf-8")))
    assert listed
    assert all(" ".join(line.split()) in " ".join(html.split()) for line in listed)
    assert re.search(r"oracle +. +silent +. +text_only +. +-\d+\.\d\d .* [01]\.\d\d ", result.stderr)
    assert listed[0].startswith("text_only loses less with oracle than with silent: ")
    assert result.stderr.rstrip().endswith("study.html")
