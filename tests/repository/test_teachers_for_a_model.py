"""Teachers for a model, as far as they need no model: what is said, what becomes of it, the table and the verdicts."""

import json
import math
import sys
from functools import cache
from itertools import accumulate, pairwise, takewhile
from pathlib import Path

import numpy as np
import pytest

from llf_teacher import make
from teachers.atoms import Scope
from teachers.oracles.gridworld.claims import Map
from worlds.gridworld import kind_of

sys.path.insert(0, f"{Path(__file__).parents[2] / 'examples'}")
import teachers_for_a_model as program
from teachers_for_a_model import TEACHERS, Lesson, Teaching
from word_signals import HELD_OUT, Town


@pytest.fixture(scope="module")
def town():
    return Town("gridworld", 0)


@pytest.fixture(scope="module")
def seeds(town):
    return town.seeds(0, 16)


def taught(town, seeds, name, words, mistaken=None):
    lesson = Lesson(town, TEACHERS[name], words)
    return lesson, lesson.teach(seeds, mistaken or [True] * len(seeds))


def test_a_house_is_the_same_with_its_plan(town, seeds):
    env = make(town.place.id, options=program.mapped(town))
    prompts = [step.prompt for step in town.judge(seeds, [""] * len(seeds))]
    for seed, prompt in zip(seeds, prompts, strict=True):
        _, info = env.reset(seed=seed)
        assert env.session.world.truth == town.truth(seed)
        (plan,) = [atom.claim.listing for atom in info["atoms"] if isinstance(atom.claim, Map)]
        assert plan in env.session.instruction
        assert not any(plan in message["content"] for message in prompt)


@pytest.mark.parametrize("name", [name for name in TEACHERS if name != program.REFERENCE])
def test_a_budget_is_kept_to_the_word(town, seeds, name):
    budget, seeds = 25, seeds[:8]
    lesson, houses = taught(town, seeds, name, budget)
    free = [house.words for house in taught(town, seeds, name, math.inf)[1]]
    fits = len([*takewhile(lambda total: total <= budget, accumulate(free))])
    assert [house.words for house in houses] == [*free[:fits], *[0] * (len(seeds) - fits)]
    assert 0 < sum(house.words for house in houses) <= budget < sum(free)
    assert all(house.words == len(house.said.split()) for house in houses)
    assert lesson.speaker.left == 0


def test_no_target_comes_from_anything_but_words(town, seeds):
    for name in ("mistake_correcting", "ruler", "two_bits"):
        lesson, houses = taught(town, seeds[:4], name, 0)
        assert not lesson.targets, name
        assert not any(house.words or house.target for house in houses)
    lesson, houses = taught(town, seeds, "early", 30)
    assert [house.target for house in houses] == [bool(house.said) for house in houses]
    assert len(lesson.targets) == sum(house.target for house in houses) < len(seeds)
    for row, house in zip(lesson.targets, houses, strict=False):
        assert row["completion"][0]["content"] == house.answer
        assert house.answer.removeprefix("Response: ") in house.said
        assert not any(house.said in message["content"] for message in row["prompt"])


def test_only_a_mistake_is_corrected(town, seeds):
    mistaken = [number % 3 == 0 for number in range(len(seeds))]
    _, houses = taught(town, seeds, "mistake_correcting", 1000, mistaken)
    assert [bool(house.said) for house in houses] == mistaken == [house.target for house in houses]
    advised = taught(town, seeds, "early", 1000)[1]
    assert all(house.said in ("", other.said) for house, other in zip(houses, advised, strict=True))


def test_true_words_make_right_targets_and_misleading_words_wrong_ones(town):
    seeds = town.seeds(500, 24)
    shares = []
    for personality in ("early", "early | misaligned"):
        houses = Lesson(town, Teaching("", personality, "fp"), math.inf).teach(seeds, [True] * 24)
        shares.append(np.mean([house.success for house in houses if house.target]))
    assert shares[0] == 1
    assert shares[1] < 0.6


def rooms_by_law(town, seed):
    """Number of rooms that a treasure can be in by the law."""
    room, _, layout = town.truth(seed)
    return sum(kind_of(name) == layout.law for number, name in enumerate(layout.names) if number != room)


@pytest.mark.parametrize("name", ["ruler", "two_bits"])
def test_a_rule_of_the_town_is_said_once_and_lasts(town, name):
    lesson, houses = taught(town, town.seeds(0, 24), name, 100)
    rules = lesson.speaker.rules
    assert len(rules) == len({*rules}) == {"ruler": 3, "two_bits": 1}[name]
    assert all(rule.scope is Scope.FAMILY for rule in rules)
    assert rules[-1].rooms == (town.world.law,)
    said = [place for place, house in enumerate(houses) if house.said]
    if name == "ruler":
        assert said == [0, 1, 2]
    silent = [house for place, house in enumerate(houses) if place > 2 and not house.said]
    assert len(silent) > 8
    assert all(house.target for house in silent)
    clear = [house for house in silent if rooms_by_law(town, house.seed) == 1]
    assert len(clear) > 3
    assert all(house.success for house in clear)


