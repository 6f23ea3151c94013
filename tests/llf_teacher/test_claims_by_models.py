"""A model that composes claims: what it says is checked, whatever it answers."""

import hashlib
import json
import time

import pytest
from endpoints import ANSWERS, HUGE, KEY, LONG, files_with

from llf_teacher.episodes.record import READINGS
from llf_teacher.models import LLMError
from llf_teacher.models.testing import ScriptedEndpoint, refusal
from llf_teacher.speakers.llm_teacher import LLMTeacher
from llf_teacher.studies import run
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.execution.runner import RunOptions
from llf_teacher.tools.audit import audit
from teachers.atoms import Label

pytestmark = pytest.mark.usefixtures("no_settings")
GRID, BANDIT = "llf-gridworld-v0", "llf-bandits-BanditTenArmedGaussian-v0"
LIE = "Believe me."


def shown(request):
    """The claims that a question shows."""
    return [json.loads(line) for line in request["messages"][-1]["content"].partition("True now:\n")[2].splitlines()]


class Liar:
    """Says what is true by what it is told; in every tenth answer, by a hash, it advises what it should warn of."""

    def __init__(self):
        self.lies = 0

    def __call__(self, request):
        true = shown(request)
        advice = next((claim for claim in true if claim["type"] in ("Go", "Pull")), None)
        warning = next((claim for claim in true if claim["type"] == "Avoid"), None)
        if advice and warning and hashlib.sha256(json.dumps(request).encode()).digest()[0] < 26:
            self.lies += 1
            return json.dumps({"claims": [{**advice, "action": warning["action"]}], "text": LIE})
        return "Here you are:\n" + json.dumps({"claims": true})


def spec(url, **settings):
    settings = {"answer": "json", "history": 20, "says": "claims" if settings.get("filter") else "both"} | settings
    return str(LLMTeacher("m", url, input_price=1.0, output_price=1.0, **settings))


def played(path, teacher, **changes):
    study = Study(**({"ids": [GRID, BANDIT], "teachers": [teacher], "students": ["random"], "seeds": 8} | changes))
    return run(study, path, options=RunOptions("here"))


def turns_of(results):
    return [turn for row in results.rows() for turn in results.turns(row["key"])]


def test_a_study_finds_the_lies_of_a_model_and_no_others(tmp_path):
    liar = Liar()
    with ScriptedEndpoint(liar) as server:
        results = played(tmp_path / "s.db", spec(server.url), max_turns=12, seeds=5)
    atoms = [atom for turn in turns_of(results) for atom in turn["atoms"] if atom["kind"]]
    assert sum(row["distorted"] for row in results.rows()) == liar.lies > 5
    later = [atom for turn in turns_of(results) for atom in turn["atoms"] if turn["turn"]]
    assert [atom["label"] == "distorted" for atom in later] == [not atom["text"] for atom in later]
    first = sum(atom["label"] == "distorted" for atom in atoms) - sum(atom["label"] == "distorted" for atom in later)
    assert 0.04 < liar.lies / len(server.requests) < 0.2  # equal requests are answered alike
    assert sum(row["unchecked"] for row in results.rows()) == liar.lies - first, "its own words"
    assert not any(turn["unbuilt"] or turn["withheld"] for turn in turns_of(results))
    form = server.requests[0]["response_format"]["json_schema"]["schema"]
    assert form["properties"]["claims"]["items"]["anyOf"]
    assert "Go(action" not in server.requests[0]["messages"][0]["content"], "the claims shown and the schema say it"


def test_an_audit_finds_them_too():
    liar = Liar()
    with ScriptedEndpoint(liar) as server:
        teacher = LLMTeacher("m", server.url, says="both", answer="json", history=20).arguments()["teacher"]
        found = audit(GRID, teacher, turns=100, students=["random"], instruction_types=["b"], max_turns=10)
    assert found.count(Label.DISTORTED) == liar.lies > 3
    assert found.caught
    assert {example.text for example in found.examples if example.turn} == {""}


@pytest.mark.parametrize("claims", [True, False])
@pytest.mark.parametrize("filter", [False, True])
def test_false_words_beside_true_claims_are_read_or_not_said(tmp_path, claims, filter):
    """A filter lets nothing pass that is not checked."""

    def answer(request):
        true = shown(request)
        advice = [claim for claim in true if claim["type"] == "Go"]
        warnings = [claim["action"] for claim in true if claim["type"] == "Avoid"]
        text = f"Go {warnings[0]} next." if warnings else ""
        return json.dumps({"claims": advice if claims else [], "text": text})

    with ScriptedEndpoint(answer) as server:
        results = played(tmp_path / "s.db", spec(server.url, filter=filter), ids=[GRID], seeds=2, max_turns=6)
    sums = {name: sum(row[name] or 0 for row in results.rows()) for name in ("claims", "claims_held", *READINGS)}
    assert sums["claims"] == sums["claims_held"]
    assert bool(sums["claims"]) is claims
    false = [each for turn in turns_of(results) for each in turn["readings"] or ()]
    assert all(each["holds"] is False for each in false)
    assert sums["read_exact"] == sums["read_false"] == len(false)
    assert bool(false) is not filter
    assert sum(row["unchecked"] for row in results.rows()) == len(false)


