"""Teachers of studies that are models, policies of one's own, or have voices."""

import json
import re
import sys

import pytest

from llf_teacher.episodes.record import unchecked
from llf_teacher.models.testing import ScriptedEndpoint
from llf_teacher.speakers.llm_teacher import LLMTeacher
from llf_teacher.speakers.parsing import parse_teacher
from llf_teacher.speakers.rewriter import Rewriter
from llf_teacher.speakers.speaker import CustomTeacher, Voiced
from llf_teacher.speakers.voice import Toned
from llf_teacher.students.chat import chat_student
from llf_teacher.studies import run
from llf_teacher.studies.definition.custom_specs import teacher_spec
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.execution.runner import RunOptions
from llf_teacher.studies.report.data import read
from llf_teacher.studies.report.page import page
from llf_teacher.studies.report.parts.accounting import accounts
from llf_teacher.studies.store import Store
from teachers.personalities.mistake import mistake

MODULE = '''
import asyncio


class Parrot:
    """Says the same each turn; the first words are the instruction."""

    def __init__(self, words="Try again! Or do not."):
        self.words = words

    def reset(self, rng):
        self.turn = 0

    def act(self, observation, info):
        self.turn += 1
        return "Find the treasure." if self.turn == 1 else self.words


def shy(words="Hm."):
    return Parrot(words)


def shout(sentence):
    return sentence.upper()


class Echo:
    def __init__(self, times=1):
        self.times = times

    def __call__(self, sentence):
        return " ".join([sentence] * self.times)


class Slow:
    """As an asynchronous client does it: the turns of an episode in one loop."""

    async def reset(self, rng):
        self.turns, self.loop = 0, asyncio.get_running_loop()

    async def act(self, observation, info):
        await asyncio.sleep(0)
        self.turns += 1
        assert self.loop is asyncio.get_running_loop()
        if self.turns > 1:
            return {"claims": [{"type": "Reward", "reward": 0.0}], "text": "You earned nothing."}
        return "Find the treasure."


class Deaf:
    def reset(self, rng):
        pass
'''
GRID = {"ids": ["llf-gridworld-v0"], "students": ["random"], "seeds": 1, "max_turns": 3}


