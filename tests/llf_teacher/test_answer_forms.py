"""`answer='auto'`: the first form that an endpoint keeps, found out once, kept in the cache and shown."""

import json

import pytest

from llf_teacher.models import LLMError
from llf_teacher.models.forms import AUTO
from llf_teacher.models.model import Model, ModelSettings
from llf_teacher.models.testing import Reply, ScriptedEndpoint, completion
from llf_teacher.speakers.llm_teacher import LLMTeacher
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies import Study, run
from llf_teacher.studies.analysis.costs import cost_lines
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.execution.runner import RunOptions
from llf_teacher.studies.store import Store

GRID = "llf-gridworld-v0"
SAMPLE = {"word": "ampere", "number": "-2.75"}


@pytest.fixture(autouse=True)
def _no_settings(monkeypatch):
    for name in ("MODEL", "BASE_URL", "API_KEY", "CACHE", "BUDGET", "TIMEOUT", "RETRIES"):
        monkeypatch.delenv(f"LLF_LLM_{name}", raising=False)
        monkeypatch.delenv(f"OPENAI_{name}", raising=False)


def asked_form(request):
    return "json" if "response_format" in request else "tool" if "tools" in request else "text"


def is_trial(request):
    return "Say hello." in json.dumps(request["messages"])


def model(*kept, otherwise="hello"):
    """Stands for a model behind an endpoint that keeps these forms; `otherwise` is what it says in others."""

    def answer(request):
        form = asked_form(request)
        if form == "text":
            return "Response: west"
        if form not in kept:
            return otherwise
        said = json.dumps(SAMPLE if is_trial(request) else {"thought": "so", "action": "west"})
        if form == "json":
            return said
        calls = [{"id": "c0", "type": "function", "function": {"name": "act", "arguments": said}}]
        return Reply(body=completion(None, request, tool_calls=calls))

    return answer


def study(url, options="", **changes):
    students = [f"llm(model='m', base_url='{url}'{options})"]
    return Study(
        **({"ids": [GRID], "teachers": ["oracle"], "students": students, "seeds": 1, "max_turns": 2} | changes)
    )


def first(url, options=""):
    return play(next(study(url, options).episodes()))


@pytest.mark.parametrize(
    ("kept", "form", "trials"),
    [
        (("json", "tool"), "json", ["json"]),
        (("tool",), "tool", ["json", "tool"]),
        ((), "text", ["json", "tool"]),
    ],
)
@pytest.mark.parametrize("otherwise", ["hello", '{"word": "candela", "number": "-2.75"}', '{"word": ', "[]"])
def test_the_first_form_that_is_kept_is_used(kept, form, trials, otherwise):
    with ScriptedEndpoint(model(*kept, otherwise=otherwise)) as server:
        record = first(server.url)
    assert [asked_form(request) for request in server.requests if is_trial(request)] == trials
    assert {asked_form(request) for request in server.requests if not is_trial(request)} == {form}
    assert [turn.form for turn in record.turns] == [None, form, form]
    assert {turn.action for turn in record.turns[1:]} == {"2"}


def test_a_schema_that_is_refused_or_cut_is_not_kept():
    refused = Reply(400, json.dumps({"error": {"message": "response_format is not supported"}}))

    def answer(request):
        form = asked_form(request)
        if form == "tool":
            return Reply(body=completion("hm " * 9, request, finish="length"))
        return refused if form == "json" else "Response: west"

    with ScriptedEndpoint(answer) as server:
        form = Model(ModelSettings(model="m", base_url=server.url)).form(AUTO)
    assert form.name == "text"
    assert "json was refused: BadRequestError" in form.why
    assert "tool was cut at its greatest length" in form.why


