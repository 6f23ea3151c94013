"""The language-model student, with the real client, over HTTP, against an endpoint on this computer."""

import itertools
import json
import os
import subprocess
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from design import amount
from endpoints import KEY, NORTH, REQUEST, endpoint, ledger

from llf_teacher.models import LLMError, SpendingLimitError, retries
from llf_teacher.models.cache import Cache, spending
from llf_teacher.models.proxies import reach_proxy
from llf_teacher.models.retries import asked_for, may_pass, pause
from llf_teacher.models.settings import ClientSettings
from llf_teacher.models.testing import Reply, ScriptedEndpoint, completion
from llf_teacher.students.builtin.llm import LLM
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.execution.runner import manifest, play_missing
from llf_teacher.studies.store import Store

pytestmark = pytest.mark.usefixtures("no_settings")


NOTHING = {"model": "m", "requests": 0, "input_tokens": 0, "output_tokens": 0, "usd": 0.0, "unpriced": 0}


def llm(url, options=""):
    """The spec of a model that answers in words, unless the options say otherwise."""
    form = "" if "answer=" in options else ", answer='text'"
    return f"llm(model='m', base_url='{url}'{form}{options})"


def study(url, options="", **changes):
    settings = {"ids": ["llf-gridworld-v0"], "teachers": ["oracle"], "seeds": 1, "max_turns": 4}
    return Study(students=[llm(url, options)], **(settings | changes))


def test_an_answer_is_paid_once(tmp_path):
    with ScriptedEndpoint(lambda request: NORTH) as server:
        for _ in range(2):
            asked = endpoint(server.url, tmp_path / "c.db")
            assert asked.ask(REQUEST, (1.0, 10.0)) == NORTH
            assert asked.ask(REQUEST, (1.0, 10.0)) == NORTH
    assert len(server.requests) == 1
    assert server.requests == [REQUEST]
    assert server.keys == [f"Bearer {KEY}"]
    assert ledger(tmp_path / "c.db") == [(3, 6, pytest.approx(63e-6))]


def test_no_two_scripted_endpoints_have_one_address():
    """Else an answer that is kept by address came from an earlier endpoint, when the system gives a port again."""
    with ScriptedEndpoint(lambda request: NORTH) as one, ScriptedEndpoint(lambda request: NORTH) as other:
        assert urlsplit(one.url).path != urlsplit(other.url).path


def test_the_key_of_the_cache_is_all_of_the_request_and_not_the_secret(tmp_path):
    with ScriptedEndpoint(lambda request: NORTH) as one, ScriptedEndpoint(lambda request: NORTH) as other:
        cache = tmp_path / "c.db"
        for url in (one.url, other.url):
            for change in ({}, {"model": "n"}, {"seed": 1}, {"temperature": 0.5}, {"max_tokens": 9}):
                endpoint(url, cache).ask(REQUEST | change)
        endpoint(one.url, cache, key="sk-another-secret").ask(REQUEST)
    assert len(one.requests) == len(other.requests) == 5


FAULTS = {
    "429": Reply(429, '{"error": {"message": "slow down"}}', (("Retry-After", "0.2"),)),
    "500": Reply(500, "oops"),
    "cut": Reply(200, completion(NORTH), cut=True),
    "half a JSON": Reply(200, completion(NORTH)[:40]),
    "no JSON": Reply(200, "<html>busy</html>"),
    "no choices": Reply(200, '{"choices": []}'),
    "null choices": Reply(200, '{"choices": null, "usage": null}'),
    "a list": Reply(200, "[1]"),
    "no message": Reply(200, '{"choices": [{"message": null}]}'),
    "a number": Reply(200, '{"choices": [{"message": {"content": 3}}]}'),
}


@pytest.fixture
def soon(monkeypatch):
    """It is tried again at once, where it does not matter how long that should take."""
    monkeypatch.setattr(retries, "_FIRST", 0.01)


@pytest.mark.usefixtures("soon")
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_that_passes_is_got_over(fault):
    replies = iter([FAULTS[fault], NORTH])
    with ScriptedEndpoint(lambda request: next(replies)) as server:
        assert endpoint(server.url).ask(REQUEST) == NORTH
    assert len(server.requests) == 2


