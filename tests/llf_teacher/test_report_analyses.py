"""What a report says of attempts, kinds, the matrix, tests without a teacher and all families."""

import re

import numpy as np
import pytest

from llf_teacher.studies.attempts import attempts
from llf_teacher.studies.episode import play
from llf_teacher.studies.outcomes import outcomes
from llf_teacher.studies.overall import overall
from llf_teacher.studies.report import render
from llf_teacher.studies.report.data import read
from llf_teacher.studies.store import Store
from llf_teacher.studies.study import Study

ROOMS = "llf-gridworld-v0"
STUDY = Study(
    ids=[ROOMS, "llf-bandits-BanditTwoArmedHighLowFixed-v0"],
    teachers=["oracle", "hinter", "retry_only"],
    students=["obedient", "text_only", "random"],
    baseline="retry_only",
    seeds=3,
    max_turns=4,
    looks={"at": [1, 3]},
    transfer={"lessons": [1], "teachers": ["oracle", "retry_only"], "students": ["obedient(forget=False)"]},
)
KINDS = Study(ids=[ROOMS], teachers=["oracle"], students=["obedient"], feedback_types="subsets", seeds=2, max_turns=3)


def stored(path, study):
    with Store(path) as store:
        for spec in study.episodes():
            store.add(play(spec))
    return Store(path)


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return stored(tmp_path_factory.mktemp("study") / "s.db", STUDY)


@pytest.fixture(scope="module")
def page(store):
    return render(store, STUDY)


def part(html, name):
    """The text of a section, tags left out."""
    found = re.search(f'<section id="{name}".*?</section>', html, re.DOTALL)
    return " ".join(re.sub("<[^>]*>", " ", found[0]).split()) if found else None


def test_columns_give_what_rows_give(store):
    data = read(store, STUDY)
    told, expected = data.outcomes, outcomes(store.rows(), STUDY.grid)
    assert data.present == data.expected == len(list(STUDY.episodes()))
    assert {group: list(cells) for group, cells in told.items()} == {g: list(cells) for g, cells in expected.items()}
    for group, cells in expected.items():
        for pair, cell in cells.items():
            for one, other in zip(told[group][pair], cell, strict=True):
                np.testing.assert_array_equal(one, other)


def test_tests_have_no_section_of_a_family(page):
    assert len(re.findall('<section id="(?:gridworld|bandits)-', page)) == 2


def test_attempts_are_told(store, page):
    told = part(page, "attempts")
    group, cells = next(iter(read(store, STUDY).taught.items()))
    found = attempts(cells, group.max_turns)["oracle", "obedient"]
    assert "acc@1 acc@2 acc@4" in told
    assert f"oracle obedient {100 * found.solved.mean[0]:.0f} [" in told


def test_the_estimates_over_all_families_are_told(store, page):
    (best, *_) = overall(read(store, STUDY).taught, "retry_only")
    assert best.tasks == 4
    assert f"oracle 4 {best.middle.mean:.2f} [" in part(page, "overall")


def test_the_matrix_is_told(page):
    told = part(page, "matrix")
    assert "lies between teachers" in told
    assert "obedient : oracle , hinter" in told or "obedient : hinter , oracle" in told


def test_tests_are_told(page):
    told = part(page, "transfer")
    assert f"{ROOMS} 1 same, a oracle obedient(forget=False)" in told
    assert part(page, "ablation") is None


def test_an_ablation_is_told_and_has_one_section(tmp_path):
    html = render(stored(tmp_path / "s.db", KINDS), KINDS)
    told = part(html, "ablation")
    assert "gain r hp hn fp fn gridworld oracle obedient" in told
    assert len(re.findall('<section id="gridworld-', html)) == 1
    assert len(re.findall("Each subset", told)) == 1
    assert part(html, "transfer") is part(html, "matrix") is None