def test_targets_are_drawn_from_all_so_far():
    targets = [{"prompt": number} for number in range(40)]
    drawn = program.draw_targets(targets, 32, np.random.default_rng(0))
    assert len({row["prompt"] for row in drawn}) == 32
    few = program.draw_targets(targets[:5], 32, np.random.default_rng(0))
    assert len(few) == 32
    assert {row["prompt"] for row in few} == {*range(5)}
    assert program.draw_targets([], 32, np.random.default_rng(0)) == []


@cache
def houses_of_tests(seed):
    """Some houses that the tests of a training seed have."""
    return Town("gridworld", seed).seeds(HELD_OUT, 50)


def plant(out, name, stage, shares, words=200, worlds=50):
    """Finished runs of a stage with these shares of found treasures."""
    for seed, found in zip(program.STAGES[stage], shares, strict=True):
        settings = {"family": "gridworld", "updates": 1, "format": 0, "steps": 1, "worlds": worlds, "words": 200}
        run = program.Taught(out, name, seed, settings)
        run.check()
        said = " ".join(["north"] * words)
        house = {"kind": "house", "update": 0, "mistaken": True, "said": said, "words": words, "target": True}
        test = {"kind": "test", "update": 15, "test": "alone", "family": "gridworld", "last": True, "failure": None}
        places = range(worlds)
        tests = [
            test | {"seed": houses_of_tests(seed)[place], "success": place < round(found * worlds)} for place in places
        ]
        update = {"kind": "update", "update": 0, "steps": 32, "tokens": 1000, "cpu": 60.0}
        run.rows.add([house | {"seed": 1, "success": True}, update, *tests, {"kind": "end"}])


def plant_first(out, **shares):
    for name in TEACHERS:
        plant(out, name, 1, [shares.get(name, 0.3)] * 2)


def verdicts(out):
    return program.verdicts(program.results(out, [*TEACHERS]))


def line_of(lines, beginning):
    (found,) = [line for line in lines if line.startswith(beginning)]
    return found


BUMPS = np.array([0.0, 0.04, -0.04, 0.02, -0.02])


def test_a_planted_effect_is_found_and_the_best_advice_is_run_as_well(tmp_path):
    plant_first(tmp_path, ruler=0.8, two_bits=0.7, one_bit=0.6, early=0.5, unlimited=0.9)
    ranked = program.ranking(program.results(tmp_path, [*TEACHERS]))
    assert ranked[:4] == ["ruler", "two_bits", "one_bit", "early"], "the reference does not take part"
    names = program.in_second_stage(ranked)
    assert names == ["ruler", "two_bits", "one_bit", "early"]
    assert "not judged, not all seeds of stage 2 have ended" in line_of(verdicts(tmp_path), "Primary")
    for name, mean in zip(names, (0.8, 0.6, 0.4, 0.5), strict=True):
        plant(tmp_path, name, 2, mean + (BUMPS if name == "ruler" else BUMPS[::-1]))
    lines = verdicts(tmp_path)
    assert "+0.30, it teaches more, p = 0.00" in line_of(lines, "Primary hypothesis, ruler against early")
    assert "+0.40, it teaches more, p = 0.0" in line_of(lines, "ruler against one_bit")
    assert "after Holm" in line_of(lines, "two_bits against one_bit")
    assert "not judged, they are not both among the three best" in line_of(lines, "Second")


def test_no_effect_is_no_verdict(tmp_path):
    plant_first(tmp_path, ruler=0.6, mistake_correcting=0.6, early=0.6)
    ranked = program.ranking(program.results(tmp_path, [*TEACHERS]))
    assert ranked[:3] == ["early", "mistake_correcting", "ruler"]
    assert program.in_second_stage(ranked) == ranked[:3]
    for number, name in enumerate(ranked[:3]):
        plant(tmp_path, name, 2, 0.6 + np.roll(BUMPS, number))
    lines = verdicts(tmp_path)
    assert sum("nothing is shown" in line for line in lines) == 5
    assert not any("it teaches" in line for line in lines)


def test_the_opposite_of_a_hypothesis_is_said(tmp_path):
    plant_first(tmp_path, ruler=0.6, mistake_correcting=0.7, early=0.6)
    for number, (name, mean) in enumerate({"mistake_correcting": 0.4, "early": 0.7, "ruler": 0.5}.items()):
        plant(tmp_path, name, 2, mean + np.roll(BUMPS, number))
    lines = verdicts(tmp_path)
    assert "-0.30, it teaches less, p = 0.0" in line_of(lines, "Second hypothesis, mistake_correcting against early")
    assert line_of(lines, "Primary").startswith("Primary hypothesis, ruler against mistake_correcting: +0.10")


