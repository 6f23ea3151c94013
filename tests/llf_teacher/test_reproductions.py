"""Known results: what is measured is stored, resumed, read and written up."""

import importlib.util
import json
import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from design import amount
from typer.testing import CliRunner

from llf_teacher.cli import app
from llf_teacher.registry import family
from llf_teacher.reproductions import household, page
from llf_teacher.reproductions.asking import attended
from llf_teacher.reproductions.classes import accompanied
from llf_teacher.reproductions.lessons import regrets
from llf_teacher.reproductions.lifetimes import live
from llf_teacher.reproductions.play import Measurement, load, play, tasks
from llf_teacher.reproductions.reviews import Notes, Remark, commented
from llf_teacher.reproductions.row import FIRST_SEED, Values, all_rows, digest, some_rows
from llf_teacher.reproductions.rows import classroom, curriculum, embodied
from llf_teacher.reproductions.rows.growth import exponent
from llf_teacher.reproductions.rule import ALPHA, VERDICTS, judge
from llf_teacher.students.parsing import parse_student
from pz_envs.family import all_families
from teachers.personality import parse_personality

ROWS = all_rows()


@pytest.mark.parametrize("name", ROWS)
def test_a_row_is_complete(name):
    row = ROWS[name]
    rule = row.rule
    assert rule.seeds >= 8  # where a seed is a training, or a class, it costs more
    assert 2 ** (1 - rule.seeds) * len(rule.comparisons) < ALPHA  # so that a verdict is possible
    played = {digest(setting) for setting in row.settings}
    for each in rule.comparisons:
        of = (each.share_of,) if each.share_of is not None else ()
        assert played >= {digest(setting) for setting in (*each.more, *each.less, *of)}
        assert each.measure in row.measures
        assert each.least != 0
        assert "|" not in each.expects
    assert len({each.expects for each in rule.comparisons}) == len(rule.comparisons)
    assert len({digest(setting) for setting in row.settings}) == len(row.settings)
    for setting in row.settings:
        if "student" in setting:
            parse_student(setting["student"])
        if "teacher" in setting:
            parse_personality(setting["teacher"])
    for text in (row.claim, row.source, row.protocol):
        assert "|" not in text


@pytest.mark.parametrize("name", ROWS)
def test_a_row_reads_and_draws_whatever_was_measured(name, tmp_path):
    """With numbers drawn at random; its tables are whole."""
    row = ROWS[name]
    rng = np.random.default_rng(0)
    values = Values({digest(setting): rng.random((3, len(row.measures))) for setting in row.settings}, 120.0)
    finding = row.read(values)
    heads, *judged = page.rule_table(judge(row.rule, values, row.measures))
    assert {cells[-1] for cells in judged} <= set(VERDICTS)
    assert {len(cells) for cells in judged} == {len(heads)}
    assert len({len(cells) for cells in finding.table}) == 1
    assert "|" not in finding.ours + finding.why
    page.write({name: row}, {name: values}, tmp_path / "page.md")
    listed = (tmp_path / "page.md").read_text()
    assert f"| [{row.claim}](page/{name}.md) " in listed
    assert f"](page/{name}.png) |" in listed
    own = (tmp_path / "page" / f"{name}.md").read_text()
    assert finding.ours in own
    assert f"]({name}.png)" in own
    assert "](../page.md)" in own
    assert (tmp_path / "page" / f"{name}.png").stat().st_size > 1000
    results = json.loads((tmp_path / "page" / f"{name}.json").read_text())["results"]
    assert [each["setting"] for each in results] == [dict(setting) for setting in row.settings]
    assert np.allclose(results[-1]["values"], values(**row.settings[-1]), rtol=1e-5)


@pytest.mark.parametrize("name", [name for name, row in ROWS.items() if not row.needs])
def test_a_row_measures(name, monkeypatch):
    """The first setting, twice the same, with few episodes; what needs more than the core is in tests/rl/learn."""
    row = ROWS[name]
    monkeypatch.setattr(f"llf_teacher.reproductions.rows.{name}.EPISODES", amount(2, full=3), raising=False)
    first, again = (row.measure(**row.settings[0], seed=FIRST_SEED) for _ in range(2))
    assert list(first) == list(again)
    assert np.isfinite(first).all()


