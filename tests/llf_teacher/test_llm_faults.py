"""What an endpoint does wrong, one fault each: the table of the page, and what is kept of odd answers.

`LLF_WRITE_FAULTS=1 pytest -n 0 -m full tests/llf_teacher/test_llm_faults.py -k table` writes the table anew.
"""

import base64
import json
import os
import threading
import time
from pathlib import Path
from typing import NamedTuple

import pytest
from endpoints import KEY, NORTH, REQUEST, endpoint, files_with, ledger

from llf_teacher.models import LLMError, NoAnswerError, SpendingLimitError, retries
from llf_teacher.models.cache import spending
from llf_teacher.models.testing import Reply, ScriptedEndpoint, completion, too_long
from llf_teacher.students.builtin.llm import LLM
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play

pytestmark = pytest.mark.usefixtures("no_settings", "soon")
PAGE = Path(__file__).parents[2] / "docs" / "internals" / "asking-models.md"
BEGIN, END = "<!-- faults -->\n", "<!-- end of faults -->"
UNCOUNTED = {name: value for name, value in json.loads(completion(NORTH)).items() if name != "usage"}


@pytest.fixture
def soon(monkeypatch):
    monkeypatch.setattr(retries, "_FIRST", 0.01)


def error(message, status=400, **more):
    return Reply(status, json.dumps({"error": {"message": message, **more}}))


class Fault(NamedTuple):
    what: str
    reply: Reply
    limit: float | None = None
    """A spending limit, in USD."""


FAULTS = [
    Fault("a wrong key", error("Incorrect API key.", 401)),
    Fault("an empty account", error("Insufficient credits.", 402)),
    Fault("an unknown model", error("The model 'm' does not exist.", 404)),
    Fault("a wrong path", Reply(404, "<html>Not Found</html>")),
    Fault("a web page", Reply(200, "<!doctype html><html>Sign in</html>")),
    Fault("an event stream", Reply(200, 'data: {"choices": []}\n\n')),
    Fault("too long a prompt", too_long(REQUEST, 2)),
    Fault("no JSON Schema", error("response_format json_schema is not supported")),
    Fault("no tools", error("this model does not support tools")),
    Fault("too many requests", error("Slow down.", 429)),
    Fault("an hour's pause", Reply(429, "{}", (("Retry-After", "3600"),))),
    Fault("a fault of its own", Reply(500, "oops")),
    Fault("too slow a reply", Reply(200, completion(NORTH), pause=0.02)),
    Fault("a reply cut by the network", Reply(200, completion(NORTH), cut=True)),
    Fault("half a reply", Reply(200, completion(NORTH)[:40])),
    Fault(
        "no answer, with its tokens",
        Reply(200, '{"choices": [], "usage": {"prompt_tokens": 5, "completion_tokens": 7}}'),
    ),
    Fault("a reply without end", Reply(200, " " * 1_000_000, repeat=20)),
    Fault("withheld by a filter", Reply(200, completion(None, finish="content_filter"))),
    Fault("no tokens, with a limit", Reply(200, json.dumps(UNCOUNTED)), limit=1e3),
]


def row(fault, folder):
    """The row of a fault that stays, with one attempt after the first."""
    cache = folder / f"{FAULTS.index(fault)}.db"
    with ScriptedEndpoint(lambda request: fault.reply) as server:
        asked = endpoint(server.url, cache, budget=fault.limit, timeout=0.4 if fault.reply.pause else 20.0, retries=1)
        with pytest.raises(LLMError) as caught:
            asked.ask(REQUEST | {"max_tokens": 10}, (1e6, 1e6))
    (found,) = spending(f"{cache}")
    assert found["sent"] == len(server.requests)
    paid = [
        f"{usd:g} USD" if asked is not None else f"{usd:g} USD at most" if usd else "unknown"
        for asked, _, usd in ledger(cache)
    ]
    ends = "the episode" if isinstance(caught.value, NoAnswerError) else "the study"
    said = f"{caught.value}".replace(server.url, "URL").replace("|", "\\|").replace("\n", " ")
    paid = f"{', '.join(dict.fromkeys(paid))}{' each' if len(paid) > 1 else ''}" or "nothing"
    return f"| {fault.what} | {found['sent']} | {found['lost']} | {paid} | {ends} | {said} |"