def test_rules_that_are_not_among_the_three_are_not_judged(tmp_path):
    plant_first(tmp_path, early=0.6, half_bit=0.6, one_bit=0.6)
    assert "not judged, neither ruler nor two_bits is among the three best" in line_of(verdicts(tmp_path), "Primary")


def test_among_equals_fewer_words_win(tmp_path):
    for name in TEACHERS:
        plant(tmp_path, name, 1, [0.5, 0.5], words={"two_bits": 150, "ruler": 41}.get(name, 200))
    assert program.ranking(program.results(tmp_path, [*TEACHERS]))[:3] == ["ruler", "two_bits", "early"]


def test_the_table_is_of_the_stored_rows(tmp_path, capsys):
    plant_first(tmp_path, ruler=0.8)
    plot = tmp_path / "curves.png"
    program.main(["--out", f"{tmp_path}", "--table", "--plot", f"{plot}"])
    lines = capsys.readouterr().out.splitlines()
    cells = {line.split(" | ")[0]: line.split(" | ") for line in lines if " | " in line}
    assert cells["stage 1: ruler, rules of the town"][1:] == [
        *("2", "0.80 (0.80 to 0.80)", "200", "1", "1", "1.00", "0%", "32", "1,000", "1.0")
    ]
    names = [line.split(": ")[1].split(",")[0] for line in lines if line.startswith("stage 1: ")]
    assert names == [*TEACHERS]
    law = float(cells["by the law: best without a teacher"][2])
    assert 0.7 < law < float(cells["oracle"][2]) == 1
    assert plot.stat().st_size > 5_000
    (tmp_path / "ruler-1/rows.jsonl").unlink()
    program.main(["--out", f"{tmp_path}", "--table"])
    assert "Nothing is judged yet: all runs of stage 1 must have ended, missing: ruler-1" in capsys.readouterr().out


def test_a_file_of_the_rows_has_the_same_table(tmp_path, capsys):
    plant(tmp_path, "early", 1, [0.4, 0.6], worlds=5)
    rows = tmp_path / "rows.jsonl"
    program.main(["--out", f"{tmp_path}", "--table", "--rows", f"{rows}"])
    printed = capsys.readouterr().out
    assert "0.50" in printed
    program.main(["--out", f"{rows}", "--table"])
    assert capsys.readouterr().out == printed


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"words": 6}, "must have as many words in each house as were said"),
        ({"words": "six"}, "must have as many words in each house as were said"),
        ({"target": "yes"}, "must say true or false of each house"),
        ({"update": 1}, "must have 1 houses in each update with a teacher, each once"),
        ({"said": "north " * 201, "words": 201}, "must have at most 200 words, got 201"),
    ],
)
def test_changed_houses_are_refused(tmp_path, changes, problem):
    plant(tmp_path, "early", 1, [0.4, 0.6], worlds=5)
    path = tmp_path / "early-1/rows.jsonl"
    rows = [json.loads(line) for line in path.read_text("utf-8").splitlines()]
    path.write_text(
        "".join(json.dumps(row | (changes if row["kind"] == "house" else {})) + "\n" for row in rows), "utf-8"
    )
    with pytest.raises(SystemExit, match=problem):
        program.main(["--out", f"{tmp_path}", "--table"])


def test_a_stage_without_runs_is_refused(tmp_path):
    with pytest.raises(SystemExit, match="must have finished runs, got none"):
        program.main(["--out", f"{tmp_path}", "--table"])
    with pytest.raises(SystemExit, match=r"missing: early-0, .* run --stage 1 first"):
        program.main(["--out", f"{tmp_path}", "--stage", "2"])
    for wrong in (["--stage", "3"], ["--teachers", "oracle"]):
        with pytest.raises(SystemExit) as error:
            program.main(["--out", f"{tmp_path}", *wrong])
        assert error.value.code == 2


def test_the_towns_of_the_second_stage_have_five_laws_and_not_that_of_tuning():
    laws = {Town("gridworld", seed).world.law for seed in program.STAGES[2]}
    assert len(laws) == 5
    assert Town("gridworld", 6).world.law not in laws
    assert not {*program.STAGES[1]} & {*program.STAGES[2]}
    settings = {"family": "gridworld", "updates": program.UPDATES, "steps": program.STEPS_OF_UPDATE}
    runs = [program.Taught(Path(), "early", seed, settings) for seed in (*program.STAGES[1], *program.STAGES[2])]
    firsts = [run.first(update) for run in runs for update in range(program.UPDATES)]
    assert min(b - a for a, b in pairwise(firsts)) > 1000
