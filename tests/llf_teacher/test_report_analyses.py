"""What a report says of attempts, kinds, the matrix, tests without a teacher and all families."""

import csv
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy import integrate
from studying import stored

from llf_teacher.episodes.record import EpisodeRow, Record
from llf_teacher.studies.analysis import contrasts, transfer
from llf_teacher.studies.analysis.matrix import Matrix, matrices
from llf_teacher.studies.analysis.outcomes import outcomes
from llf_teacher.studies.analysis.overall import overall
from llf_teacher.studies.analysis.statistics import Split, holm, paired_difference
from llf_teacher.studies.analysis.time_to_success import attempts
from llf_teacher.studies.definition.design import InterimAnalyses
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.report import render
from llf_teacher.studies.report.data import read
from llf_teacher.studies.report.parts import PARTS
from llf_teacher.studies.report.parts.matrix import Verdicts, verdicts
from llf_teacher.studies.store import Store

ROOMS = "llf-gridworld-v0"
STUDY = Study(
    ids=[ROOMS, "llf-bandits-BanditTwoArmedHighLowFixed-v0"],
    teachers=["oracle", "hinter", "retry_only"],
    students=["obedient", "text_only", "random"],
    baseline="retry_only",
    seeds=3,
    max_turns=4,
    interim_analyses={"at": [1, 3]},
    transfer={"lessons": [1], "teachers": ["oracle", "retry_only"], "students": ["obedient(forget=False)"]},
)
KINDS = Study(ids=[ROOMS], teachers=["oracle"], students=["obedient"], feedback_types="subsets", seeds=2, max_turns=3)


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return Store(stored(tmp_path_factory.mktemp("study") / "s.db", STUDY))


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
    told = part(page, "time_to_success")
    group, cells = next(iter(read(store, STUDY).taught.items()))
    found = attempts(cells, group.max_turns)["oracle", "obedient"]
    assert "acc@1 acc@2 acc@4" in told
    assert f"oracle obedient {100 * found.solved.mean[0]:.0f} no interval" in told


def test_the_estimates_over_all_families_are_told(store, page):
    (best, *_) = overall(read(store, STUDY).taught, "retry_only")
    assert best.tasks == 4
    assert f"oracle 4 {best.middle.mean:.2f} no interval" in part(page, "overall")


def drawn(data, name):
    """The figures of a part, each as its rows by name; drawing must not fail."""
    (found,) = [part for part in PARTS if part.name == name]
    for plot in found.plots(data):
        assert "<text" in plot.svg()
        yield plot.name, list(csv.DictReader(plot.csv.splitlines()))


def test_each_analysis_is_drawn_and_has_its_data(store):
    data = read(store, STUDY)
    ((_, profiles),) = drawn(data, "overall")
    first = next(overall(data.taught, "retry_only"))
    shares = [float(row["above"]) for row in profiles if row["teacher"] == data.called(first.teacher)]
    np.testing.assert_allclose(shares, first.profile.band.mean, rtol=1e-4)
    ((name, gains),) = drawn(data, "matrix")
    assert name == "matrix-gains-b-a"
    for each in matrices(data.taught):
        for (teacher, student), gain in each.gains.items():
            wanted = each.group.family, data.called(teacher), data.called(student)
            (row,) = [row for row in gains if (row["family"], row["teacher"], row["student"]) == wanted]
            assert float(row["gain"]) == pytest.approx(gain.mean, rel=1e-4)
            assert gain.why == "3 seeds"
            assert row["gain_high"] == ""
    ((_, tests),) = drawn(data, "transfer")
    for told in transfer.tested(data.outcomes, "retry_only"):
        (row,) = [r for r in tests if r["tested_in"] == told.group.ids[0] and r["teacher"] == data.called(told.teacher)]
        assert row["gain"] == ("" if told.gain is None else f"{told.gain.mean:.5g}")
        assert float(row["regret"]) == pytest.approx(told.regret.mean, rel=1e-4)
    assert not list(drawn(data, "ablation"))


def test_whose_the_gain_is_is_counted():
    def of(teachers, students, low=None, high=None):
        split = Split(teachers, students, 0.0, 1 - teachers - students)
        ends = None if low is None else (low, high)
        return Matrix(None, (), (), {}, split, split, split, ends, {}, None)

    found = [of(0.1, 0.5, 0.2, 0.6), of(0.2, 0.3, -0.1, 0.3), of(0.5, 0.1, -0.6, -0.2), of(0.2, 0.2), of(0.3, 0.1)]
    assert verdicts([*found, found[0]._replace(split=None)]) == Verdicts(5, 2, 1, 2, 1)


def test_the_matrix_is_told(page):
    told = part(page, "matrix")
    assert "Here, in 2 tables, more of the variance lies between students in " in told
    assert "lies between teachers" in told
    assert "obedient : oracle , hinter" in told or "obedient : hinter , oracle" in told


