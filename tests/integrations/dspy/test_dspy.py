"""DSPy's GEPA improves a program by what the teacher says, with scripted models."""

import json
import runpy
import sys
from types import ModuleType

import dspy
import pytest
from advice import BANDIT, advice_from, advised
from documents import python_blocks
from dspy import lm15

from llf_teacher.integrations.dialogue import SCORES, Dialogue
from llf_teacher.integrations.dspy import LLFProgram, examples, feedback_metric


class Scripted:
    """An engine of DSPy's: what answers, where a model would."""

    def __init__(self, say):
        self.say, self.asked = say, []

    def complete(self, request):
        self.asked.append(request)
        return lm15.Response(
            id=None,
            model="scripted",
            message=lm15.Message.assistant([lm15.TextPart(self.say(request))]),
            finish_reason="stop",
            usage=lm15.Usage(input_tokens=0, output_tokens=0, total_tokens=0),
        )


def model(engine):
    return dspy.LM("scripted", engine=engine, cache=False)


def answer(text):
    return f"[[ ## answer ## ]]\n{text}\n\n[[ ## completed ## ]]"


def student(request):
    return answer(advised(request.system.rpartition("your objective is")[2]))


def reflect(request):
    return json.dumps({"new_instruction": advice_from(request.messages[-1].text)})


@pytest.fixture
def played():
    """Plays an episode with what answers."""

    def play(say, seed=0, **settings):
        engine = Scripted(say)
        with dspy.context(lm=model(engine)):
            return LLFProgram(**settings)(id=BANDIT, seed=seed).played, engine.asked

    return play


def test_a_program_is_improved_by_what_is_said(played, tmp_path):
    """What the teacher names is the better arm."""
    seed = next(seed for seed in range(20) if played(student, seed, max_turns=1)[0].scores["regret"] > 0)
    reflecting = Scripted(reflect)
    with dspy.context(lm=model(Scripted(student))):
        program = dspy.GEPA(
            feedback_metric("regret"),
            max_metric_calls=6,
            reflection_lm=model(reflecting),
            reflection_minibatch_size=1,
            perfect_score=0.0,
            num_threads=1,
            track_stats=True,
            log_dir=f"{tmp_path}",
        ).compile(LLFProgram(feedback_type="fp", max_turns=3), trainset=examples([(BANDIT, seed)]))
    assert program.respond.signature.instructions.startswith("pull arm")
    first, *_, last = program.detailed_results.val_aggregate_scores
    assert first < last == 0
    asked = reflecting.asked[0].messages[-1].text
    assert "Turn 3. Student: 1. " in asked
    assert LLFProgram().respond.signature.instructions in asked


def test_an_episode_is_as_elsewhere(played):
    """The model sees the task and all turns; of the same seed and answers the same is said."""
    here, asked = played(student, 1, max_turns=3)
    dialogue = Dialogue(BANDIT, 1, max_turns=3)
    while not dialogue.over:
        system, *rest = dialogue.messages
        request = asked.pop(0)
        seen = [message.text for message in request.messages]
        assert system["content"].strip() in seen[-1]
        assert all(message["content"].strip() in text for message, text in zip(rest, seen, strict=True))
        dialogue.answer(advised(""))
        dialogue.speak()
    dialogue.close()
    assert not asked
    assert here.turns == dialogue.record()
    assert here.scores == dialogue.scores()
    assert tuple(here.scores) == tuple(SCORES)


def test_an_answer_that_cannot_be_read_is_the_environments_to_judge(played):
    here, _ = played(lambda request: "what?", max_turns=2)
    assert here.scores["parse_failures"] == here.scores["turns"] == 2
    here, _ = played(lambda request: "Response: 0", max_turns=2)
    assert [turn["action"] for turn in here.turns[1:]] == ["0", "0"]


def test_a_program_is_judged_in_threads(played):
    games = [(BANDIT, seed) for seed in range(4)]
    with dspy.context(lm=model(Scripted(student))):
        judged = dspy.Evaluate(devset=examples(games), metric=feedback_metric(), num_threads=2)(LLFProgram(max_turns=2))
    for (_, seed), (_, pred, said) in zip(games, judged.results, strict=True):
        assert pred.played == played(student, seed, max_turns=2)[0]
        assert said.score == pred.played.scores["return"]
        assert all(turn["feedback"] in said.feedback for turn in pred.played.turns)


def test_the_score_must_be_one():
    with pytest.raises(ValueError, match="unknown score 'retrun'"):
        feedback_metric("retrun")


def test_the_pages_example(tmp_path, monkeypatch):
    (code,) = [each for each in python_blocks().values() if each.startswith("# Needs the extra `dspy`")]
    (tmp_path / "example.py").write_text(code)
    mine = ModuleType("my_model")
    mine.student, mine.reflection = model(Scripted(student)), model(reflecting := Scripted(reflect))
    monkeypatch.setitem(sys.modules, "my_model", mine)
    try:
        program = runpy.run_path(f"{tmp_path / 'example.py'}")["program"]
    finally:
        dspy.configure(lm=None)
    assert reflecting.asked
    assert isinstance(program, LLFProgram)
