"""What a study keeps of the answers of models: words and thoughts, tokens, prices, time, and what was cut."""

import itertools
import json

import pytest

from llf_teacher.episodes.record import TurnRow, pack_turns
from llf_teacher.models import LLMError, NoAnswerError
from llf_teacher.models.client import Endpoint
from llf_teacher.models.settings import ClientSettings
from llf_teacher.models.testing import Reply, ScriptedEndpoint, completion
from llf_teacher.studies import load
from llf_teacher.studies.analysis.costs import cost_lines
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.store import Store

PRICES = ", input_price=1.0, output_price=10.0"
COSTS = ("answers", "truncated", "input_tokens", "output_tokens", "usd", "seconds")


def llm(url, options=""):
    """The spec of a model that answers in words, unless the options say otherwise."""
    form = "" if "answer=" in options else ", answer='text'"
    return f"llm(model='m', base_url='{url}'{form}{options})"


def spec(url="http://localhost:1/v1", options="", **changes):
    settings = {"ids": ["llf-gridworld-v0"], "teachers": ["oracle"], "seeds": 1, "max_turns": 3}
    student = changes.pop("student", llm(url, options))
    return next(Study(students=[student], **(settings | changes)).episodes())


def test_a_turn_has_what_the_model_said_and_what_it_cost(tmp_path):
    body = completion("<think>is it far?</think>\nResponse: west", finish="length")
    with ScriptedEndpoint(lambda request: Reply(body=body)) as server:
        record = play(spec(server.url, PRICES))
    _, turn, *_ = record.turns
    assert (turn.answer, turn.thought, turn.finish) == ("Response: west", "is it far?", "length")
    assert (turn.input_tokens, turn.output_tokens) == (0, 5)
    assert turn.usd == pytest.approx(5e-5)
    assert 0 < turn.seconds < 60
    episode = record.episode
    assert (episode.answers, episode.truncated, episode.output_tokens) == (3, 3, 15)
    assert episode.usd == pytest.approx(15e-5)
    with Store(tmp_path / "s.db") as store:
        store.add(record)
        assert store.turns(record.spec.key)[1]["thought"] == "is it far?"
        assert not list(store.damage())
    results = load(tmp_path / "s.db")
    (row,) = results.rows()
    assert {name: row[name] for name in COSTS} == {name: getattr(episode, name) for name in COSTS}
    for suffix in (".parquet", ".csv"):
        assert results.export(tmp_path / f"t{suffix}", "turns") == 4
        assert results.export(tmp_path / f"e{suffix}") == 1


def test_thoughts_in_json_are_kept_apart_too():
    said = json.dumps({"thought": "it is not far", "action": "west"})
    with ScriptedEndpoint(lambda request: said) as server:
        turn = play(spec(server.url, ", answer='json'")).turns[1]
    assert (turn.answer, turn.thought, turn.finish) == (said, "it is not far", "stop")


def test_what_is_unknown_of_one_answer_is_unknown_of_the_sum():
    known, unknown = completion("Response: north"), json.loads(completion("Response: north"))
    unknown["usage"]["completion_tokens"] = -1
    bodies = itertools.chain([json.dumps(unknown)], itertools.repeat(known))
    with ScriptedEndpoint(lambda request: Reply(body=next(bodies))) as server:
        record = play(spec(server.url, PRICES))
    assert [turn.usd is None for turn in record.turns[1:]] == [True, False, False]
    assert (record.episode.answers, record.episode.usd, record.episode.output_tokens) == (3, None, None)
    with ScriptedEndpoint(lambda request: "Response: north") as server:
        episode = play(spec(server.url)).episode
    assert (episode.usd, episode.truncated) == (None, 0)
    assert episode.output_tokens == 6


def test_an_answer_from_the_cache_is_recorded_as_it_was_paid_for(tmp_path, monkeypatch):
    monkeypatch.setenv("LLF_LLM_CACHE", str(tmp_path / "c.db"))
    with ScriptedEndpoint(lambda request: "Response: north") as server:
        first, again = (play(spec(server.url, PRICES)) for _ in range(2))
    assert first == again
    assert len(server.requests) == 3


def test_what_was_cut_and_what_is_of_unknown_price_is_said(tmp_path):
    replies = itertools.cycle([completion("Response: north", finish="length"), completion("so?")])
    with ScriptedEndpoint(lambda request: Reply(body=next(replies))) as server, Store(tmp_path / "s.db") as store:
        store.add(play(spec(server.url, max_turns=4)))
        store.add(play(spec(student="obedient")))
        model = {"model": "m", "requests": 4, "input_tokens": 0, "output_tokens": 6, "usd": 1.5}
        lost = {"unpriced": 0, "sent": 7, "lost": 2}
        store.write_manifest({"llm": [model | {"unpriced": 4}, model | {"unpriced": 1}, model | lost]})
        lines = list(cost_lines(store))
        (row,) = store.answers()
    assert [line.partition("out, ")[2] for line in lines[:3]] == [
        "at an unknown price",
        "1.5000 USD, without 1 of unknown price",
        "1.5000 USD",
    ]
    assert lines.pop(3) == "m: no reply to 2 of 7 requests, which may be charged nevertheless"
    assert lines[3].endswith(": 2 of 4 answers were cut for their length; raise max_tokens")
    assert lines[4].endswith(": 2 of 4 answers were no actions; see the transcripts")
    assert len(lines) == 5
    assert (row["episodes"], row["answers"], row["output_tokens"], row["usd"]) == (1, 4, 6, None)


def test_scripted_students_leave_nothing():
    record = play(spec(student="obedient"))
    assert all(getattr(record.episode, name) is None for name in COSTS)
    eleven = [turn[: TurnRow._fields.index("answer")] for turn in record.turns]
    assert pack_turns(record.turns) == pack_turns([TurnRow(*turn) for turn in eleven])


AGENT = """
class Talker:
    def reset(self): ...
    def act(self, observation): return "Response: west"
    def record(self): return {"answer": "I say west", "thought": "why not", "usd": 0.5}

class Boaster(Talker):
    def record(self): return {"cost": 1}
"""


def test_an_agent_of_ones_own_may_tell(tmp_path, monkeypatch):
    (tmp_path / "talking_agent.py").write_text(AGENT)
    monkeypatch.syspath_prepend(str(tmp_path))
    record = play(spec(student="talking_agent:Talker"))
    assert [turn.thought for turn in record.turns] == [None, "why not", "why not", "why not"]
    assert (record.episode.answers, record.episode.usd, record.episode.input_tokens) == (3, 1.5, None)
    with pytest.raises(ValueError, match="key of its record 'cost'"):
        play(spec(student="talking_agent:Boaster"))


@pytest.mark.parametrize(("status", "only_this"), [(400, True), (413, True), (422, True), (401, False), (404, False)])
def test_an_error_of_one_request_is_told_from_one_of_all(status, only_this):
    with ScriptedEndpoint(lambda request: Reply(status, '{"error": {"message": "no"}}')) as server:
        asked = Endpoint(server.url, ClientSettings(key="", cache=":memory:", budget=None, timeout=5.0, retries=0))
        with pytest.raises(LLMError, match="no") as caught:
            asked.ask({"model": "m", "messages": []})
    assert isinstance(caught.value, NoAnswerError) == only_this