def test_tests_are_told(page):
    told = part(page, "transfer")
    assert f"{ROOMS} 1 same, all kinds oracle obedient(forget=False)" in told
    assert part(page, "ablation") is None


def test_an_ablation_is_told_and_has_one_section(tmp_path):
    store = Store(stored(tmp_path / "s.db", KINDS))
    html = render(store, KINDS)
    ((_, rows),) = drawn(read(store, KINDS), "ablation")
    gains = {row["kind"]: float(row["gain"]) for row in rows}
    assert list(gains) == ["reward", "praise", "blame", "advice", "warning", "all kinds"]
    assert sum(gains.values()) == pytest.approx(2 * gains["all kinds"], rel=1e-3)
    told = part(html, "ablation")
    assert "gain reward praise blame advice warning gridworld oracle obedient" in told
    assert len(re.findall('<section id="gridworld-', html)) == 1
    assert len(re.findall("Each subset", told)) == 1
    assert part(html, "transfer") is part(html, "matrix") is None


def held(store, study, path, keep):
    """What a store of some of the episodes says."""
    with Store(path) as other:
        for spec in study.episodes():
            if keep(spec):
                row = store.episode(spec.key)
                record = Record(spec, EpisodeRow(*(row[name] for name in EpisodeRow._fields)), ())
                other.add(record)
    return read(Store(path), study)


def test_nothing_is_tested_before_a_look_is_whole(store, tmp_path):
    first = held(store, STUDY, tmp_path / "1.db", lambda spec: spec.seed == 0)
    assert not first.final
    design = InterimAnalyses((1, 3))
    assert first.test == contrasts.Test(frozenset({0}), 1, (), design)
    more = held(store, STUDY, tmp_path / "2.db", lambda spec: spec.seed == 0 or spec.teacher == "oracle")
    assert more.test == first.test
    assert {d.estimate.n for section in more.sections for d in section.differences.values()} == {1}
    lacking = held(store, STUDY, tmp_path / "3.db", lambda spec: spec.seed or spec.teacher != "hinter")
    assert lacking.test is None
    whole = read(store, STUDY)
    assert whole.test == contrasts.Test(frozenset({0, 1, 2}), 2, (frozenset({0}),), design)
    assert whole.test.level == 0.05


def test_a_study_without_looks_is_tested_when_it_is_whole(store, tmp_path):
    plain = replace(STUDY, interim_analyses={})
    assert read(store, plain).test == contrasts.Test(frozenset({0, 1, 2}))
    assert held(store, plain, tmp_path / "s.db", lambda spec: spec.seed == 0).test is None


def test_what_cannot_be_found_is_said(page):
    told = part(page, "gridworld-b-a")
    assert "Cumulative regret minus that with retry_only on the same seeds" in told
    assert "This is interim analysis 2 of 2, at the first 3 seeds" in told
    assert "With so few seeds no difference can be significant: the smallest possible p is 1." in told


def test_only_what_can_differ_is_compared(store):
    data = read(store, STUDY)
    every = {(t, s) for t in ("oracle", "hinter") for s in ("obedient", "text_only")}
    for section in data.sections:
        assert set(section.differences) == set(data.secondary[section.anchor]) == every
    assert {each.compared[:2] for each in data.primary} == every
    assert data.least_secondary == min(1, 8 * 2 / 2**3)


def test_one_error_rate_is_kept_over_all_families(store):
    """Holm's method over the tables of all families together, of p-values that are adjusted for the analyses."""
    data = read(store, replace(STUDY, interim_analyses={}))
    raw, adjusted = [], []
    for section in data.sections:
        for (teacher, student), difference in data.secondary[section.anchor].items():
            own, other = (section.cells[each, student].regrets for each in (teacher, "retry_only"))
            raw.append(paired_difference(own, other).p)
            adjusted.append(difference.p)
    assert adjusted == holm(raw)
    assert len(adjusted) == 8
    looked = [each.p for mine in read(store, STUDY).secondary.values() for each in mine.values()]
    assert all(one >= other for one, other in zip(looked, adjusted, strict=True))


def test_areas_are_those_of_the_curves(store, page):
    section = read(store, STUDY).sections[0]
    heights = []
    for spec in STUDY.episodes():
        if (spec.id, spec.teacher, spec.student, spec.lessons) == (section.ids[0], "oracle", "random", 0):
            regrets = np.zeros(spec.max_turns + 1)
            turns = store.regrets(spec.key)
            regrets[1 : 1 + len(turns)] = turns
            heights.append(integrate.trapezoid(regrets.cumsum()) / spec.max_turns)
    assert section.areas["oracle", "random"].mean == pytest.approx(np.mean(heights))
    assert "Areas under these curves" in part(page, section.anchor)