def test_what_was_measured_is_not_measured_again(tmp_path):
    path = tmp_path / "it.jsonl"
    row = ROWS["policy_shaping"]
    small = {"policy_shaping": replace(row, settings=row.settings[:2], rule=replace(row.rule, seeds=2))}
    values = play(small, path)["policy_shaping"]
    lines = path.read_text().splitlines()
    assert len(lines) == 4
    path.write_text("\n".join([*lines[:3], lines[3][:20]]))  # it was killed while it wrote
    seen = []
    again = play(small, path, report=lambda *told: seen.append(told))["policy_shaping"]
    assert seen == [("policy_shaping", 4, 4)]
    for setting in row.settings[:2]:
        assert values(**setting).tolist() == again(**setting).tolist()
    assert sorted(load(path)) == sorted(task.key for task in tasks("policy_shaping", small["policy_shaping"], False))
    assert all(isinstance(each, Measurement) for each in load(path).values())


def reproduced(tmp_path, which=""):
    """What the command says where one row has been measured, and how many measurements that is."""
    there = [task.key for task in tasks("policy_shaping", ROWS["policy_shaping"], quick=True)]
    (tmp_path / "it.jsonl").write_text("".join(json.dumps({key: [[0.5], 1.0]}) + "\n" for key in there))
    command = f"reproduce {which} --quick --store {tmp_path / 'it.jsonl'} --page {tmp_path / 'page.md'}"
    result = CliRunner().invoke(app, command, env={"COLUMNS": "200"})
    assert result.exit_code == 0, result.output
    return result, len(there)


def test_the_command(tmp_path):
    result, _ = reproduced(tmp_path, "--only policy_shaping")
    assert "policy_shaping: open" in result.output
    assert (
        "**Open**: significantly greater than the smallest that counts: 0 of 2 expected effects;"
        in (tmp_path / "page" / "policy_shaping.md").read_text()
    )


def test_a_page_keeps_the_rows_that_are_not_played(tmp_path):
    """As long as they are about what they were measured of."""
    for name in ("growth", "silence"):
        row = ROWS[name]
        values = Values({digest(each): np.ones((3, len(row.measures))) for each in row.settings}, 240.0)
        page.write({name: row}, {name: values}, tmp_path / "page.md")
    (tmp_path / "page" / "growth.json").write_text((tmp_path / "page" / "growth.json").read_text().replace("32", "33"))
    _, there = reproduced(tmp_path, "--only policy_shaping")
    text = (tmp_path / "page.md").read_text()
    assert re.findall(r"\]\(page/(\w+)\.md\)", text) == ["policy_shaping", "silence"]
    minutes = there / 120
    own = (tmp_path / "page" / "silence.md").read_text()
    assert "`llf reproduce --only silence`, 2.0 minutes of 2 cores" in own
    assert f"All of it takes {2 + minutes:.0f} minutes of 2 cores, {2 + minutes:.1f} with `--quick`." in text


def test_a_row_whose_package_is_not_installed_is_left_out(tmp_path, monkeypatch):
    """Unless it is asked for by its name: then that is an error."""
    find_spec = importlib.util.find_spec
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == "torch" else find_spec(name))
    short = {name: row for name, row in ROWS.items() if name in ("embodied", "policy_shaping")}
    monkeypatch.setattr("llf_teacher.reproductions.row.all_rows", lambda: short)
    result, _ = reproduced(tmp_path)
    assert "left out: the row embodied needs 'torch'" in result.stderr
    assert "page/policy_shaping.md" in (tmp_path / "page.md").read_text()
    assert "embodied" not in (tmp_path / "page.md").read_text()
    with pytest.raises(ModuleNotFoundError, match=r"the row embodied needs 'torch'.*llf-teacher\[learn\]"):
        some_rows(["embodied"])