@pytest.mark.usefixtures("soon")
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_that_stays_is_one_error(fault):
    with ScriptedEndpoint(lambda request: FAULTS[fault]) as server, pytest.raises(LLMError) as caught:
        endpoint(server.url, retries=1).ask(REQUEST)
    assert len(server.requests) == 2
    assert server.url in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.usefixtures("soon")
def test_retry_after_is_honoured():
    times = []

    def answer(request):
        times.append(time.monotonic())
        return NORTH if len(times) == 3 else Reply(429, "{}", (("Retry-After", "0.5"),))

    with ScriptedEndpoint(answer) as server:
        assert endpoint(server.url).ask(REQUEST) == NORTH
    assert all(later - earlier >= 0.5 for earlier, later in itertools.pairwise(times))


def test_a_long_wait_is_not_waited_for():
    with (
        ScriptedEndpoint(lambda request: Reply(429, "{}", (("Retry-After", "3600"),))) as server,
        pytest.raises(LLMError, match="it asks to wait 3600 seconds"),
    ):
        endpoint(server.url).ask(REQUEST)
    assert len(server.requests) == 1


def test_a_slow_answer_is_asked_for_again():
    answers = iter([3.0, 0.0])

    def answer(request):
        time.sleep(next(answers))
        return NORTH

    with ScriptedEndpoint(answer) as server:
        assert endpoint(server.url, timeout=1.5).ask(REQUEST) == NORTH
    assert len(server.requests) == 2


@pytest.mark.usefixtures("soon")
def test_an_endpoint_that_is_always_slow(tmp_path):
    """A request is sent once and for each retry once more, by nobody but us, and all of that is counted."""

    def answer(request):
        time.sleep(0.6)
        return NORTH

    with ScriptedEndpoint(answer) as server, pytest.raises(LLMError, match="in 3 attempts, at last: timed out"):
        endpoint(server.url, tmp_path / "c.db", timeout=0.1, retries=2).ask(REQUEST)
    time.sleep(0.2)  # a fourth would be on its way
    assert len(server.requests) == 3
    assert spending(f"{tmp_path / 'c.db'}") == [NOTHING | {"requests": 3, "unpriced": 3, "sent": 3, "lost": 3}]


@pytest.mark.usefixtures("soon")
@pytest.mark.parametrize("faults", [["429", "500", "cut"], ["no JSON", "no choices", "half a JSON"]])
def test_attempts_for_whatever_reason_are_counted_together(tmp_path, faults):
    replies = iter([*(FAULTS[fault] for fault in faults), NORTH])
    with ScriptedEndpoint(lambda request: next(replies)) as server:
        assert endpoint(server.url, tmp_path / "c.db", retries=3).ask(REQUEST, (1.0, 1.0)) == NORTH
    (found,) = spending(f"{tmp_path / 'c.db'}")
    assert (found["sent"], found["lost"]) == (4, faults.count("cut"))
    assert found["requests"] == 4 - len({"429", "500", "no JSON"} & {*faults}), "but those that no model answered"
    assert found["unpriced"] == found["requests"] - 1
    replies = iter([FAULTS[fault] for fault in faults])
    with ScriptedEndpoint(lambda request: next(replies)) as server, pytest.raises(LLMError, match="in 3 attempts"):
        endpoint(server.url, retries=2).ask(REQUEST)
    assert len(server.requests) == 3


@pytest.mark.parametrize(
    ("headers", "seconds", "passes"),
    [
        ({}, None, True),
        ({"retry-after": "1.5"}, 1.5, True),
        ({"retry-after-ms": "250", "retry-after": "9"}, 0.25, True),
        ({"retry-after": "121"}, 121.0, False),
        ({"retry-after": "Wed, 21 Oct 2015 07:28:00 GMT"}, 0.0, True),
        ({"retry-after": "Wed, 21 Oct 2015 07:28:30 -0000", "date": "Wed, 21 Oct 2015 07:28:00 GMT"}, 30.0, True),
        ({"retry-after": "Wed Oct 21 07:28:30 2015", "date": "Wed Oct 21 07:28:00 2015"}, 30.0, True),
        ({"retry-after": "Wed Oct 21 07:28:30 2015", "date": "Wed, 21 Oct 2015 09:28:00 +0200"}, 30.0, True),
        ({"retry-after": "Wed, 21 Oct 2015 07:28:00 GMT", "date": "no date"}, 0.0, True),
        ({"retry-after": "soon"}, None, True),
        ({"retry-after": "nan"}, None, True),
        ({"x-should-retry": "false"}, None, False),
    ],
)
@pytest.mark.parametrize("zone", ["UTC", "Asia/Tokyo", "America/New_York"])
def test_how_long_to_wait(headers, seconds, passes, zone, monkeypatch):
    monkeypatch.setenv("TZ", zone)
    time.tzset()
    assert asked_for(headers) == seconds
    assert may_pass(503, headers) == passes
    assert not may_pass(400, headers)
    assert may_pass(400, headers | {"x-should-retry": "true"}) == (seconds is None or seconds < 120)
    assert pause(0, 1.5) == 1.5
    assert 0.375 <= pause(0, None) <= 0.5 < 6.0 <= pause(99, 0.0) <= 8.0
    monkeypatch.undo()
    time.tzset()


