"""A model in the teacher's seat: what it is asked, how much it may answer, and its bad answers, which are counted."""

import json

import pytest
from commands import llf

from llf_teacher.models.testing import Reply, ScriptedEndpoint, completion
from llf_teacher.speakers.llm_teacher import LLMTeacher
from llf_teacher.studies import run
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.execution.runner import RunOptions
from llf_teacher.studies.report.data import read
from llf_teacher.studies.report.page import page
from llf_teacher.studies.report.parts.accounting import accounts
from llf_teacher.studies.store import Store

pytestmark = pytest.mark.usefixtures("no_settings")
GRID, BANDIT = "llf-gridworld-v0", "llf-bandits-BanditTenArmedGaussian-v0"
MCCORMICK = "llf-optimization-McCormick-v0"


def spec(url, **settings):
    return LLMTeacher("m", url, **{"answer": "json"} | settings)


def study(url, id=GRID, turns=1, seeds=1, **settings):
    return Study(ids=[id], teachers=[spec(url, **settings)], students=["random"], seeds=seeds, max_turns=turns)


def played(answer, id=GRID, turns=1, **settings):
    """The turns of a lesson after the opening, and the requests."""
    with ScriptedEndpoint(answer) as server:
        record = play(next(study(server.url, id, turns, **settings).episodes()))
    return record, server.requests


def cut(text):
    return lambda request: Reply(body=completion(text, request, finish="length"))


def shown(request):
    """The claims that a question shows."""
    return [json.loads(line) for line in request["messages"][-1]["content"].partition("True now:\n")[2].splitlines()]


def test_advice_is_shown_first_and_only_what_is_needed():
    """The schema says what can be said: the prompt has no list of it, no example and no past turn."""
    _, requests = played(lambda request: '{"claims": [{"type": "TryAgain"}]}', turns=3)
    assert [claim["type"] for claim in shown(requests[0])] == ["Go", "Avoid"]
    assert [claim["type"] for claim in shown(requests[1])][:2] == ["Go", "Avoid"]
    assert len(shown(requests[1])) > 2
    for request in requests:
        system, asked = request["messages"]
        assert "Avoid" not in system["content"]
        assert len((system["content"] + asked["content"]).split()) < 200
        claims = request["response_format"]["json_schema"]["schema"]["properties"]["claims"]
        assert claims["maxItems"] == 3
    _, (request, *_) = played(lambda request: "{}", knows="nothing")
    assert not shown(request)
    assert "Avoid(action" in request["messages"][0]["content"]


def test_numbers_that_are_shown_short_are_exact_when_said():
    def answer(request):
        return json.dumps({"claims": shown(request)})

    record, requests = played(answer, MCCORMICK, turns=3, most_claims=8)
    numbers = [value for claim in shown(requests[0]) for value in claim.values() if isinstance(value, float)]
    assert numbers
    assert all(len(f"{number}".strip("-").replace(".", "").strip("0")) <= 4 for number in numbers)
    row = record.episode
    assert (row.claims, row.unbuilt) == (row.claims_held, 0)
    assert row.said_fp == 3  # after the last turn there is no advice
    assert len({number for number in numbers if number not in (0.0, 1.0)}) > 2


def test_a_claim_is_said_once():
    claim = {"type": "TryAgain"}
    record, _ = played(lambda request: json.dumps({"claims": [claim] * 3}))
    assert [len([atom for atom in turn.atoms if atom["kind"]]) for turn in record.turns] == [0, 1]
    assert record.turns[0].unbuilt == 1, "before the first action there is only advice"


