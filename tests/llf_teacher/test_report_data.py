"""What a report gathers from a store's columns, against the episodes themselves."""

import contextlib
import sqlite3

import numpy as np
import pytest
from studying import filled

from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.report import columns, render
from llf_teacher.studies.report.data import read
from llf_teacher.studies.report.parts.accounting import accounts
from llf_teacher.studies.store import Store, StoreError

IDS = ("llf-bandits-BanditTwoArmedHighLowFixed-v0", "llf-bandits-BanditTwoArmedDeterministicFixed-v0")
STUDY = Study(ids=IDS, teachers=("silent", "oracle"), students=("obedient", "random"), seeds=(5, 2, 7), max_turns=4)


@pytest.fixture(scope="module")
def records():
    return [play(spec) for spec in STUDY.episodes()]


@pytest.fixture
def path(tmp_path, records):
    return filled(tmp_path / "s.db", reversed(records))


def of(records, **fields):
    return [r for r in records if all(getattr(r.spec, name) == value for name, value in fields.items())]


def test_cells_are_means_over_environments_by_seed(path, records):
    (section,) = read(Store(path), STUDY).sections
    assert list(section.cells) == [(t, s) for t in STUDY.teachers for s in STUDY.students]
    for (teacher, student), cell in section.cells.items():
        assert cell.seeds.tolist() == [2, 5, 7]
        mine = [
            [of(records, teacher=teacher, student=student, seed=seed, id=id)[0].episode for id in IDS]
            for seed in (2, 5, 7)
        ]
        assert cell.success.tolist() == [[episode.success for episode in row] for row in mine]
        assert np.allclose(cell.regrets, [np.mean([episode.regret for episode in row]) for row in mine])
        assert cell.band.mean[-1] == pytest.approx(cell.regrets.mean())


def test_only_seeds_that_all_environments_have_count(tmp_path, records):
    lacking = [r for r in records if (r.spec.id, r.spec.seed, r.spec.teacher) != (IDS[1], 5, "oracle")]
    data = read(Store(filled(tmp_path / "s.db", lacking)), STUDY)
    (section,) = data.sections
    assert section.cells["oracle", "random"].seeds.tolist() == [2, 7]
    assert section.cells["silent", "random"].seeds.tolist() == [2, 5, 7]
    assert (data.present, data.expected) == (len(records) - 2, len(records))
    one, other = (section.cells[teacher, "obedient"] for teacher in ("oracle", "silent"))
    assert section.paired("oracle", "obedient").tolist() == [one.regrets.tolist(), other.regrets[[0, 2]].tolist()]


def test_episodes_of_other_seeds_rules_and_lists_are_left_out(path, records):
    study = Study(ids=IDS[:1], teachers=("oracle",), students=STUDY.students, seeds=(7, 2), max_turns=4)
    with contextlib.closing(sqlite3.connect(path)) as db, db:
        db.execute("UPDATE setting SET rules = '0.0' WHERE student = 'random'")
    data = read(Store(path), study)
    assert (data.present, data.expected) == (2, 4)
    assert list(data.sections[0].cells) == [("oracle", "obedient")]


def test_sums_are_those_of_the_episodes(path, records):
    (account,) = (a for a in accounts(read(Store(path), STUDY), "b", "a") if a.teacher == "oracle")
    mine = [record.episode for record in of(records, teacher="oracle")]
    assert account.turns == sum(episode.turns for episode in mine)
    assert account.per_turn["fp"] == sum(episode.said_fp for episode in mine) / account.turns
    assert account.words == sum(episode.words for episode in mine) / account.turns
    obedient = [record.episode for record in of(records, teacher="oracle", student="obedient")]
    assert account.uptake == sum(e.followed for e in obedient) / sum(e.advised for e in obedient)


def test_turns_are_read_of_what_is_shown_only(path, records):
    """Without any turns, tables and curves are the same."""
    before = read(Store(path), STUDY).sections[0].regret
    with contextlib.closing(sqlite3.connect(path)) as db, db:
        db.execute("DELETE FROM story")
    (section,) = read(Store(path), STUDY).sections
    assert f"{section.regret}" == f"{before}"
    with pytest.raises(StoreError, match=r"the turns of the episode .* are incomplete"):
        render(Store(path), STUDY)


def test_each_row_is_looked_at_once(path):
    """With types that do not match, the wanted seeds would be gone through for each row."""
    planned = columns.plan(STUDY)
    with contextlib.closing(sqlite3.connect(path)) as db, db:
        columns.Columns(db, planned)
        steps = [row[3] for row in db.execute(f"EXPLAIN QUERY PLAN SELECT setting FROM {columns._WANTED}")]
    assert [step.split()[0] for step in steps] == ["SCAN", "SEARCH", "SEARCH"]
    assert "list=? AND seed=?" in steps[2]