@pytest.mark.parametrize("date", ["Wed, 21 Oct 2065 07:28:30 -0000", "Wed Oct 21 07:28:30 2065"])
def test_a_date_without_a_zone_is_in_utc(date, monkeypatch):
    monkeypatch.setenv("TZ", "Asia/Tokyo")
    time.tzset()
    expected = datetime(2065, 10, 21, 7, 28, 30, tzinfo=UTC).timestamp() - time.time()
    assert abs(asked_for({"retry-after": date}) - expected) < 5
    monkeypatch.undo()
    time.tzset()


HALVES = (("Retry-After", KEY[:12]), ("Retry-After", KEY[12:]))


@pytest.mark.parametrize(
    "headers", [(("Retry-After", KEY),), HALVES, (("Retry-After-Ms", KEY), ("X-Should-Retry", KEY), ("Date", KEY))]
)
@pytest.mark.parametrize("status", [400, 401, 429, 503])
def test_the_key_in_a_header_of_a_reply_is_not_said(headers, status):
    reply = Reply(status, json.dumps({"error": {"message": "no"}}), headers)
    with ScriptedEndpoint(lambda request: reply) as server, pytest.raises(LLMError) as caught:
        endpoint(server.url, retries=0).ask(REQUEST)
    for piece in (KEY, KEY[:12], KEY[12:]):
        assert piece not in f"{caught.value}"


def test_a_reply_may_begin_with_a_byte_order_mark():
    with ScriptedEndpoint(lambda request: Reply(200, "\ufeff" + completion(NORTH))) as server:
        assert endpoint(server.url).ask(REQUEST) == NORTH


PROXIES = {
    "dead": (
        {"HTTP_PROXY": "http://me:secret@127.0.0.1:1"},
        r"the proxy http://127\.0\.0\.1:1 \(HTTP_PROXY\) cannot be",
    ),
    "of all": (
        {"all_proxy": "127.0.0.1:1"},
        r"proxy http://127\.0\.0\.1:1 \(all_proxy\) cannot be reached: .* NO_PROXY",
    ),
    "socks": ({"ALL_PROXY": "socks5://me:secret@h:9"}, r"socks5://h:9 \(ALL_PROXY\) needs the package .socksio.; run"),
    "unknown": (
        {"HTTP_PROXY": "nonsense://h"},
        r"the proxy nonsense://h \(HTTP_PROXY\) must begin with one of http, https,",
    ),
    "no port": (
        {"HTTP_PROXY": "http://h:port"},
        r"the proxy http://h:port \(HTTP_PROXY\) is no address: Port could not",
    ),
    "no host": ({"HTTP_PROXY": "http://[::1"}, r"the proxy \(HTTP_PROXY\) is no address: its host is malformed"),
    "a slash": ({"HTTP_PROXY": "http://u:secret/word@h:1"}, r"the proxy \(HTTP_PROXY\) is no address: a user or pass"),
}


@pytest.fixture
def no_proxies(monkeypatch):
    for name in [name for name in os.environ if name.lower().endswith("_proxy")]:
        monkeypatch.delenv(name)


@pytest.mark.usefixtures("no_settings", "no_proxies")
@pytest.mark.parametrize(("variables", "match"), PROXIES.values(), ids=PROXIES)
def test_a_proxy_that_cannot_be_used_is_named_before_a_study_begins(tmp_path, monkeypatch, variables, match):
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    student = "llm(model='m', base_url='http://models.example/v1')"
    study = Study(ids=["llf-gridworld-v0"], teachers=["oracle"], students=[student], seeds=2)
    with Store(tmp_path / "s.db") as store, pytest.raises(ValueError, match=match) as caught:
        play_missing(study, store, 1)
    assert "secret" not in f"{caught.value}"
    assert not list(tmp_path.glob("*.llm.db"))


