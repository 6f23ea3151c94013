"""What an endpoint may do to its clients: take long, send much, count wrongly, refuse; and what a client may spend."""

import asyncio
import contextlib
import json
import os
import sqlite3
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace
from unittest.mock import Mock

import pytest

from llf_teacher.models import LLMError, SpendingLimitError
from llf_teacher.models import cache as cache_module
from llf_teacher.models.cache import Cache, spending
from llf_teacher.models.client import Endpoint
from llf_teacher.models.replies import Prices
from llf_teacher.models.settings import ClientSettings
from llf_teacher.models.testing import Reply, ScriptedEndpoint, completion, refusal, too_long
from llf_teacher.models.waiting import awaited, wait_for

REQUEST = {"model": "m", "messages": [{"role": "user", "content": "north or south?"}], "max_tokens": 10}
NORTH = "Thought: it said so.\nResponse: north"


def endpoint(url, cache=":memory:", budget=None, timeout=5.0, retries=2, key=""):
    return Endpoint(url, ClientSettings(key=key, cache=f"{cache}", budget=budget, timeout=timeout, retries=retries))


def test_the_time_limit_is_for_the_whole_request():
    """A byte now and then keeps a connection alive, not a request."""
    dribble = Reply(body=completion(NORTH), pause=0.2)
    with ScriptedEndpoint(lambda request: dribble) as server:
        asked = endpoint(server.url, timeout=0.5, retries=0)
        started = time.monotonic()
        with pytest.raises(
            LLMError, match=r"in 1 attempts, at last: timed out after 0\.5 seconds; LLF_LLM_TIMEOUT sets the limit"
        ):
            asked.ask(REQUEST)
    assert 0.5 <= time.monotonic() - started < 10, "of 50 seconds"


@pytest.mark.parametrize("status", [200, 400])
def test_a_body_without_end_is_given_up(status):
    sent = []

    def answer(request):
        sent.append(request)
        return Reply(status, " " * 1_000_000, repeat=300)

    with ScriptedEndpoint(answer) as server, pytest.raises(LLMError, match="longer than the allowed 16000000 bytes"):
        endpoint(server.url, timeout=30.0).ask(REQUEST)
    assert len(sent) == 1


@pytest.mark.parametrize("tokens", ["-5", "1e300", "Infinity", "NaN", '"12"', "null", "true", "12.5", "[1]", "9" * 400])
def test_counts_that_cannot_be_are_unknown(tmp_path, tokens):
    body = json.loads(completion(NORTH))
    body["usage"]["prompt_tokens"] = "HERE"
    reply = Reply(body=json.dumps(body).replace('"HERE"', tokens))
    with ScriptedEndpoint(lambda request: reply) as server:
        answer = endpoint(server.url, tmp_path / "c.db").answer(REQUEST, (1, 1))
        assert (answer.text, answer.usage.input_tokens, answer.usage.usd) == (NORTH, None, None)
        with pytest.raises(LLMError, match="gives no number of tokens"):
            endpoint(server.url, budget=1.0).ask(REQUEST, (1, 1))
    with contextlib.closing(Cache(f"{tmp_path / 'c.db'}")) as cache:
        assert cache.by_model()[0]["unpriced"] == 1


def test_input_that_the_endpoint_had_is_priced_so():
    body = json.loads(completion(NORTH))
    body["usage"] = {"prompt_tokens": 100, "completion_tokens": 1, "prompt_tokens_details": {"cached_tokens": 90}}
    with ScriptedEndpoint(lambda request: Reply(body=json.dumps(body))) as server:
        assert endpoint(server.url).answer(REQUEST, Prices(1e6, 1e6, 1e5)).usage.usd == pytest.approx(10 + 9 + 1)
        assert endpoint(server.url).answer(REQUEST, (1e6, 1e6)).usage == (100, 1, 101.0, 90)


def test_what_is_under_way_is_reserved(tmp_path):
    """Many at once never spend more than the limit, whatever the answers cost."""

    def answer(request):
        time.sleep(0.1)
        return "word " * 10  # as dear as it may be

    with ScriptedEndpoint(answer) as server:
        cache = tmp_path / "c.db"

        def ask(number):
            try:
                return endpoint(server.url, cache, budget=150.0).ask(REQUEST | {"seed": number}, (1e6, 1e6))
            except SpendingLimitError as error:
                return f"{error}"

        with ThreadPoolExecutor(8) as pool:
            said = list(pool.map(ask, range(12)))
    with contextlib.closing(Cache(f"{cache}")) as kept:
        assert 75 < kept.spent() <= 150
    assert sum("limit of 150 USD is reached" in text for text in said) == 12 - len(server.requests)