def test_errands_in_words():
    """What is seen, heard and done turn by turn; the least number of commands is what the oracle's plan takes."""
    env = embodied.house("hp+hn+fp", "plain", household.Sentences(False, None), max_turns=20)
    (errand,) = household.play([(env, 3)], household.blundering(env, 0.0, np.random.default_rng(0)))
    assert errand.success
    assert errand.score == 1
    assert len(errand.turns) == errand.least
    assert errand.task.startswith("Your task is to: ")
    assert errand.task not in errand.turns[0].seen
    assert errand.turns[0].last == ""
    for before, after in pairwise(errand.turns):
        assert before.done in before.commands
        assert f"`{before.done}`" in before.heard
        assert after.last == before.done
        assert dict(zip(after.commands, after.before, strict=True)).get(before.done, 1) == 1
        assert "Admissible" not in after.seen
    (astray,) = household.play([(env, 3)], household.blundering(env, 1.0, np.random.default_rng(0)))
    assert astray.least == errand.least
    assert astray.score < 1


@pytest.mark.parametrize("many", [False, True])
def test_sentences_of_the_test_are_in_no_lesson(many):
    """Of what judges and advises; and one sentence is one."""
    said = {}
    for test, voices in ((False, embodied.VOICES["many" if many else "one"]), (True, (embodied.TEST_VOICE,))):
        wording = household.Sentences(test, np.random.default_rng(0) if many or test else None)
        said[test] = {
            voice: {
                claim: {wording(templates, action="X", left=1) for _ in range(200)}
                for claim, templates in family("alfworld").phrasebook(voice).items()
                if claim.__name__ in ("Do", "Nearer", "NoNearer", "Done", "Refused")
            }
            for voice in voices
        }
    for claim, tested in said[True][embodied.TEST_VOICE].items():
        assert len(tested) > 4
        for voice, taught in said[False].items():
            plain = said[False]["plain"][claim]
            assert not any(test.endswith(sentence) for test in tested for sentence in plain)
            assert (len(taught[claim]) > 1) == many, voice


def test_words_are_numbers():
    assert household.numbers("Go to `desk 1`.") == household.numbers("go  to ` Desk 1 ` .")
    assert len(set(household.numbers("take apple 1 from desk 2"))) == 6
    assert all(0 < number < household.WORDS for number in household.numbers("take apple 1 from desk 2"))


def test_a_row_that_is_not_there():
    with pytest.raises(ValueError, match="policy_shaping"):
        some_rows(["policy_shapping"])


def test_lifetimes_count_verdicts():
    """A student who is told what to do makes no mistake, so that each of its moves is praised once."""
    family = next(family for family in all_families() if family.name == "gridworld")
    *lost, verdicts = live("llf-gridworld-v0", student="obedient", teacher="oracle", episodes=3, turns=40, seed=5)
    assert lost == [0.0] * 3
    assert verdicts % 3 == 0
    assert 3 <= verdicts <= 3 * family.max_turns
    *_, silent = live("llf-gridworld-v0", student="obedient", teacher="silent", episodes=2, turns=10, seed=5)
    assert silent == 0


def test_regrets_of_a_lesson():
    lost, solved = regrets("llf-gridworld-v0", student="oracle", teacher="silent", seed=3)
    assert not any(lost)
    assert solved[-1]


def test_exponents():
    sizes = (1, 2, 4, 8)
    around = np.linspace(0.5, 1.5, 20)
    found = exponent(sizes, [3.0 * size**1.5 * around for size in sizes])
    assert found.mean == pytest.approx(1.5)
    assert 1.3 < found.low < 1.5 < found.high < 1.7
    assert exponent(sizes, [around, 0 * around, around, around]) is None
    seldom = np.array([0.0, 0.0, 1.0])  # some resamples have no regret at all
    assert np.isfinite(exponent(sizes, [seldom, seldom, seldom + 1, seldom + 2])[:4]).all()


LIFE = {"episodes": 3, "turns": 15, "seed": 4}


