"""A study that measures how much claims say: the same lessons, more columns, and why it could not be measured."""

import csv
import json
import math
import sys

import numpy as np
import pytest

from llf_teacher.episodes.record import EpisodeRow
from llf_teacher.studies import Study, run
from llf_teacher.studies.analysis.statistics import mean_interval, ratio_interval
from llf_teacher.studies.definition.study import load_study, to_toml
from teachers.atoms import KINDS

ROOMS, ARMS, POEM = "llf-gridworld-v0", "llf-bandits-BanditTenArmedGaussian-v0", "llf-poem-Haiku-v0"
MEASURED = EpisodeRow._fields[EpisodeRow._fields.index("measured") :]
LISTS = {"teachers": ["oracle", "mistake(eps=0.5)", "silent"], "students": ["random", "obedient"], "max_turns": 4}


def study(**changes):
    return Study(**LISTS | {"ids": [ROOMS, ARMS, POEM], "seeds": 2, "bits": 16} | changes)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    with run(study(), tmp_path_factory.mktemp("bits") / "s.db", workers=1) as found:
        yield found


def bare(values, *names):
    return {name: value for name, value in values.items() if name not in names}


def test_measuring_changes_no_lesson(results, tmp_path):
    with run(study(bits=False), tmp_path / "s.db", workers=1) as plain:
        for with_bits, without in zip(results.rows(), plain.rows(), strict=True):
            own = ("key", "draws", *MEASURED)
            assert bare(with_bits, *own) == bare(without, *own)
            assert (without["draws"], without["why"], without["measured"]) == (0, "", None)
            turns = results.turns(with_bits["key"])
            for turn in turns:
                turn["atoms"] = [bare(atom, "information") for atom in turn["atoms"]]
            assert turns == plain.turns(without["key"])
        assert 'id="information"' not in plain.report().html


def test_claims_beside_words_of_its_own_are_measured_by_all_words(tmp_path, monkeypatch):
    (tmp_path / "composers.py").write_text(COMPOSER)
    monkeypatch.syspath_prepend(tmp_path)
    with run(study(ids=[ARMS], teachers=["composers:Composer"], seeds=1), tmp_path / "s.db", workers=1) as found:
        for row in found.rows():
            assert row["measured"] > 0
            assert row["measured_words"] == row["words"] == 4 * row["turns"]
    monkeypatch.delitem(sys.modules, "composers")


COMPOSER = """
class Composer:
    def reset(self, rng):
        pass

    def act(self, observation, info):
        if not info["moment"].turn:
            return "Find the treasure."
        vocabulary = info["vocabulary"]
        claims = [atom.claim for atom in info["suggestion"].atoms if type(atom.claim) in vocabulary.classes.values()]
        return {"claims": [vocabulary.data_of(claim) for claim in claims], "text": "It is that way."}
"""


def test_sums_are_those_of_the_claims(results):
    for row in results.rows():
        turns = results.turns(row["key"])
        told = [atom for turn in turns for atom in turn["atoms"] if "information" in atom]
        if row["family"] != "bandits":
            assert not told
            assert [row[name] for name in MEASURED[:-1]] == [None] * len(MEASURED[:-1])
            continue
        assert (row["why"], row["unmeasured"], row["measured"]) == ("", 0, len(told))
        assert len(told) == row["claims"]  # a basic instruction has no feedback
        assert row["bits"] == pytest.approx(math.fsum(atom["information"]["bits"] for atom in told))
        assert row["bits"] == pytest.approx(math.fsum(row[f"bits_{kind}"] for kind in KINDS))
        assert row["measured_words"] == row["words"]
        assert row["at_least"] == sum(not atom["information"]["held"] for atom in told)
        assert all(atom["information"]["worlds"] == 16 for atom in told)


def test_what_an_instruction_says_is_not_counted(tmp_path):
    with run(study(ids=[ARMS], instruction_types=["p"]), tmp_path / "s.db", workers=1) as found:
        row = next(found.rows())
        assert row["claims"] > row["measured"] + row["unmeasured"] > 0
        heard = [atom for turn in found.turns(row["key"]) for atom in turn["atoms"] if atom["text"] in turn["feedback"]]
        assert row["measured"] + row["unmeasured"] == len(heard)
        assert all("information" in atom for atom in heard)


def test_the_report_says_how_much_was_said_and_what_was_not_measured(results):
    page = results.report().html
    part = page[page.index('<section id="information"') :].partition("</section>")[0]
    assert "the family &#39;poem&#39; has no posterior" in part
    assert "set the option map=True" in part
    assert "<h3>Bandits</h3>" in part
    assert "<h3>Poem</h3>" not in part
    row = part[part.index("<code>oracle</code>") :].partition("</tr>")[0]
    mine = [row for row in results.rows() if (row["family"], row["teacher"]) == ("bandits", "oracle")]
    bits, turns, words = (sum(row[name] for row in mine) for name in ("bits", "turns", "words"))
    assert f'<td class="first">{bits / turns:.2f}<span' in row
    assert f'<td class="first">{bits / words:.3f}<span' in row
    silent = part[part.index("<code>silent</code>") :].partition("</tr>")[0]
    assert silent.count("<td>\N{EN DASH}</td>") == 1  # no bits to save by


def test_exports_have_the_columns(results, tmp_path):
    results.export(tmp_path / "e.csv")
    results.export(tmp_path / "e.jsonl")
    with (tmp_path / "e.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    lines = [json.loads(line) for line in (tmp_path / "e.jsonl").read_text().splitlines()]
    for one, other, row in zip(table, lines, results.rows(), strict=True):
        assert other == row
        assert one["bits"] == ("" if row["bits"] is None else repr(row["bits"]))
        assert one["why"] == row["why"]


def test_the_option_in_a_file(tmp_path):
    for bits, draws in ((False, 0), (True, 256), (8, 8)):
        (tmp_path / "s.toml").write_text(to_toml(study(bits=bits)))
        again = load_study(tmp_path / "s.toml")
        assert again == study(bits=bits)
        assert {spec.draws for spec in again.episodes()} == {draws}
    spec = next(study(bits=False).episodes())
    assert spec._replace(draws=8).key != spec.key
    for bits in (0, -1, 1.5, "yes", None):
        with pytest.raises(ValueError, match="bits must be true, false or a number of worlds, 1 to 100000, got"):
            study(bits=bits)


def test_tests_without_a_teacher_are_not_measured():
    taught = study(ids=[ROOMS], transfer={"lessons": [1], "students": ["text_only(forget=False)"]})
    assert {(spec.lessons > 0, spec.draws) for spec in taught.episodes()} == {(False, 16), (True, 0)}


def test_a_ratio_of_sums_and_its_interval(rng):
    wholes = rng.gamma(9, size=40)
    parts = wholes * rng.normal(0.5, 0.1, 40)
    found = ratio_interval(parts, wholes)
    assert found.mean == pytest.approx(parts.sum() / wholes.sum())
    assert found.low < found.mean < found.high
    equal = np.full(40, 4.0)  # then it is a mean
    assert ratio_interval(parts, equal)[:3] == pytest.approx(mean_interval(parts / 4)[:3])
    assert ratio_interval([1, 2, 0], [2, 2, 0]).values == (0.5, 1)
    assert ratio_interval([0.0, 0.0], [0.0, 0.0]) is None