def test_a_pledge_of_one_who_died_runs_out(tmp_path, monkeypatch):
    now = [1000.0]
    monkeypatch.setattr(cache_module, "time", SimpleNamespace(time=lambda: now[0]))
    with contextlib.closing(Cache(f"{tmp_path / 'c.db'}")) as cache:
        assert cache.pledge(6.0, 10.0, 0.2) is not None
        assert cache.pledge(6.0, 10.0, 0.2) is None
        now[0] += 0.25
        with pytest.raises(LookupError):
            cache.pledge(6.0, 10.0, 0.2)
        assert cache.spent() == 0, "of a transaction that was refused, nothing stays"
        assert cache.pledge(4.0, 10.0, 0.2) is not None
        assert cache.spent() == 6.0, "it may have been paid"


def test_a_pledge_goes_with_its_process(tmp_path):
    path = f"{tmp_path / 'c.db'}"
    program = (
        "import sys, llf_teacher.models.cache as c; print(c.Cache(sys.argv[1]).pledge({}, {}, 1000.0, 'key', 'm'))"
    )
    for number, words in enumerate([(6.0, 10.0), (None, None)], 1):
        command = [sys.executable, "-c", program.format(*words), path]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        assert int(done.stdout) > 0
        (found,) = spending(path)
        nothing = {"model": "m", "input_tokens": 0, "output_tokens": 0, "usd": 6.0, "unpriced": number - 1}
        assert found == nothing | {"requests": number, "sent": number, "lost": number}
        assert spending(path) == [found], "once"
    with contextlib.closing(Cache(path)) as cache:
        assert cache.pledge(4.0, 10.0, 1000.0) is not None


def test_a_failed_request_gives_back_what_it_reserved(tmp_path):
    replies = iter([Reply(400, "no"), NORTH])
    with ScriptedEndpoint(lambda request: next(replies)) as server:
        asked = endpoint(server.url, tmp_path / "c.db", budget=70.0)
        with pytest.raises(LLMError, match="no"):
            asked.ask(REQUEST, (1e6, 1e6))
        assert asked.ask(REQUEST, (1e6, 1e6)) == NORTH
    with contextlib.closing(sqlite3.connect(tmp_path / "c.db")) as db:
        assert db.execute("SELECT count(*) FROM under_way").fetchone() == (0,)


def test_a_client_in_a_coroutine_that_is_awaited_is_an_error_and_no_request(tmp_path):
    with ScriptedEndpoint(lambda request: NORTH) as server:
        asked = endpoint(server.url, tmp_path / "c.db")

        async def agent():
            return asked.ask(REQUEST)

        async def apart():
            return await asyncio.to_thread(asked.ask, REQUEST)

        with pytest.raises(RuntimeError, match="would wait for itself for ever"):
            awaited(agent())
        assert server.requests == []
        assert spending(f"{tmp_path / 'c.db'}")[0]["lost"] == 0
        assert awaited(apart()) == NORTH


def test_a_limit_needs_a_longest_answer():
    request = {name: value for name, value in REQUEST.items() if name != "max_tokens"}
    with ScriptedEndpoint(lambda request: NORTH) as server:
        with pytest.raises(LLMError, match=r"a spending limit needs a maximum length .*: max_tokens"):
            endpoint(server.url, budget=1.0).ask(request, (1, 1))
        assert not server.requests


def test_a_cache_in_memory_is_refused():
    with pytest.raises(ValueError, match=r"LLF_LLM_CACHE must be the name of a file, got ':memory:'"):
        ClientSettings.read("http://h/v1", {"LLF_LLM_CACHE": ":memory:"})


def picky(*parameters, status=400):
    """An endpoint that takes none of these parameters."""

    def answer(request):
        found = [name for name in parameters if name in request]
        return refusal(found[0], status) if found else NORTH

    return answer


@pytest.mark.parametrize("status", [400, 422])
def test_a_refused_parameter_is_left_out_and_remembered(tmp_path, status):
    request = REQUEST | {"temperature": 0.0, "seed": 3}
    with ScriptedEndpoint(picky("max_tokens", "temperature", status=status)) as server:
        asked = endpoint(server.url, tmp_path / "c.db")
        answer = asked.answer(request)
        assert (answer.text, answer.unsent) == (NORTH, ("max_tokens", "temperature"))
        asked.ask(request | {"seed": 4})
        again = endpoint(server.url, tmp_path / "c.db").answer(request)
    assert again == answer
    assert [set(each) - {"model", "messages"} for each in server.requests] == [
        {"max_tokens", "temperature", "seed"},
        {"max_completion_tokens", "temperature", "seed"},
        {"max_completion_tokens", "seed"},
        {"max_completion_tokens", "seed"},
    ]
    assert server.requests[-1]["max_completion_tokens"] == 10


def test_a_refusal_in_words_alone():
    """As of servers that name no parameter apart."""
    replies = iter([Reply(400, '{"detail": "Unrecognized request argument supplied: seed"}'), NORTH])
    with ScriptedEndpoint(lambda request: next(replies)) as server:
        assert endpoint(server.url).ask(REQUEST | {"seed": 3}) == NORTH
    assert "seed" not in server.requests[-1]


