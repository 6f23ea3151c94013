"""Two stores compared, from the command line, too."""

import numpy as np
import pytest
from studying import filled
from typer.testing import CliRunner

from llf_teacher.cli import app
from llf_teacher.studies.analysis.diff import compare
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.store import Store

ID = "llf-bandits-BanditTenArmedRandomFixed-v0"
STUDY = Study(ids=(ID,), teachers=("oracle", "silent"), students=("obedient", "random"), seeds=6, max_turns=4)


@pytest.fixture
def stores(tmp_path):
    """In the second one `obedient` with `silent` has one more of regret, of other rules with `oracle`; `random` with
    `silent` is in the first only.
    """
    records = [play(spec) for spec in STUDY.episodes()]
    changed = []
    for record in records:
        spec, episode = record.spec, record.episode
        match spec.teacher, spec.student:
            case "silent", "obedient":
                if spec.seed == 0:
                    continue
                episode = episode._replace(regret=episode.regret + 1 + 0.1 * spec.seed)
            case "oracle", "obedient":
                spec = spec._replace(rules="0.0")
            case "silent", "random":
                continue
        changed.append(record._replace(spec=spec, episode=episode))
    return filled(tmp_path / "a.db", records), filled(tmp_path / "b.db", changed)


def test_cells_are_compared_by_seed_where_rules_allow_it(stores):
    with Store(stores[0]) as one, Store(stores[1]) as other:
        found = compare(one, other)
    changes = {change.setting[1:3]: change for change in found.changes}
    assert set(changes) == {("oracle", "obedient"), ("oracle", "random"), ("silent", "obedient")}
    assert changes["oracle", "random"].equal
    silent = changes["silent", "obedient"]
    assert not silent.equal
    assert (silent.paired, silent.regret.n) == (True, 5)
    assert silent.regret.mean == pytest.approx(1.3)
    assert 1.1 <= silent.regret.low < 1.3 < silent.regret.high <= 1.5
    assert silent.success == 0
    apart = changes["oracle", "obedient"]
    assert not apart.paired
    assert not apart.equal
    assert apart.regret.mean == pytest.approx(0)
    assert apart.regret.low < 0 < apart.regret.high or np.ptp(apart.first.regret) == 0
    assert [setting[1:3] for setting in found.only[0]] == [("silent", "random")]
    assert found.only[1] == []


def test_the_command_prints_what_differs(stores, tmp_path):
    page = tmp_path / "d.html"
    result = CliRunner().invoke(app, ["study", "diff", *map(str, stores), "--html", str(page)], env={"COLUMNS": "200"})
    assert result.exit_code == 0, result.output
    assert (
        "3 combinations of environment, teacher and student in both: 1 with equal results, 2 without." in result.output
    )
    assert "+1.30" in result.output
    assert f"only in {stores[0]}: {ID}, silent, random" in result.output.replace("\n", "")
    assert "+1.30" in page.read_text(encoding="utf-8")


def test_a_narrow_terminal_breaks_no_id(stores):
    result = CliRunner().invoke(app, ["study", "diff", *map(str, stores)], env={"COLUMNS": "40"})
    lines = result.output.splitlines()
    place = lines.index(f"{ID}, silent, obedient")
    assert lines[place + 1].split()[::2][:2] == ["5", "+1.30"]
    assert lines[2] == "id, teacher, student"
    assert lines[3].split() == ["n", "regret", "difference", "95", "%", "success"]


def test_equal_stores_differ_in_nothing(stores):
    result = CliRunner().invoke(app, ["study", "diff", f"{stores[0]}", f"{stores[0]}"])
    assert (
        result.output
        == "4 combinations of environment, teacher and student in both: 4 with equal results, 0 without.\n"
    )


def test_teachers_have_the_names_of_their_reports(stores):
    named = {"names": {"silent": "the quiet one"}}
    for path, changes in zip(stores, (named, {"names": {}}), strict=True):
        with Store(path) as store:
            store.write_manifest({"study": STUDY.as_dict() | changes})
    said = CliRunner().invoke(app, ["study", "diff", *map(str, stores)], env={"COLUMNS": "200"}).output
    assert f"{ID}, silent, obedient" in said, "the second store calls it so"
    said = CliRunner().invoke(app, ["study", "diff", *map(str, stores[::-1])], env={"COLUMNS": "200"}).output
    assert f"{ID}, the quiet one, obedient" in said
