"""The tables of `llf dev calibration`: studies are dealt without an effect, and tested as a report tests them."""

import numpy as np
import pytest
from typer.testing import CliRunner

from llf_teacher.cli import app
from llf_teacher.studies.analysis import contrasts
from llf_teacher.studies.analysis.primary import pairs, primary
from llf_teacher.studies.analysis.statistics import holm
from llf_teacher.studies.definition.study import Study
from llf_teacher.tools import calibration as measured
from llf_teacher.tools.calibration import BASELINE, EFFECT, SEEDS, STUDENTS, TEACHERS, Extent

POOL = {
    name: np.random.default_rng(number).gamma(2, size=(30, 10)) * 10**number
    for number, name in enumerate(("one", "two", "three"))
}
ALONE = dict.fromkeys(POOL, 0.0)


def test_arms_are_dealt_from_the_same_worlds():
    outcomes = measured.deal(POOL, ["one", "three"], np.random.default_rng(5), ALONE | {"three": 1000.0})
    worlds = []
    for group, cells in outcomes.items():
        assert list(cells) == [(t, s) for t in (*TEACHERS, BASELINE) for s in STUDENTS]
        table = np.array(
            [cell.regret - 1000 * (group.family == "three" and t == BASELINE) for (t, _), cell in cells.items()]
        )
        rows = [tuple(sorted(row.round(6))) for row in POOL[group.family]]
        worlds.append([rows.index(tuple(sorted(column.round(6)))) for column in table.T])
        assert len(set(worlds[-1])) == SEEDS
    assert worlds[0] == worlds[1]


@pytest.mark.parametrize("effect", [0.0, EFFECT])
def test_studies_are_tested_as_reports_do(effect):
    extent = Extent(3, 10, 4)
    found = measured.tried(POOL, extent, 2, effect, lambda: None)
    rng = extent.rng(2 if effect else 1, 2)
    for number in range(extent.studies):
        chosen = [str(name) for name in rng.choice(list(POOL), 2, replace=False)]
        outcomes = measured.deal(POOL, chosen, rng, measured._shift(POOL, chosen, effect))
        for test in measured.tests().values():
            told = primary(outcomes, BASELINE, test)
            assert [(e.compared.teacher, e.compared.student) for e in told] == [
                (t, s) for t in TEACHERS for s in STUDENTS
            ]
            assert [each.score.p for each in told] == pytest.approx(measured.adjusted(found.primary[number], test))
            assert [each.mean for each in told] == pytest.approx(found.score[number])
            every = [both for families in pairs(outcomes, BASELINE).values() for both in families.values()]
            differences = contrasts.tested(
                test, lambda among, every=every: [(a.regret - b.regret)[: len(among)] for a, b in every]
            )
            p = holm([each.p for each in differences])
            assert p == pytest.approx(measured.adjusted(found.secondary[number], test))


def test_the_positive_control_has_its_effect():
    found = measured.tried(POOL, Extent(200, 10, 0), 2, EFFECT, lambda: None)
    spread = found.score.std(axis=0, ddof=1) * SEEDS**0.5  # of the scores of seeds, from that of their means
    assert found.score.mean(axis=0) / spread == pytest.approx(np.full(8, EFFECT), rel=0.25)


def test_tables_count_what_is_found():
    extent = Extent(20, 10, 0)
    rows = [line.split("|")[1:-1] for line in measured.errors(POOL, extent, lambda: None).splitlines()[2:]]
    assert [(row[0].strip(), int(row[1])) for row in rows] == [
        (name, n) for name in ("one test", "obrien fleming", "pocock") for n in measured.FAMILIES
    ]
    assert all(float(row[2]) <= 20 and float(row[3]) > float(row[2]) for row in rows)
    rows = [line.split("|")[1:-1] for line in measured.powers(POOL, extent, lambda: None).splitlines()[2:]]
    assert all(float(row[2]) > 60 for row in rows)


def test_coverage_of_the_whole_table():
    rows = [line.split("|")[1:-1] for line in measured.coverage(Extent(1, 2000, 0), lambda: None).splitlines()[2:]]
    told = {(row[0].strip(), int(row[1])): [cell.strip() for cell in row[2:]] for row in rows}
    assert float(told["half zeros", 5][0]) == pytest.approx(0.79, abs=0.04)
    assert float(told["lognormal", 40][0]) == pytest.approx(0.88, abs=0.03)
    for (shape, n), (_, shown, covers, wrong) in told.items():
        assert float(wrong) <= 11, (shape, n)
        if shape in ("normal", "exponential", "half zeros", "80 % zeros", "lognormal") and float(shown) >= 1:
            assert float(covers) >= 0.9, (shape, n)
    assert float(told["normal", 10][1]) > 85
    rates = measured.binary_coverage(Extent(1, 500, 0), lambda: None).splitlines()[2:]
    assert all(float(cell) >= 0.93 for line in rates for cell in line.split("|")[2:-1])


def test_the_command_plays_prints_and_writes(tmp_path, monkeypatch):
    small = Study(
        ids=["llf-bandits-BanditTwoArmedHighLowFixed-v0"],
        teachers=["silent"],
        students=["text_only"],
        samples=10,
        seeds=20,
        max_turns=2,
    )
    monkeypatch.setattr(measured, "pool_study", lambda worlds: small)
    monkeypatch.chdir(tmp_path)
    page = tmp_path / "page.md"
    page.write_text(
        "a\n<!-- llf dev calibration: powers -->\nold\n<!-- end -->\nb\n<!-- llf dev calibration: x -->\n<!-- end -->\n"
    )
    sizes = ["--studies", "2", "--draws", "10", "--worlds", "20"]
    result = CliRunner().invoke(app, ["dev", "calibration", "page.md", "--only", "powers", *sizes])
    assert result.exit_code == 0, result.output
    text = page.read_text()
    assert text.startswith("a\n<!-- llf dev calibration: powers -->\n| design | families |")
    assert text.endswith("<!-- end -->\nb\n<!-- llf dev calibration: x -->\n<!-- end -->\n")
    printed = CliRunner().invoke(app, ["dev", "calibration", "--only", "powers", *sizes]).output
    assert "".join(line + "\n" for line in text.splitlines() if line.startswith("|")) in printed
    wrong = CliRunner().invoke(app, ["dev", "calibration", "--only", "power"])
    assert wrong.exit_code == 2
    every = CliRunner().invoke(app, ["dev", "calibration", *sizes]).output
    for name in ("errors", "powers", "coverage", "binary", "bootstrap"):
        assert f"{name}\n\n|" in every
