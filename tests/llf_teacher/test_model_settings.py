"""The settings of a model are checked in one place, for the student, the teacher and the voice that ask one."""

import pytest

from llf_teacher.models.model import ModelSettings
from llf_teacher.speakers.llm_teacher import LLMTeacher
from llf_teacher.speakers.rewriter import Rewriter
from llf_teacher.students.builtin.llm import LLM
from teachers.spec import parse_call

NAMES = ("MODEL", "BASE_URL", "API_KEY", "CACHE", "BUDGET", "ENDPOINT")


@pytest.fixture(autouse=True)
def _clean(monkeypatch):
    for name in NAMES:
        monkeypatch.delenv(f"LLF_LLM_{name}", raising=False)
        monkeypatch.delenv(f"OPENAI_{name}", raising=False)


@pytest.mark.parametrize("cls", [ModelSettings, LLM, LLMTeacher, Rewriter])
@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"model": ""}, "model must be the name of a model, got ''; or set LLF_LLM_MODEL"),
        ({"model": 3}, "model must be the name of a model, got 3"),
        ({"base_url": "localhost"}, "base_url must be an address such as http"),
        ({"base_url": "http://h/v1?key=1"}, "base_url must hold no user, password or query"),
        ({"base_url": "http://h:99999/v1"}, "base_url must be an address such as http"),
        ({"base_url": "http://user:pass/word@h/v1"}, "base_url must be an address such as http"),
        ({"base_url": "http://h/v1\n"}, "base_url must be an address such as http"),
        ({"endpoint": "no name"}, "endpoint must be a name of letters"),
        ({"base_url": "http://h/v1", "endpoint": "local"}, "give base_url or endpoint, not both"),
        ({"temperature": "hot"}, "temperature must be a number from 0 to 10, got 'hot'"),
        ({"max_tokens": 0}, "max_tokens must be an integer from 1 to 1000000, got 0"),
    ],
)
def test_every_spec_that_asks_a_model_has_the_same_checks(cls, given, message):
    with pytest.raises(ValueError, match=message):
        cls(**{"model": "m"} | given)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"prices": 1.0}, r"prices must be None, \(input, output\) or \(input, output, cached\), got 1\.0"),
        ({"prices": (1.0,)}, "prices must be None"),
        ({"prices": (1.0, -1.0)}, "output_price must be a number from 0 to 1000000, got -1"),
        ({"tone": 3}, "tone must be a text, got 3"),
    ],
)
def test_a_rewriter_checks_its_own(given, message):
    with pytest.raises(ValueError, match=message):
        Rewriter(model="m", **given)


def test_a_scheme_in_capitals_is_the_same_address():
    """As one of its own it had no warning that the key goes unencrypted, and passed this machine through a proxy."""
    assert ModelSettings(model="m", base_url="HTTP://Models.example/v1/").base_url == "http://Models.example/v1"


URL = "base_url='http://h/v1'"


@pytest.mark.parametrize(
    ("cls", "spec"),
    [
        (
            LLM,
            f"llm(model='m', {URL}, max_tokens=9, seed=False, history=3, input_price=1.0, images=2, extra={{'a': 1}})",
        ),
        (LLM, "llm(model='m', history=0, answer='json', cached_price=0.5, endpoint='local')"),
        (LLMTeacher, f"llm_teacher(model='m', {URL}, seed=False, history=3, knows='nothing', extra={{'a': [1]}})"),
        (Rewriter, f"rewriter(tone='a pirate', model='m', {URL}, max_tokens=9, prices=(1.0, 2.0))"),
        (Rewriter, "rewriter(model='m', temperature=None, endpoint='local')"),
    ],
)
def test_specs_keep_the_order_of_their_parameters(cls, spec):
    """Stores name episodes by these strings."""
    made = cls(**parse_call("spec", spec, "one").arguments)
    assert str(made) == spec
    assert made.settings.model == "m"


def test_the_settings_are_those_of_the_fields():
    common = {"model": "m", "base_url": "http://h/v1", "temperature": 1, "max_tokens": 7}
    priced = common | {"input_price": 1.0, "output_price": 2.0, "cached_price": 0.5}
    assert LLM(**priced, extra={"a": 1}).settings == ModelSettings(**priced, extra={"a": 1})
    assert LLMTeacher(**priced, seed=False).settings == ModelSettings(**priced, seed=False)
    assert Rewriter(**common, prices=(1.0, 2.0, 0.5)).settings == ModelSettings(**priced, seed=False)
    assert ModelSettings(**common | {"input_price": 1.0}).prices is None


@pytest.mark.parametrize(
    "spec", [LLM(model="m"), LLMTeacher(model="m"), Rewriter(model="m")], ids=["llm", "llm_teacher", "rewriter"]
)
def test_a_spec_is_checked_before_it_asks(spec, tmp_path):
    cache = {"LLF_LLM_CACHE": f"{tmp_path}/c.db"}
    spec.check(cache)
    with pytest.raises(ValueError, match=rf"a spending limit needs prices: add .* to .*{spec.name}\(model='m'"):
        spec.check(cache | {"LLF_LLM_BUDGET": "1"})
    with pytest.raises(ValueError, match="cannot keep answers of language models in /proc/none"):
        spec.check({"LLF_LLM_CACHE": "/proc/none/c.db"})
