"""GEPA improves a prompt by what the teacher says, with scripted models."""

import re

import gepa
import pytest

from llf_teacher.integrations.dialogue import SCORES
from llf_teacher.integrations.gepa import ADVICE, Game, LLFAdapter

BANDIT = "llf-bandits-BanditTwoArmedHighLowFixed-v0"


def student(messages):
    """Stands for a model: it pulls the arm that its advice names, else arm 1."""
    advised = re.findall(r"pull arm (\d)", messages[0]["content"].rpartition("\n\n")[2])
    return f"Response: {advised[-1] if advised else 1}"


def reflect(prompt):
    """Stands for the model that reflects: it reads which rewards were told, and writes down the arm of the greater."""
    turns = re.findall(r"Student: (\d)\. Reward: (\S+)\. ", prompt)
    good = [arm for arm, reward in turns if float(reward) > 0.5]
    told = set(re.findall(r"(?i)arm (\d)", " ".join(re.findall(r"Teacher: (.*)", prompt))))
    other = sorted(told - {arm for arm, _ in turns})
    return f"```\npull arm {(other or good)[0]}\n```"


def test_a_prompt_is_improved_by_what_is_said(tmp_path):
    """The arms' order is drawn at reset, so one seed is one problem: what the teacher names is the better arm."""
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
        return reflect(prompt)

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