@pytest.mark.full
def test_the_table_of_the_page(tmp_path):
    """With the pinned version of the client, in the source tree."""
    head = "| fault | sent | lost | paid | ends | what is said |\n|---|---|---|---|---|---|\n"
    table = head + "".join(f"{row(fault, tmp_path)}\n" for fault in FAULTS)
    text = PAGE.read_text("utf-8")
    before, _, rest = text.partition(BEGIN)
    was, _, after = rest.partition(END)
    if os.environ.get("LLF_WRITE_FAULTS"):
        PAGE.write_text(before + BEGIN + table + END + after, "utf-8")
    else:
        assert was == table
    assert not files_with(KEY, tmp_path)


def test_all_that_may_be_charged_is_on_the_ledger(tmp_path):
    """Six are sent: three are cut by the network."""
    replies = [Reply(200, completion(NORTH), cut=True), NORTH] * 3
    with ScriptedEndpoint(lambda request: replies[len(server.requests) - 1]) as server:
        asked = endpoint(server.url, tmp_path / "c.db")
        for number in range(3):
            assert asked.ask(REQUEST | {"seed": number}, (1.0, 1.0)) == NORTH
    (found,) = spending(f"{tmp_path / 'c.db'}")
    assert (found["sent"], found["requests"], found["lost"], found["unpriced"]) == (6, 6, 3, 3)


HINTS = {
    "a text as the error": (Reply(400, '{"error": "response_format is unknown to me"}'), "answer='text'"),
    "a detail": (Reply(422, '{"detail": [{"loc": ["body", "response_format"], "msg": "extra"}]}'), "answer='text'"),
    "plain text": (Reply(400, "context length exceeded"), "smaller history"),
    "all fields": (error("Invalid schema: all fields must be required"), "answer='text'"),
    "Gemini": (
        error("The input token count (9) exceeds the maximum number of tokens allowed (8)."),
        "give a smaller history, or a student a smaller max_prompt_tokens",
    ),
    "Groq": (error("Please reduce the length of the messages or completion."), "smaller history"),
    "413": (error("Request too large for model m in tokens per minute", 413), "smaller history"),
}


@pytest.mark.parametrize("what", HINTS)
def test_what_is_refused_names_the_setting(what):
    """In whatever form the error comes; it is quoted, and fails its episode alone."""
    reply, expected = HINTS[what]
    with ScriptedEndpoint(lambda request: reply) as server, pytest.raises(NoAnswerError, match=expected) as caught:
        endpoint(server.url).ask(REQUEST)
    said = json.loads(reply.body) if reply.body.startswith("{") else reply.body
    while isinstance(said, dict | list):
        said = list(said.values())[-1] if isinstance(said, dict) else said[-1]
    assert said in f"{caught.value}"


def test_an_empty_account_stops_the_study():
    with (
        ScriptedEndpoint(lambda request: error("Insufficient credits", 402)) as server,
        pytest.raises(LLMError, match=r"Insufficient credits; the account of the key has no money left") as caught,
    ):
        endpoint(server.url).ask(REQUEST)
    assert not isinstance(caught.value, NoAnswerError)


def test_a_page_that_begins_with_a_comment_is_not_paid(tmp_path):
    with (
        ScriptedEndpoint(lambda request: Reply(200, "\n<!-- proxy --><html>Sign in</html>")) as server,
        pytest.raises(LLMError, match="this is a web page"),
    ):
        endpoint(server.url, tmp_path / "c.db", retries=1).ask(REQUEST)
    assert ledger(tmp_path / "c.db") == []


ESCAPED = "".join(f"\\u{ord(each):04X}" for each in KEY)


PERCENT = "".join(f"%{ord(each):02x}" for each in KEY)
FORMS = {
    "itself": KEY,
    "JSON": ESCAPED,
    "JSON in JSON": ESCAPED.replace("\\", "\\\\"),
    "a backslash": KEY.replace("-", "\\-"),
    "an address": KEY.replace("-", "%2D"),
    "all of an address": PERCENT,
    "an address in an address": PERCENT.replace("%", "%25"),
    "HTML": KEY.replace("-", "&#45;"),
    "all of HTML": "".join(f"&#x{ord(each):04X};" for each in KEY),
}


