"""Several samples of an episode: one world, one teacher, other draws of the student."""

import itertools
import re
from fractions import Fraction

import pytest

from llf_teacher.models.testing import ScriptedEndpoint
from llf_teacher.studies import load, run
from llf_teacher.studies.analysis.pass_at_k import Sampled, pass_at
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.execution.runner import RunOptions
from llf_teacher.studies.report.columns import plan
from llf_teacher.studies.report.data import read
from llf_teacher.studies.report.page import page
from llf_teacher.studies.store import Store

ONE = {"ids": ["llf-gridworld-v0"], "teachers": ["silent"], "students": ["random"], "seeds": 2, "max_turns": 6}


def test_samples_share_a_world_and_not_the_students_draws(tmp_path):
    study = Study(**ONE, samples=8)
    records = [play(spec) for spec in study.episodes()]
    assert len({record.spec.key for record in records}) == 16
    for seed in (0, 1):
        same = [record for record in records if record.spec.seed == seed]
        assert len({record.turns[0].observation for record in same}) == 1
        assert len({tuple(turn.action for turn in record.turns) for record in same}) > 4
    with Store(tmp_path / "s.db") as store:
        for record in records:
            store.add(record)
        assert not list(store.damage())
    chances = pass_at(8, load(tmp_path / "s.db").rows())
    assert list(chances) == [Sampled("llf-gridworld-v0", "silent", "random", "b", "a")]


def test_the_first_sample_is_the_episode_without_samples():
    alone, many = (list(Study(**ONE, samples=samples).episodes()) for samples in (1, 3))
    assert many[: len(alone)] == alone
    assert many[0].key == alone[0].key
    first = {setting: seeds for setting, seeds in plan(Study(**ONE, samples=3)).items() if not setting.sample}
    assert first == plan(Study(**ONE))


def test_the_report_is_of_all_samples(tmp_path):
    """A seed counts as the mean of its samples, and pass@k is told."""
    study = Study(
        **(ONE | {"seeds": 4, "students": ["random", "obedient"], "teachers": ["oracle", "silent"]}), samples=3
    )
    results = run(study, tmp_path / "s.db", options=RunOptions("here"))
    with Store(results.path) as store:
        data = read(store, study)
        html = page(data)
    section, rows = data.sections[0], list(results.rows())
    mine = [row for row in rows if (row["teacher"], row["student"]) == ("silent", "random")]
    assert len(mine) == 12
    assert data.present == data.expected == 48
    assert section.success["silent", "random"].mean == pytest.approx(sum(row["success"] for row in mine) / 12)
    assert section.regret["silent", "random"].mean == pytest.approx(sum(row["regret"] for row in mine) / 12)
    assert section.regret["silent", "random"].n == 4
    (cells,) = data.outcomes.values()
    assert cells["silent", "random"].regret.mean() == pytest.approx(sum(row["regret"] for row in mine) / 12)
    assert all(f'<th scope="col">pass@{k}</th>' in html for k in (1, 2, 3))
    chance = pass_at(3, mine)[Sampled("llf-gridworld-v0", "silent", "random", "b", "a")]
    cell = re.search(r"<code>silent</code></td><td><code>random</code></td>\s*<td>4</td>(<td>\d+</td>){3}", html)
    assert cell[1] == f"<td>{100 * chance:.0f}</td>"
    with Store(results.path) as store:
        assert "pass@" not in page(read(store, Study(**ONE)))


def test_a_model_is_sampled_with_other_seeds():
    with ScriptedEndpoint(lambda request: "Response: no") as server:
        student = f"llm(model='m', base_url='{server.url}', answer='text', temperature=1.0)"
        for spec in Study(**(ONE | {"students": [student], "seeds": 1, "max_turns": 1}), samples=4).episodes():
            play(spec)
    assert len({request["seed"] for request in server.requests}) == 4
    assert len({request["messages"][-1]["content"] for request in server.requests}) == 1


@pytest.mark.parametrize("k", [1, 2, 4])
def test_pass_at_k_is_the_share_of_subsets_with_a_success(k):
    won = {0: [True, False, False, False], 1: [False] * 4, 2: [True, True, False, True]}
    cell = Sampled("a", "b", "c", "b", "a")
    rows = [
        {**cell._asdict(), "seed": seed, "first_success": 3 if each else None}
        for seed, samples in won.items()
        for each in samples
    ]
    shares = [Fraction(sum(map(any, chosen := list(itertools.combinations(s, k)))), len(chosen)) for s in won.values()]
    assert pass_at(k, rows)[cell] == pytest.approx(float(sum(shares) / 3))
    with pytest.raises(ValueError, match="k must be from 1 to 4, the number of samples of each world"):
        pass_at(5, rows)


@pytest.mark.parametrize("samples", [0, 1.5, True, "8"])
def test_what_is_no_number_of_samples(samples):
    with pytest.raises(ValueError, match="samples must be an integer from 1 to 1000000"):
        Study(**ONE, samples=samples)
