"""GEPA improves a prompt by what the teacher says, with scripted models."""

import runpy
import sys
from types import ModuleType

import gepa
import pytest
from advice import BANDIT, advice_from, advised
from documents import python_blocks

from llf_teacher.integrations.dialogue import SCORES
from llf_teacher.integrations.games import Game
from llf_teacher.integrations.gepa import ADVICE, LLFAdapter


def student(messages):
    return advised(messages[0]["content"].rpartition("\n\n")[2])


def test_a_prompt_is_improved_by_what_is_said(tmp_path):
    """What the teacher names is the better arm."""
    seed = next(
        seed
        for seed in range(20)
        if LLFAdapter(student, score="regret").play(Game(BANDIT, seed), "").scores["regret"] > 0
    )
    adapter = LLFAdapter(student, score="regret", feedback_type="fp", max_turns=3)
    games = [Game(BANDIT, seed)]
    asked = []

    def reflection_lm(prompt):
        asked.append(prompt)
        return f"```\n{advice_from(prompt)}\n```"

    result = gepa.optimize(
        {ADVICE: "Do as you like."},
        trainset=games,
        valset=games,
        adapter=adapter,
        reflection_lm=reflection_lm,
        reflection_minibatch_size=1,
        perfect_score=0.0,
        max_metric_calls=6,
        run_dir=f"{tmp_path}",
    )
    assert result.best_candidate[ADVICE].startswith("pull arm")
    first, *_, last = result.val_aggregate_scores
    assert first < last == 0
    assert "Teacher: " in asked[0]
    assert "Do as you like." in asked[0]


def test_what_is_reflected_on_has_the_feedback():
    adapter = LLFAdapter(student, max_turns=2)
    batch = adapter.evaluate([Game(BANDIT, 0), Game(BANDIT, 1)], {ADVICE: "pull arm 0"}, capture_traces=True)
    assert len(batch.scores) == 2
    assert all(tuple(scores) == tuple(SCORES) for scores in batch.outputs)
    records = adapter.make_reflective_dataset({ADVICE: ""}, batch, [ADVICE])[ADVICE]
    assert [record["Scores"]["return"] for record in records] == batch.scores
    for record, played in zip(records, batch.trajectories, strict=True):
        assert played.turns[2]["feedback"] in record["Feedback"]
        assert len(record["Generated Outputs"]) == 2
    assert adapter.evaluate([Game(BANDIT, 0)], {ADVICE: ""}).trajectories is None


def test_the_score_must_be_one():
    with pytest.raises(ValueError, match="unknown score 'retrun'"):
        LLFAdapter(student, score="retrun")


def test_the_pages_example(tmp_path, monkeypatch):
    """Of two problems to learn from, with the better arm in one place or another, advice is found that is no worse."""
    (code,) = [each for each in python_blocks().values() if each.startswith("# Needs the extra `gepa`")]
    (tmp_path / "example.py").write_text(code)
    mine = ModuleType("my_model")
    mine.ask, mine.reflect = student, lambda prompt: f"```\n{advice_from(prompt)}\n```"
    monkeypatch.setitem(sys.modules, "my_model", mine)
    result = runpy.run_path(f"{tmp_path / 'example.py'}")["result"]
    assert len(result.candidates) > 1
    assert result.candidates[1][ADVICE].startswith("pull arm")
    assert max(result.val_aggregate_scores) <= 0