@pytest.mark.parametrize("key", FORMS.values(), ids=FORMS)
def test_no_escape_hides_the_key(tmp_path, key):
    """What an endpoint repeats of it is masked before it is kept, in each of an answer's texts; so are surrogates."""
    reply = Reply(body=completion(f"Go {key}.\ud800", {"model": key, "messages": []}, reasoning_content=key))
    with ScriptedEndpoint(lambda request: reply) as server:
        for _ in range(2):
            found = endpoint(server.url, tmp_path / "c.db").answer(REQUEST)
            assert (found.raw, found.reasoning, found.model) == ("Go ***.?", "***", "***")
    assert not files_with(KEY, tmp_path)


ENCODED = {
    "base64": base64.b64encode(KEY.encode()).decode(),
    "basic": base64.b64encode(f"user:{KEY}".encode()).decode(),
    "another user": base64.b64encode(f"us:{KEY}\n".encode()).decode(),
    "of addresses": base64.urlsafe_b64encode(f"{KEY}?".encode()).decode(),
    "escaped": base64.b64encode(f"user:{KEY}".encode()).decode().replace("/", "\\/").replace("=", "%3D"),
    "hex": KEY.encode().hex(),
    "HEX": KEY.encode().hex().upper(),
}


@pytest.mark.parametrize("text", ENCODED.values(), ids=ENCODED)
def test_no_encoding_hides_the_key(tmp_path, text):
    """At most what the bytes beside the key decide of its first and last letters is left."""
    reply = Reply(body=completion(f"Authorization: Basic {text}"))
    with ScriptedEndpoint(lambda request: reply) as server:
        found = endpoint(server.url, tmp_path / "c.db").answer(REQUEST).raw
        assert "***" in found
        left = found.removeprefix("Authorization: Basic ").split("***")
        assert len("".join(left).replace("=", "").replace("%3D", "")) <= 11  # `user:`, and a letter at each end
    with ScriptedEndpoint(lambda request: error(f"Wrong: {text}", 401)) as server:
        with pytest.raises(LLMError, match=r"Wrong: .*\*\*\*") as caught:
            endpoint(server.url).ask(REQUEST)
        assert text not in f"{caught.value}"


@pytest.mark.parametrize("name", ["latin-1", "utf-16"])
def test_a_reply_in_an_encoding_of_its_own_is_read_by_it(name):
    body = json.dumps(json.loads(completion("Größe")), ensure_ascii=False).encode(name)
    reply = Reply(body=body, headers=(("Content-Type", f"application/json; charset={name}"),))
    with ScriptedEndpoint(lambda request: reply) as server:
        assert endpoint(server.url).ask(REQUEST) == "Größe"


@pytest.mark.parametrize("name", ["klingon", "zlib", "utf-16", "hex"])
def test_an_encoding_that_is_named_in_error_changes_nothing(name):
    """No encoding, no encoding of text, or one in which the reply is not written."""
    body = json.dumps(json.loads(completion("Größe")), ensure_ascii=False)
    reply = Reply(body=body, headers=(("Content-Type", f"application/json; charset={name}"),))
    with ScriptedEndpoint(lambda request: reply) as server:
        assert endpoint(server.url).ask(REQUEST) == "Größe"


@pytest.mark.parametrize("status", [200, 429])
def test_a_header_that_is_not_ascii_costs_no_answer(status):
    """Neither a paid answer nor the next attempt."""
    replies = [Reply(status, completion(NORTH), (("X-Served-By", "Zürich"), ("Retry-After", "\xff"))), NORTH]
    with ScriptedEndpoint(lambda request: replies[len(server.requests) - 1]) as server:
        assert endpoint(server.url).ask(REQUEST) == NORTH
    assert len(server.requests) == (1 if status == 200 else 2)