@pytest.mark.parametrize(
    ("answer", "settings", "faults", "feedback"),
    [
        (lambda request: json.dumps({"claims": shown(request)[:1]}), {}, [], True),
        (lambda request: '{"claims": []}', {}, ["empty"], False),
        (lambda request: "", {"says": "words"}, ["empty"], False),
        (lambda request: '{"claims": [{"type": "Reward", "reward": 0}, {"type": "TryAgain"}]}', {}, ["repeats"], True),
        (cut('{"claims": [{"type": "TryAgain'), {}, ["cut", "empty"], False),
        (lambda request: "Go north, I would say.", {}, ["empty"], False),
        (lambda request: '{"claims": {"type": "Warn"}}', {}, [], False),
        (cut("Go on. Try the other d"), {"says": "words"}, ["cut"], "Go on."),
        (cut("Try the other d"), {"says": "words"}, ["cut", "empty"], False),
        (lambda request: request["messages"][-1]["content"], {"says": "words"}, ["repeats"], True),
        (lambda request: "Now look for another door.", {"says": "words"}, [], "Now look for another door."),
        (lambda request: '{"claims": [{"type": "Fly"}]}', {}, [], False),
    ],
    ids=[
        "good",
        "none",
        "silent",
        "seen",
        "cut",
        "prose",
        "no list",
        "cut words",
        "all cut",
        "copied",
        "words",
        "unbuilt",
    ],
)
def test_bad_answers_are_counted(answer, settings, faults, feedback):
    record, _ = played(answer, turns=2, **settings)
    turn, row = record.turns[1], record.episode
    assert turn.reply["faults"] == faults
    assert turn.feedback == feedback if isinstance(feedback, str) else bool(turn.feedback) == feedback
    assert row.teacher_answers == 2 + (settings.get("says") != "words")
    counts = {"cut": row.teacher_cut, "empty": row.teacher_empty, "repeats": row.teacher_repeats}
    assert all(bool(count) == (name in faults) for name, count in counts.items())


def test_the_limit_is_that_of_the_schema_and_an_option_is_above_it():
    """Elsewhere a model may think first; on this machine the schema alone decides."""

    def limits(**settings):
        return [request.get("max_tokens") for request in played(lambda request: "{}", **settings)[1]]

    assert limits() == [1000, 1000]
    assert limits(max_tokens=50) == [50, 50]
    assert limits(max_tokens=None) == [None, None]
    assert min(limits(most_claims=32)) > 1000
    assert limits(says="words") == [1000]


@pytest.mark.parametrize("instruction_type", ["b", "p", "c"])
def test_advice_for_the_first_action_follows_the_whole_instruction(instruction_type):
    """The instruction is the oracle's, also where it tells of actions that were tried."""
    with ScriptedEndpoint(lambda request: json.dumps({"claims": shown(request)})) as server:
        own = spec(server.url, most_claims=32)
        types = {"instruction_types": [instruction_type], "ids": [GRID], "students": ["random"]}
        mine, oracle = (
            play(next(Study(teachers=[teacher], seeds=1, max_turns=1, **types).episodes()))
            for teacher in (own, "oracle")
        )
    assert [atom["claim"] for atom in mine.turns[0].atoms] == [atom["claim"] for atom in oracle.turns[0].atoms]
    assert mine.episode.claims_held == mine.episode.claims == oracle.episode.claims


@pytest.mark.parametrize("settings", [{"says": "words"}, {}])
def test_the_first_words_are_the_instruction_where_advice_is_not_heard(settings):
    lessons = {"ids": [GRID], "students": ["random"], "seeds": 1, "max_turns": 1, "feedback_types": ["r+hp+hn"]}
    with ScriptedEndpoint(lambda request: "{}") as server:
        record = play(next(Study(teachers=[spec(server.url, **settings)], **lessons).episodes()))
    assert record.turns[0].reply is None
    assert len(server.requests) == 1


def test_a_report_and_a_lesson_show_them(tmp_path):
    with ScriptedEndpoint(lambda request: '{"claims": [{"type": "TryAgain"}, {"type": "Fly"}]}') as server:
        lesson = study(server.url, BANDIT, turns=3, seeds=2)
        run(lesson, tmp_path / "s.db", options=RunOptions("here"))
        done = llf(
            *("play", BANDIT, "--student", "random", "--teacher", f"{spec(server.url)}"),
            *("--seed", "3", "--max-turns", "2"),
        )
    with Store(tmp_path / "s.db") as store:
        data = read(store, lesson)
        (account,) = accounts(data, "b", "a")
        html = page(data)
    assert account.model is not None
    assert account.model[:5] == (8, 0, 0, 6, 10)
    assert "its model gave 8 answers" in html
    assert "10 claims could not be made" in html
    assert done.returncode == 0, done.stderr
    said = " ".join(done.stdout.split())
    assert "teacher's model (repeating what the student sees, 1 claim could not be made): {" in said
    assert "The teacher's model gave 3 answers: 2 repeating what the student sees; 4 claims could not be made;" in said