@pytest.mark.full
def test_a_filter_withholds_the_lies_and_nothing_else(tmp_path):
    liar = Liar()
    with ScriptedEndpoint(liar) as server:
        results = played(tmp_path / "s.db", spec(server.url, filter=True), ids=[GRID], max_turns=15, seeds=12)
    turns = turns_of(results)
    assert sum(turn["withheld"] or 0 for turn in turns) == liar.lies > 3
    assert not any(LIE in turn["feedback"] for turn in turns)
    assert {atom["label"] for turn in turns for atom in turn["atoms"]} == {"truthful"}
    assert sum(not turn["feedback"] for turn in turns) == liar.lies


@pytest.mark.parametrize("filter", [False, True])
def test_a_hostile_model_is_counted_and_plays_to_the_end(tmp_path, monkeypatch, filter):
    monkeypatch.setenv("LLF_LLM_API_KEY", KEY)
    answers = iter(ANSWERS.values())
    with ScriptedEndpoint(lambda request: next(answers, "{}")) as server:
        results = played(tmp_path / "s.db", spec(server.url, filter=filter), ids=[GRID], seeds=30, max_turns=1)
    assert len(server.requests) > len(ANSWERS)
    turns = turns_of(results)
    assert len(turns) == len(server.requests)
    no_json = ("words", "nothing", "deep", "twice", "long number")
    assert [turn["reply"]["faults"] for turn in turns[: len(ANSWERS)]] == [
        ["empty"] if name in no_json else [] for name in ANSWERS
    ]
    assert sum(turn["unbuilt"] or 0 for turn in turns) == len(ANSWERS) - len(no_json)
    said = [atom["fields"].get("room") for turn in turns for atom in turn["atoms"] if atom["kind"]]
    assert said == ([] if filter else ["***"])
    assert not files_with(KEY, tmp_path)


def test_huge_answers_take_bounded_time_and_memory(tmp_path):
    """Each of more than a megabyte, but for sentences; they are counted, cut in records, and sent back in part."""
    answers = iter(HUGE.values())
    with ScriptedEndpoint(lambda request: next(answers, "{}")) as server:
        began = time.process_time()
        results = played(tmp_path / "s.db", spec(server.url), ids=[BANDIT], seeds=1, max_turns=len(HUGE))
        seconds = time.process_time() - began
    turns = turns_of(results)
    assert len(turns) == len(server.requests) == len(HUGE) + 1
    assert all(turn["unbuilt"] or "empty" in turn["reply"]["faults"] for turn in turns[:3] + turns[5:9])
    assert len(json.dumps(server.requests[-1])) < 200_000, "nine answers of 1.5 MB came before"
    assert sum(len(turn["feedback"]) for turn in turns) < 100_000
    assert seconds < 20


def test_a_student_sends_back_nothing_of_a_huge_answer_that_is_no_action():
    with ScriptedEndpoint(lambda request: "Response: " * (LONG // 10)) as server:
        student = f"llm(model='m', base_url='{server.url}', answer='text')"
        record = play(next(Study(ids=[GRID], teachers=["oracle"], students=[student], seeds=1, max_turns=3).episodes()))
    assert [len(json.dumps(request)) // 20_000 for request in server.requests] == [0, 0, 0]
    assert (record.episode.parse_failures, record.episode.truncated) == (3, 3)
    assert len(record.turns[1].answer) <= 1_000_000


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        ({"says": "nothing"}, "unknown value of says 'nothing'; allowed: claims, both, words"),
        ({"says": "words", "filter": True}, "filter must be False, or True with says='claims', got True"),
        ({"most_claims": 0}, "most_claims must be"),
        ({"most_claims": 33}, "most_claims must be"),
        ({"answer": "xml"}, "answer must be one of auto, json, tool, text, got 'xml'"),
        ({"says": "claims", "filter": 1}, "filter must be False, or True with says='claims', got 1"),
    ],
)
def test_what_is_not_allowed(settings, match):
    with pytest.raises(ValueError, match=match):
        LLMTeacher("m", "http://localhost:1/v1", **settings)


def test_an_endpoint_without_json_schemas_is_asked_by_the_prompt(tmp_path):
    def picky(request):
        return refusal("response_format") if "response_format" in request else '{"claims": []}'

    with ScriptedEndpoint(picky) as server:
        with pytest.raises(LLMError, match="give another answer, such as answer='text'"):
            play(next(Study(ids=[GRID], teachers=[spec(server.url)], students=["random"], seeds=1).episodes()))
        results = played(tmp_path / "s.db", spec(server.url, answer="text"), ids=[GRID], seeds=1, max_turns=2)
    assert not any(turn["unbuilt"] for turn in turns_of(results))


def test_the_manifest_has_the_prompt_of_claims():
    plain, composing = (LLMTeacher("m", "http://localhost:1/v1", says=says).facts() for says in ("words", "claims"))
    assert "JSON" in composing["prompts"]["system"]["text"]
    assert "JSON" not in plain["prompts"]["system"]["text"]