@pytest.mark.parametrize(
    "told",
    [
        "'max_tokens' is too large: 10. This model's maximum context length is 5 tokens.",
        "Unsupported parameter: 'messages' is not supported.",
    ],
)
def test_other_troubles_are_no_refusal(told):
    reply = Reply(400, json.dumps({"error": {"message": told, "param": None, "code": None}}))
    with ScriptedEndpoint(lambda request: reply) as server, pytest.raises(LLMError, match="gave no answer"):
        endpoint(server.url).ask(REQUEST)
    assert len(server.requests) == 1


def test_a_limit_cannot_be_kept_where_no_length_is_taken():
    with (
        ScriptedEndpoint(picky("max_tokens", "max_completion_tokens")) as server,
        pytest.raises(LLMError, match="accepts no max_tokens, so that no spending limit can be kept"),
    ):
        endpoint(server.url, budget=100.0).ask(REQUEST, (1, 1))


def test_a_prompt_that_is_too_long_is_an_error_of_its_own(tmp_path):
    with ScriptedEndpoint(lambda request: too_long(request, 2) or NORTH) as server:
        with pytest.raises(LLMError, match="maximum context length is 2 tokens") as caught:
            endpoint(server.url).ask(REQUEST)
        assert not isinstance(caught.value, SpendingLimitError)
    assert len(server.requests) == 1


def test_a_filtered_answer_is_an_error_that_is_paid_once(tmp_path):
    reply = Reply(body=completion(None, finish="content_filter"))
    with ScriptedEndpoint(lambda request: reply) as server:
        for _ in range(2):
            with pytest.raises(LLMError, match=r"the content filter of .* withholds what m says"):
                endpoint(server.url, tmp_path / "c.db").ask(REQUEST)
    assert len(server.requests) == 1


def test_threads_that_ask_the_same_pay_once(tmp_path):
    def answer(request):
        time.sleep(0.2)
        return NORTH

    with ScriptedEndpoint(answer) as server:
        asked = endpoint(server.url, tmp_path / "c.db")
        with ThreadPoolExecutor(8) as pool:
            assert set(pool.map(lambda _: asked.ask(REQUEST), range(8))) == {NORTH}
    assert len(server.requests) == 1


def test_sixty_four_at_once(tmp_path):
    """None is answered before more than 32 have been asked."""
    under_way, enough, lock = [0], threading.Event(), threading.Lock()

    def answer(request):
        with lock:
            under_way[0] += 1
            if under_way[0] > 32:
                enough.set()
        assert enough.wait(50)
        return NORTH

    with ScriptedEndpoint(answer) as server:
        asked = endpoint(server.url, tmp_path / "c.db", timeout=60.0)
        with ThreadPoolExecutor(64) as pool:
            list(pool.map(lambda n: asked.ask(REQUEST | {"seed": n}), range(64)))
    assert enough.is_set()


def test_one_may_wait_in_a_process_that_was_forked():
    async def one():
        return 1

    assert wait_for(one()) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of newer Pythons: there is a thread, which is the point
        child = os.fork()
    if child == 0:
        os._exit(0 if wait_for(one()) == 1 else 1)
    assert os.waitpid(child, 0)[1] == 0


@pytest.mark.parametrize("error", [SystemExit(3), KeyboardInterrupt()])
def test_a_coroutine_that_exits_is_an_error_of_its_own(error):
    async def leave():
        raise error

    async def one():
        return 1

    async def all_of(*coroutines):
        return await asyncio.gather(*coroutines)

    for leaving in (leave(), all_of(leave())):
        with pytest.raises(RuntimeError, match=r"must not end the process, got (SystemExit|KeyboardInterrupt)\("):
            wait_for(leaving)
        assert wait_for(one()) == 1, "the loop is alive"


def test_an_interrupt_as_a_coroutine_ends_is_an_interrupt(monkeypatch):
    """Else it would be the failure of an episode, and a study went on."""
    begin = asyncio.run_coroutine_threadsafe

    def interrupted(coroutine, loop):
        future = begin(coroutine, loop)
        assert future.result(60) == 1
        monkeypatch.setattr(future, "result", Mock(side_effect=KeyboardInterrupt))
        return future

    async def one():
        return 1

    monkeypatch.setattr(asyncio, "run_coroutine_threadsafe", interrupted)
    with pytest.raises(KeyboardInterrupt):
        wait_for(one())


def test_a_streamed_answer():
    """Of the scripted endpoint, for the clients of others."""
    import openai

    with (
        ScriptedEndpoint(lambda request: NORTH) as server,
        openai.OpenAI(base_url=server.url, api_key="none") as client,
    ):
        parts = client.chat.completions.create(model="m", messages=REQUEST["messages"], stream=True)
        assert "".join(part.choices[0].delta.content or "" for part in parts).strip() == NORTH
        assert client.models.list().data == []