@pytest.mark.usefixtures("no_proxies")
@pytest.mark.parametrize("proxy", ["http://127.0.0.1:1", "socks5://127.0.0.1:1"])
def test_an_endpoint_of_this_machine_is_asked_directly(proxy, monkeypatch):
    monkeypatch.setenv("ALL_PROXY", proxy)
    with ScriptedEndpoint(lambda request: NORTH) as server:
        reach_proxy(server.url)
        assert endpoint(server.url).ask(REQUEST) == NORTH


@pytest.mark.usefixtures("no_proxies")
def test_a_host_without_proxy_needs_none(monkeypatch):
    monkeypatch.setenv("HTTP_PROXY", "http://127.0.0.1:1")
    monkeypatch.setenv("NO_PROXY", "models.example")
    reach_proxy("http://models.example/v1")
    with pytest.raises(ValueError, match="cannot be reached"):
        reach_proxy("http://others.example/v1")


def test_nobody_is_there():
    with ScriptedEndpoint(lambda request: NORTH) as server:
        url = server.url
    with pytest.raises(
        LLMError, match=r"in 1 attempts, at last: APIConnectionError: Connection error\. .*Connect call failed"
    ):
        endpoint(url, retries=0).ask(REQUEST)


def test_a_wrong_key_is_not_repeated():
    reply = Reply(401, json.dumps({"error": {"message": f"Incorrect API key provided: {KEY}"}}))
    with ScriptedEndpoint(lambda request: reply) as server, pytest.raises(LLMError) as caught:
        endpoint(server.url).ask(REQUEST)
    assert "Incorrect API key provided: ***" in str(caught.value)
    assert "set LLF_LLM_API_KEY" in str(caught.value)
    assert KEY not in repr(caught.value)
    assert caught.value.__cause__ is caught.value.__context__ is None


def test_a_reply_without_content_is_an_empty_answer():
    """As when all tokens went into thoughts: a turn that is no action, not a fault."""
    with ScriptedEndpoint(lambda request: Reply(200, completion(None))) as server:
        assert endpoint(server.url).ask(REQUEST) == ""


def test_a_reply_without_an_answer_is_on_the_ledger_if_it_was_charged(tmp_path):
    charged = '{"choices": [], "usage": {"prompt_tokens": 5, "completion_tokens": 7}}'
    replies = iter([Reply(200, charged), NORTH])
    with ScriptedEndpoint(lambda request: next(replies)) as server:
        endpoint(server.url, tmp_path / "c.db").ask(REQUEST, (1e6, 1e6))
    assert ledger(tmp_path / "c.db") == [(5, 7, 12.0), (3, 6, 9.0)]


def test_half_characters_do_no_harm(tmp_path):
    with ScriptedEndpoint(lambda request: "north \ud83d") as server:
        assert endpoint(server.url, tmp_path / "c.db").ask(REQUEST) == "north ?"


def test_the_limit(tmp_path):
    with ScriptedEndpoint(lambda request: NORTH) as server:
        request = REQUEST | {"max_tokens": 10}
        asked = endpoint(server.url, tmp_path / "c.db", budget=78.0)
        prices = (1e6, 1e6)  # 9 USD a request, which could cost 60
        asked.ask(request, prices)
        asked.ask(request | {"seed": 1}, prices)
        told = r"limit of 78 USD is reached: .*c\.db has 18 USD on its ledger, and the next answer may cost 61 USD"
        with pytest.raises(SpendingLimitError, match=told):
            asked.ask(request | {"seed": 2, "max_tokens": 11}, prices)
        assert asked.ask(request, prices) == NORTH
        assert endpoint(server.url, tmp_path / "c.db", budget=99.0).ask(request | {"seed": 2}, prices) == NORTH
    assert len(server.requests) == 3