@pytest.fixture(autouse=True)
def _mine(tmp_path, monkeypatch, no_settings):
    (tmp_path / "parrots.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    yield
    sys.modules.pop("parrots", None)


def told(teacher, **changes):
    """One episode with a teacher."""
    (spec,) = Study(teachers=[teacher], **(GRID | changes)).episodes()
    return play(spec)


def test_specs_stand_for_values_and_back():
    url = "http://localhost:1/v1"
    for spec, value in (
        ("parrots:Parrot(words='Hm.')", CustomTeacher("parrots", "Parrot", (("words", "Hm."),))),
        ("mistake(eps=0.5) | voice(tone='curt')", Voiced(mistake(eps=0.5), Toned("curt"))),
        (f"llm_teacher(model='m', base_url='{url}')", LLMTeacher("m", url)),
    ):
        assert parse_teacher(spec) == value
        assert teacher_spec(f" {spec} ") == teacher_spec(value) == spec
    rewriting = parse_teacher(f"oracle | rewriter(tone='a pirate', model='m', base_url='{url}')")
    assert rewriting.wording == Rewriter("a pirate", "m", url)
    import parrots

    assert teacher_spec(parrots.shy) == "parrots:shy"


@pytest.mark.parametrize(
    ("spec", "match"),
    [
        ("parrots:Deaf", "unknown personality in parrots 'Deaf'"),
        ("parrots:Parrot(word='x')", "teacher 'parrots:Parrot': unknown parameter 'word'; did you mean words"),
        ("oracle | parrots:shot", "unknown personality in parrots 'shot'"),
        ("llm_teacher(modle='m')", "unknown parameter 'modle'; did you mean model"),
        ("llm_teacher()", "model must be the name of a model"),
        ("llm_teacher(model='m', knows='all')", "unknown value of knows 'all'; allowed: claims, nothing"),
        ("oracle | llm_teacher(model='m')", "must stand alone, as in"),
        ("voice(tone='curt')", r"must stand behind a personality, as in `oracle \| voice"),
        ("oracle | voice(tone='crut')", "unknown voice 'crut'; did you mean curt"),
        ("llm_teacher(", "bad teacher spec"),
    ],
)
def test_what_is_none(spec, match):
    with pytest.raises(ValueError, match=match):
        Study(teachers=[spec], **GRID)


def test_what_a_policy_says_is_unchecked():
    record = told("parrots:Parrot")
    assert record.turns[0].instruction == "Find the treasure."
    assert [turn.feedback for turn in record.turns[1:]] == ["Try again! Or do not."] * 3
    assert [turn.unchecked for turn in record.turns] == [None, 2, 2, 2]
    assert (record.episode.unchecked, record.episode.claims) == (6, 0)
    assert told("oracle").episode.unchecked == 0
    quiet = told("parrots:shy", feedback_types=["n"])
    assert [turn.feedback for turn in quiet.turns] == [""] * 4
    assert quiet.turns[0].instruction == "Find the treasure."


def test_a_policy_may_be_asynchronous():
    told_claims = told("parrots:Slow")
    assert told_claims.turns[0].instruction == "Find the treasure."
    assert {turn.feedback for turn in told_claims.turns[1:]} == {"You earned nothing."}
    assert told_claims.episode.said_r == len(told_claims.turns) - 1
    silent = told("parrots:Slow", feedback_types=["n"])
    assert silent.turns[0].instruction == "Find the treasure."
    assert not any(turn.feedback for turn in silent.turns)


@pytest.mark.parametrize(
    ("said", "texts", "count"),
    [
        ("", [], 0),
        ("Go west. It is near!", [], 2),
        ("Go west. It is near!", ["Go west."], 1),
        ("One\nTwo\n\n- three", [], 3),
        ('"Stop!" he said. 3.5 is a number...', [], 3),
        ("...", [], 0),
    ],
)
def test_sentences_without_a_claim_are_counted(said, texts, count):
    assert unchecked(said, texts) == count


def test_a_voice_says_what_the_personality_says():
    plain = told("oracle")
    for spec in ("oracle | voice(tone='curt')", "oracle | parrots:shout", "oracle | parrots:Echo(times=2)"):
        record = told(spec)
        assert record.episode.claims == plain.episode.claims > 0
        assert record.episode.claims_held == record.episode.claims
        assert record.episode.unchecked == record.episode.changes == 0
        assert record.turns[1].feedback != plain.turns[1].feedback
    assert told("oracle | parrots:shout").turns[1].feedback == plain.turns[1].feedback.upper()


def rewrite(request):
    """Says `seven` for every number and puts an island into every second sentence."""
    sentence = request["messages"][-1]["content"]
    return re.sub(r"\d+", "seven", sentence) + (" Off to Tortuga!" if len(sentence) % 2 else "")


def test_a_rewriting_voices_changes_are_counted(tmp_path):
    with ScriptedEndpoint(rewrite) as server:
        spec = f"oracle | rewriter(tone='a pirate', model='m', base_url='{server.url}')"
        study = Study(teachers=[spec, "silent"], **GRID)
        results = run(study, tmp_path / "s.db", options=RunOptions("here"))
    assert study.named[spec] == "oracle | rewriter(m)"
    (row,) = (row for row in results.rows() if row["teacher"] == spec)
    texts = [atom["text"] for turn in results.turns(row["key"]) for atom in turn["atoms"] if atom["kind"]]
    assert row["changes"] == sum("Tortuga" in text or "seven" in text for text in texts) > 0
    assert row["claims"] == len(texts)
    with Store(results.path) as store:
        (account, _) = accounts(read(store, study), "b", "a")
    assert account.changes == row["changes"]
    assert account.unchecked == 0
    assert results.manifest["llm"][0]["requests"] == len(server.requests)


def teach(request):
    return "<think>West.</think>Go west now. You can do it."


@pytest.mark.parametrize("knows", ["claims", "nothing"])
def test_a_model_teaches(tmp_path, knows):
    """It is told the task, what was done and, if it may know, what is true; all it says is unchecked."""
    with ScriptedEndpoint(teach) as server:
        options = f"knows='{knows}', says='words', history=20, input_price=1.0, output_price=1.0"
        spec = f"llm_teacher(model='m', base_url='{server.url}', {options})"
        shown = [{"teacher": "llm_teacher*"}]
        study = Study(teachers=[spec, "oracle"], transcripts=shown, **(GRID | {"students": ["text_only"]}))
        assert study.named[study.teachers[0]] == "llm_teacher(m)"
        results = run(study, tmp_path / "s.db", options=RunOptions("here"))
        again = run(study, tmp_path / "again.db", options=RunOptions("here"))
    mine, others = sorted(results.rows(), key=lambda row: row["teacher"])
    turns = results.turns(mine["key"])
    assert turns[0]["instruction"] == results.turns(others["key"])[0]["instruction"]
    assert all(atom["holds"] for atom in turns[0]["atoms"])
    assert [turn["feedback"] for turn in turns[1:]] == ["Go west now. You can do it."] * (len(turns) - 1)
    assert mine["unchecked"] == 2 * (len(turns) - 1)
    first = server.requests[0]["messages"]
    assert turns[0]["instruction"] in first[0]["content"]
    assert ("True now" in first[1]["content"]) == (knows == "claims")
    assert "<think>" not in json.dumps([request["messages"] for request in server.requests])
    (spent,) = results.manifest["llm"]
    assert spent["requests"] == len(turns) - 1
    assert spent["usd"] > 0
    measured = {"regrets": 0, "teacher_seconds": 0}
    assert mine | measured == next(row | measured for row in again.rows() if row["teacher"] == mine["teacher"])
    with Store(results.path) as store:
        data = read(store, study)
        shares = {account.teacher: account.unchecked for account in accounts(data, "b", "a")}
        html = page(data)
    assert shares == {study.teachers[0]: 1.0, "oracle": 0.0}
    assert "<code>llm_teacher(m)</code>" in html
    assert "In words of its own, as they were read below:" in html
    assert "You teach a student that acts in a world." in html


def test_a_text_that_is_no_action_is_answered_without_the_model():
    with ScriptedEndpoint(teach) as server:
        spec = f"llm_teacher(model='m', base_url='{server.url}', says='words')"
        study = Study(teachers=[spec], **(GRID | {"students": [chat_student(lambda prompt: "hm")]}))
        record = play(next(study.episodes()))
    assert record.episode.parse_failures == 3
    assert not server.requests
    assert all("north, east" in turn.feedback or "direction" in turn.feedback for turn in record.turns[1:])


def test_a_limit_needs_prices_of_teachers_too(tmp_path, monkeypatch):
    monkeypatch.setenv("LLF_LLM_BUDGET", "1")
    for spec, whose in (("llm_teacher(model='m')", "llm_teacher"), ("oracle | rewriter(model='m')", "rewriter")):
        with pytest.raises(ValueError, match=f"a spending limit needs prices.*{whose}|{whose}.*limit needs prices"):
            run(Study(teachers=[spec], **GRID), tmp_path / "s.db", options=RunOptions("here"))


def test_lessons_have_them_too():
    study = Study(
        ids=["llf-gridworld-v0"],
        teachers=["oracle | voice(tone='curt')", "parrots:Parrot", "silent"],
        students=["obedient(forget=False)"],
        seeds=1,
        max_turns=3,
        transfer={"lessons": [1]},
    )
    records = [play(spec) for spec in study.episodes() if spec.lessons]
    assert len(records) == 3
    assert all(record.episode.unchecked == 0 for record in records)