def test_an_endpoint_that_is_not_there_is_no_reason_to_ask_in_words(monkeypatch, tmp_path):
    monkeypatch.setenv("LLF_LLM_RETRIES", "0")
    monkeypatch.setenv("LLF_LLM_CACHE", str(tmp_path / "c.db"))
    with ScriptedEndpoint(lambda request: Reply(503, "later")) as server, pytest.raises(LLMError, match="503"):
        first(server.url)
    with ScriptedEndpoint(model("json")) as server:
        assert first(server.url).turns[1].form == "json"


def test_it_is_tried_once_and_stays(monkeypatch, tmp_path):
    """A study that goes on asks in the same form, also where the endpoint could do more by now."""
    monkeypatch.setenv("LLF_LLM_CACHE", str(tmp_path / "c.db"))
    keeps = []
    with ScriptedEndpoint(lambda request: model(*keeps)(request)) as server:
        before = [play(episode).turns[1].form for episode in study(server.url, seeds=3).episodes()]
        keeps.append("json")
        after = [play(episode).turns[1].form for episode in study(server.url, seeds=[8, 9]).episodes()]
    assert before + after == ["text"] * 5
    assert len([request for request in server.requests if is_trial(request)]) == 2


def test_a_form_that_is_chosen_is_not_tried():
    with ScriptedEndpoint(model("json")) as server:
        assert first(server.url, ", answer='text'").turns[1].form == "text"
        assert first(server.url, ", answer='json'").turns[1].form == "json"
    assert not any(map(is_trial, server.requests))


def test_answers_of_one_form_are_not_those_of_another(monkeypatch, tmp_path):
    """The cache's key is the whole request, so that a spec with `auto` never reads what was answered in words."""
    monkeypatch.setenv("LLF_LLM_CACHE", str(tmp_path / "c.db"))
    with ScriptedEndpoint(model("json")) as server:
        words, auto = first(server.url, ", answer='text'"), first(server.url)
        again = first(server.url, ", answer='json'")
    assert words.turns[1].answer == "Response: west"
    assert json.loads(auto.turns[1].answer)["action"] == "west"
    assert again.turns == auto.turns, "the same requests as those of `auto`"
    assert len(server.requests) == 1 + 2 + 2


def test_the_form_and_its_reason_are_shown(tmp_path):
    with ScriptedEndpoint(model()) as server:
        run(study(server.url), tmp_path / "s.db", options=RunOptions("here"))
    with Store(tmp_path / "s.db") as store:
        (spent,) = store.manifest()["llm"]
        lines = list(cost_lines(store))
    assert spent["form"].startswith("text (json did not keep the schema: 'hello'; tool called no tool")
    assert f"m: asked for answers as {spent['form']}" in lines


def test_the_teachers_seat_shares_the_choice():
    def answer(request):
        return json.dumps(SAMPLE if is_trial(request) else {"claims": [{"type": "Go", "action": "north"}]})

    with ScriptedEndpoint(answer) as server:
        teacher = LLMTeacher("m", server.url, says="claims")
        record = play(next(study("http://unused/v1", teachers=[teacher], students=["random"]).episodes()))
    assert [asked_form(request) for request in server.requests] == ["json"] * 4
    assert [is_trial(request) for request in server.requests] == [True, False, False, False]
    assert {atom["claim"] for turn in record.turns[1:] for atom in turn.atoms} >= {"gridworld.Go"}


@pytest.mark.parametrize(
    ("id", "options", "most"),
    [
        (GRID, "", 1000),
        (GRID, ", max_tokens=50", 50),
        (GRID, ", max_tokens=None", None),
        ("llf-poem-Haiku-v0", "", 1000),
    ],
)
def test_other_endpoints_may_think_before_they_answer(id, options, most):
    with ScriptedEndpoint(model("json")) as server:
        play(next(study(server.url, options, ids=[id]).episodes()))
    assert server.requests[-1].get("max_tokens") == most


def test_a_limit_that_is_none():
    with pytest.raises(ValueError, match="max_tokens"):
        parse_student("llm(model='m', max_tokens='some')")