def test_a_limit_needs_to_know_the_costs():
    body = json.loads(completion(NORTH))
    del body["usage"]
    with ScriptedEndpoint(lambda request: Reply(200, json.dumps(body))) as server:
        with pytest.raises(LLMError, match="gives no number of tokens"):
            endpoint(server.url, budget=1.0).ask(REQUEST | {"max_tokens": 9}, (1, 1))
        with pytest.raises(LLMError, match="a spending limit needs prices"):
            endpoint(server.url, budget=1.0).ask(REQUEST)
        assert endpoint(server.url).ask(REQUEST, (1, 1)) == NORTH
    assert len(server.requests) == 2


def test_what_is_asked_at_the_same_time_is_paid_once(tmp_path):
    """Several processes with one question: one asks, the others wait for the answer."""

    def answer(request):
        time.sleep(0.5)
        return NORTH

    program = (
        "import sys; sys.path.insert(0, sys.argv[3]); from endpoints import REQUEST, endpoint; "
        "print(endpoint(sys.argv[1], sys.argv[2]).ask(REQUEST))"
    )
    arguments = [str(tmp_path / "c.db"), str(Path(__file__).parents[1] / "helpers")]
    Cache(arguments[0]).close()
    with ScriptedEndpoint(answer) as server:
        command = [sys.executable, "-c", program, server.url, *arguments]
        asking = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(amount(2, full=3))]
        assert all("Response: north" in process.communicate()[0] for process in asking)
    assert len(server.requests) == 1


def test_an_episode():
    with ScriptedEndpoint(lambda request: NORTH) as server:
        only = next(study(server.url).episodes())
        record = play(only)
        assert len(server.requests) == record.episode.turns
        play(only)
    assert record.episode.reads == "words"
    assert record.turns[1].action == "0"
    last = server.requests[-1]
    assert {name: last[name] for name in ("model", "temperature", "max_tokens")} == {
        "model": "m",
        "temperature": 0.0,
        "max_tokens": 1000,
    }
    assert len({request["seed"] for request in server.requests}) == 1
    assert [message["role"] for message in last["messages"]][:4] == ["system", "user", "assistant", "user"]
    assert record.turns[0].instruction in last["messages"][0]["content"]
    assert record.turns[-2].feedback in last["messages"][-1]["content"]
    assert record.turns[-2].observation in last["messages"][-1]["content"]


def test_nonsense_is_a_turn():
    answers = iter(["I would rather not.", "Response: up", "Response: 7", ""])
    with ScriptedEndpoint(lambda request: next(answers)) as server:
        record = play(next(study(server.url).episodes()))
    assert record.episode.parse_failures == 4
    assert record.turns[2].parse_failure == "Response: up"


@pytest.mark.parametrize("history", [0, 1, 3])
def test_the_conversation_is_bounded(history):
    with ScriptedEndpoint(lambda request: "Response: 0") as server:
        play(next(study(server.url, f", history={history}", max_turns=6).episodes()))
    assert [len(request["messages"]) for request in server.requests] == [2 + 2 * min(n, history) for n in range(6)]
    assert len({request["messages"][0]["content"] for request in server.requests}) == 1


def test_seeds_are_those_of_the_episode():
    """The same seed asks the same under every teacher, as long as the teacher says the same."""
    with ScriptedEndpoint(lambda request: "Response: 0") as server:
        for spec in study(server.url, teachers=["silent", "only(kinds='r')"], max_turns=1).episodes():
            play(spec)
        assert len(server.requests) == 1
        play(next(study(server.url, ", seed=False, extra={'top_k': 1}, max_tokens=None, temperature=None").episodes()))
    assert set(server.requests[-1]) == {"model", "messages", "top_k", "stop"}


def test_model_and_endpoint_from_the_environment(monkeypatch):
    monkeypatch.setenv("OPENAI_BASE_URL", "http://localhost:1/v1/")
    monkeypatch.setenv("LLF_LLM_MODEL", "mine")
    assert str(parse_student("llm")) == "llm(model='mine', base_url='http://localhost:1/v1')"
    monkeypatch.setenv("LLF_LLM_BASE_URL", "http://localhost:2/v1")
    assert str(parse_student("llm(model='m')")) == "llm(model='m', base_url='http://localhost:2/v1')"
    monkeypatch.delenv("LLF_LLM_BASE_URL")
    monkeypatch.delenv("OPENAI_BASE_URL")
    assert parse_student("llm").base_url == "https://api.openai.com/v1"
    spec = "llm(model='m', base_url='http://h/v1', temperature=1, seed=False, extra={'top_k': [1, 2.5]})"
    assert str(parse_student(spec)) == spec


