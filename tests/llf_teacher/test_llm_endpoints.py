"""Endpoints by name: another address is the same endpoint, another model under an old name is not the same model."""

import pytest

from llf_teacher.models import LLMError
from llf_teacher.models.endpoints import place_of
from llf_teacher.models.settings import ClientSettings
from llf_teacher.models.testing import Reply, ScriptedEndpoint, completion
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play


@pytest.fixture(autouse=True)
def _no_settings(monkeypatch, tmp_path):
    for name in ("MODEL", "BASE_URL", "API_KEY", "BUDGET", "TIMEOUT", "RETRIES", "ENDPOINT", "ENDPOINTS"):
        monkeypatch.delenv(f"LLF_LLM_{name}", raising=False)
        monkeypatch.delenv(f"OPENAI_{name}", raising=False)
    monkeypatch.setenv("LLF_LLM_CACHE", str(tmp_path / "c.db"))
    monkeypatch.chdir(tmp_path)


def record():
    student = "llm(model='m', answer='text', endpoint='local')"
    study = Study(ids=["llf-gridworld-v0"], teachers=["oracle"], students=[student], seeds=1, max_turns=2)
    assert study.students == (student,)
    return play(next(study.episodes()))


def serve(said="Response: north", root="/weights/a", answers_as="m"):
    return ScriptedEndpoint(
        lambda request: Reply(body=completion(said, {"model": answers_as, "messages": []})),
        ({"id": "m", "root": root},) if root else (),
    )


def test_another_address_replays_what_is_paid(monkeypatch):
    with serve() as one:
        monkeypatch.setenv("LLF_LLM_ENDPOINT_LOCAL", one.url)
        first = record()
    with serve("Response: west") as other:
        monkeypatch.setenv("LLF_LLM_ENDPOINT_LOCAL", other.url)
        assert record() == first
    assert (len(one.requests), len(other.requests)) == (2, 0)
    assert record() == first, "nobody is there any more"


def test_another_model_under_the_name_does_not(monkeypatch):
    with serve() as one, serve("Response: west", root="/weights/b") as other:
        monkeypatch.setenv("LLF_LLM_ENDPOINT_LOCAL", one.url)
        assert record().turns[1].action == "0"
        monkeypatch.setenv("LLF_LLM_ENDPOINT_LOCAL", other.url)
        assert record().turns[1].action == "2"
    assert (len(one.requests), len(other.requests)) == (2, 2)


def test_another_model_that_only_its_answers_show_is_an_error(monkeypatch):
    with serve(root="", answers_as="m-2025") as one, serve("Response: west", root="", answers_as="m-2026") as other:
        monkeypatch.setenv("LLF_LLM_ENDPOINT_LOCAL", one.url)
        record()
        monkeypatch.setenv("LLF_LLM_ENDPOINT_LOCAL", other.url)
        student = "llm(model='m', answer='text', endpoint='local')"
        study = Study(ids=["llf-gridworld-v0"], teachers=["oracle"], students=[student], seeds=[5], max_turns=2)
        with pytest.raises(LLMError, match=r"answers as 'm-2026' now, and did so as 'm-2025' .* another name"):
            play(next(study.episodes()))


def test_places_are_in_a_file(tmp_path):
    (tmp_path / "llf-endpoints.toml").write_text(
        '[endpoints.local]\nbase_url = "http://h:1/v1/"\n[endpoints.far]\nbase_url = "https://f/v1"\nkey = "FAR_KEY"\n'
    )
    assert place_of("local").base_url == "http://h:1/v1"
    far = place_of("far")
    surroundings = {"FAR_KEY": "sk-far", "LLF_LLM_API_KEY": "sk-ours"}
    assert ClientSettings.read(far.base_url, surroundings, far.key).key == "sk-far"
    assert place_of("local", {"LLF_LLM_ENDPOINT_LOCAL": "http://other/v1"}).base_url == "http://other/v1"
    (tmp_path / "mine.toml").write_text('[endpoints.local]\nbase_url = "http://mine/v1"\n')
    assert place_of("local", {"LLF_LLM_ENDPOINTS": "mine.toml"}).base_url == "http://mine/v1"


@pytest.mark.parametrize(
    ("text", "match"),
    [
        (None, r"the endpoint 'local' has no address: set LLF_LLM_ENDPOINT_LOCAL, or write llf-endpoints\.toml"),
        ("[endpoints.locale]\nbase_url='http://h/v1'", "endpoint.*'local'.*locale"),
        ("[endpoints.local]\nurl='http://h/v1'", "key 'url'.*base_url"),
        ("[endpoints.local]\nbase_url='h'", r"endpoints\.local\.base_url must be an address"),
        ("[endpoints", "llf-endpoints"),
        ("endpoints = 3", "unknown|local"),
    ],
)
def test_places_that_are_none(tmp_path, text, match):
    if text is not None:
        (tmp_path / "llf-endpoints.toml").write_text(text)
    with pytest.raises(ValueError, match=match):
        parse_student("llm(model='m', endpoint='local')").check({})


def test_a_name_is_a_name_and_stands_alone(monkeypatch):
    with pytest.raises(ValueError, match="endpoint must be a name"):
        parse_student("llm(model='m', endpoint='http://h/v1')")
    with pytest.raises(ValueError, match="give base_url or endpoint, not both"):
        parse_student("llm(model='m', endpoint='local', base_url='http://h/v1')")
    monkeypatch.setenv("LLF_LLM_ENDPOINT", "local")
    assert str(parse_student("llm(model='m')")) == "llm(model='m', endpoint='local')"