def test_many_backslashes_take_linear_time():
    long = "\\" * 500_000
    with ScriptedEndpoint(lambda request: long) as server:
        assert endpoint(server.url, timeout=60.0).ask(REQUEST) == long


def test_a_limit_counts_what_was_cut_at_the_most_that_it_may_cost(tmp_path):
    replies = [Reply(200, completion(NORTH), cut=True), NORTH]
    with ScriptedEndpoint(lambda request: replies[min(len(server.requests), 2) - 1]) as server:
        asked = endpoint(server.url, tmp_path / "c.db", budget=130.0)
        request = REQUEST | {"max_tokens": 10}
        assert asked.ask(request, (1e6, 1e6)) == NORTH
        with pytest.raises(SpendingLimitError, match="has 69 USD on its ledger, and the next answer may cost 6"):
            asked.ask(request | {"seed": 1, "max_tokens": 12}, (1e6, 1e6))
    assert ledger(tmp_path / "c.db") == [(None, None, 60.0), (3, 6, 9.0)]


def test_nothing_is_charged_where_nobody_listens(tmp_path):
    with ScriptedEndpoint(lambda request: NORTH) as server:
        url = server.url
    with pytest.raises(LLMError, match="does the endpoint run, and is base_url its address"):
        endpoint(url, tmp_path / "c.db", retries=1, budget=100.0).ask(REQUEST | {"max_tokens": 9}, (1.0, 1.0))
    assert ledger(tmp_path / "c.db") == []


def test_what_an_interrupt_cuts_is_on_the_ledger(tmp_path, monkeypatch):
    begun = threading.Event()

    def answer(request):
        begun.set()
        time.sleep(1)
        return NORTH

    def interrupt(coroutine):
        coroutine.close()
        raise KeyboardInterrupt

    monkeypatch.setattr("llf_teacher.models.client.wait_for", interrupt)
    with ScriptedEndpoint(answer) as server, pytest.raises(KeyboardInterrupt):
        endpoint(server.url, tmp_path / "c.db").ask(REQUEST)
    (found,) = spending(f"{tmp_path / 'c.db'}")
    assert (found["sent"], found["lost"], found["unpriced"]) == (1, 1, 1)


CALL = {"id": "c1", "type": "function", "function": {"name": "act", "arguments": {"thought": "so", "action": "west"}}}
KEPT = {
    "refusal": (completion(None, refusal="I cannot help."), ("I cannot help.", "", "refusal")),
    "in its thoughts": (completion(None, reasoning_content=NORTH), (NORTH, "", "stop")),
    "thoughts alone": (completion("", reasoning_content=NORTH, finish="length"), ("", NORTH, "length")),
    "an object": (
        completion(None, tool_calls=[CALL], finish="tool_calls"),
        ('{"thought": "so", "action": "west"}', "", "tool_calls"),
    ),
    "calls that are none": (completion("north", tool_calls=3), ("north", "", "stop")),
    "a refusal that is none": (completion("north", refusal={"no": 1}), ("north", "", "stop")),
}


@pytest.mark.parametrize("answer", KEPT)
def test_what_is_kept_of_an_answer(tmp_path, answer):
    body, expected = KEPT[answer]
    with ScriptedEndpoint(lambda request: Reply(body=body)) as server:
        for _ in range(2):
            found = endpoint(server.url, tmp_path / "c.db").answer(REQUEST)
            assert (found.raw, found.reasoning, found.finish) == expected
    assert len(server.requests) == 1


def test_a_call_with_an_object_is_an_action():
    reply = Reply(body=completion(None, tool_calls=[CALL], finish="tool_calls"))
    with ScriptedEndpoint(lambda request: reply) as server:
        student = LLM("m", server.url, answer="tool")
        record = play(
            next(
                Study(
                    ids=["llf-gridworld-v0"], teachers=["oracle"], students=[student], seeds=1, max_turns=2
                ).episodes()
            )
        )
    assert (record.episode.parse_failures, record.turns[1].action_words) == (0, "west")
    sent = server.requests[-1]["messages"][-2]["tool_calls"][0]["function"]["arguments"]
    assert json.loads(sent) == CALL["function"]["arguments"]