def test_whose_key_goes_where():
    openai, ours = {"OPENAI_API_KEY": "theirs-123"}, {"LLF_LLM_API_KEY": "ours-123"}
    assert ClientSettings.read("http://elsewhere/v1", openai).key == ""
    assert ClientSettings.read("https://api.openai.com/v1", openai).key == "theirs-123"
    assert ClientSettings.read("http://mine/v1", openai | {"OPENAI_BASE_URL": "http://mine/v1/"}).key == "theirs-123"
    assert ClientSettings.read("http://elsewhere/v1", openai | ours).key == "ours-123"
    assert "ours-123" not in repr(ClientSettings.read("http://elsewhere/v1", ours))


@pytest.mark.parametrize(
    ("spec", "match"),
    [
        ("llm", "model must be the name of a model, got ''; or set LLF_LLM_MODEL"),
        ("llm(model=3)", "model must be the name of a model, got 3"),
        ("llm(model='m', base_url='localhost')", "base_url must be an address such as http"),
        ("llm(model='m', base_url='http://[x')", "base_url must be an address such as http"),
        ("llm(model='m', base_url='http://u:p@h/v1')", "base_url must hold no user, password or query"),
        ("llm(model='m', base_url='http://h/v1?key=1')", "base_url must hold no user, password or query"),
        ("llm(model='m', temperature='hot')", "temperature must be a number from 0 to 10"),
        ("llm(model='m', max_tokens=0)", "max_tokens must be an integer from 1"),
        ("llm(model='m', history=-1)", "history must be an integer from 0"),
        ("llm(model='m', seed=3)", "seed must be True or False, got 3"),
        ("llm(model='m', input_price=-1)", "input_price must be a number from 0"),
        (
            "llm(model='m', extra={'messages': []})",
            "extra must be a dict of JSON values without the keys model, messages",
        ),
        ("llm(model='m', extra={'a': {1}})", "extra must be a dict of JSON values"),
        ("llm(model='m', key='x')", "student 'llm': unknown parameter 'key'; .*allowed: model, base_url"),
    ],
)
def test_bad_options(spec, match):
    with pytest.raises(ValueError, match=match) as caught:
        parse_student(spec)
    assert "u:p" not in str(caught.value)


@pytest.mark.parametrize(
    ("environment", "match"),
    [
        ({"LLF_LLM_BUDGET": "lots"}, "LLF_LLM_BUDGET must be a number of at least 0, got 'lots'"),
        ({"LLF_LLM_TIMEOUT": "-1"}, "LLF_LLM_TIMEOUT must be a number"),
        (
            {"LLF_LLM_BUDGET": "1"},
            r"a spending limit needs prices: add input_price=\.\.\., output_price=\.\.\. to \"llm",
        ),
        ({"LLF_LLM_CACHE": "/proc/none/c.db"}, "cannot keep answers of language models in /proc/none/c.db"),
        ({"LLF_LLM_API_KEY": "sk-sécret"}, "the key in LLF_LLM_API_KEY or OPENAI_API_KEY must be of printable ASCII"),
    ],
)
def test_what_is_missing_is_said_before_anything_runs(tmp_path, environment, match):
    with pytest.raises(ValueError, match=match) as caught, Store(tmp_path / "s.db") as store:
        play_missing(study("http://localhost:1/v1"), store, environment=environment)
    assert not list(tmp_path.iterdir())
    assert "cret" not in str(caught.value)


def test_the_extra_is_missing(tmp_path, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with (
        Store(tmp_path / "s.db") as store,
        pytest.raises(ModuleNotFoundError, match=r"run: pip install 'llf-teacher\[llm\]'"),
    ):
        play_missing(study("http://localhost:1/v1"), store)
    with pytest.raises(ModuleNotFoundError, match="needs 'openai'"):
        endpoint("http://localhost:1/v1")


def test_prompts_are_in_the_manifest():
    (facts,) = manifest(study("http://h/v1"))["students"].values()
    assert set(facts["prompts"]) == {"system.j2", "turn.j2"}
    assert "Response: your action" in facts["prompts"]["system.j2"]["text"]
    assert len(facts["prompts"]["turn.j2"]["sha256"]) == 64
    assert LLM(model="m").facts() == facts