def test_a_question_changes_nothing_but_what_is_answered():
    """Who asks in each turn and is not answered lives as who does not ask; answered, as who is advised unasked."""
    asks, says, budget = (lambda values, visits: True), (lambda importance, mistake: True), 10
    id = "llf-gridworld-v0"
    alone = attended(id, None, lambda importance, mistake: False, budget=budget, **LIFE)
    unanswered = attended(id, asks, lambda importance, mistake: False, budget=budget, **LIFE)
    assert alone == unanswered
    assert alone.regret > 0
    assert alone.said == 0 < alone.looked <= 3 * 15
    assert attended(id, asks, says, budget=budget, **LIFE) == attended(id, None, says, budget=budget, **LIFE)
    never = attended(id, lambda values, visits: False, says, budget=budget, **LIFE)
    assert (never.regret, never.looked, never.said) == (alone.regret, 0, 0)


def test_a_student_asks_by_what_it_has_learned():
    """It has seen no room before the first time, and all is worth the same until the treasure is found."""
    asked = []

    def asks(values, visits):
        asked.append((tuple(values), visits))
        return False

    house = {"num_rooms": 6, "min_goal_dist": 2}
    attended("llf-gridworld-v0", asks, lambda importance, mistake: True, budget=1, **LIFE, **house)
    assert asked[0] == ((0.0,) * 4, 0)
    assert max(visits for _, visits in asked) > 1
    assert any(max(values) > 0 for values, _ in asked)


def test_a_class_that_is_always_advised_wastes_nothing():
    by_rule = {
        said: accompanied("llf-gridworld-v0", rule, seed=3, episodes=2, turns=30, budget=10_000)
        for said, rule in {"all": lambda seen: seen.way > 0, "none": lambda seen: seen.way < 0}.items()
    }
    assert by_rule["all"].regret == by_rule["none"].said == 0
    assert by_rule["all"].said >= 2 * 4  # the treasure is at least four moves away
    assert by_rule["none"].regret > 1
    assert 0.5 < by_rule["none"].greatest < 1


def test_a_class_with_attention_for_all_wastes_nothing():
    assert classroom.measure("at random", classroom.PUPILS, seed=2) == [0, 0]


def test_practice_begins_in_the_room_that_was_picked():
    school = curriculum._Practice(seed=1)
    for room in (3, 7):
        moves, wasted, found = school.episode(room, 1)
        assert (moves, school.session.moment.before.room) == (1, room)
        assert found == (wasted == 0 and school.steps[room] == 1)
    assert school.steps[school.task.room] >= curriculum.LEAST


REVIEW = {"student": "obedient(forget=False)", "feedback": "fp", "teacher": "end_of_episode(top_k=32)", "turns": 30}


def test_the_very_claim_goes_further_than_its_kind():
    """Of a review with twelve claims: the rooms that matter are named once each."""
    lives = {
        speech: [
            commented("llf-gridworld-v0", **REVIEW, speech=speech, budget=12, episodes=8, seed=seed)
            for seed in range(6)
        ]
        for speech in ("claims", "kinds")
    }
    assert all(said <= 12 for each in lives.values() for _, said in each)
    assert np.mean([lost for lost, _ in lives["claims"]]) < 0.8 * np.mean([lost for lost, _ in lives["kinds"]])


def test_at_once_a_kind_is_its_claim():
    life = {**REVIEW, "teacher": "oracle", "budget": 5, "episodes": 3, "seed": 2}
    assert commented("llf-gridworld-v0", **life, speech="claims") == commented(
        "llf-gridworld-v0", **life, speech="kinds"
    )


def test_notes_of_what_was_said():
    """What is right before what is wrong, rooms by their visits, and a room of which the best is known is done with."""
    notes = Notes()
    wrong, right, other = Remark(1, 0, False), Remark(1, 2, True), Remark(4, 1, False)
    notes._way = [1, 4, 4, 1, 4]
    assert notes.best([wrong, other]) == 1
    assert notes.best([wrong, right, other]) == 1
    notes.say([right])
    assert notes.best([wrong, right, other]) == 2
    notes.say([other])
    assert notes.best([wrong, right, other]) is None
