"""Studies of language models: many requests at once in one process, and episodes that an endpoint will not play."""

import threading
import time

import pytest

from llf_teacher.models.testing import ScriptedEndpoint, too_long
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.executors import Work, start
from llf_teacher.studies.execution.runner import EpisodeError, RunOptions, play_missing
from llf_teacher.studies.store import Store

ROOM = 206  # words


class Slow:
    """A model that takes its time, the same to the same request, and counts who asks at once."""

    def __init__(self, seconds):
        self.seconds, self.most, self._now, self._lock = seconds, 0, 0, threading.Lock()

    def __call__(self, request):
        with self._lock:
            self._now += 1
            self.most = max(self.most, self._now)
        time.sleep(self.seconds)
        with self._lock:
            self._now -= 1
        turn = len(request["messages"]) // 2
        return f"Response: {('north', 'east', 'west', 'south')[(request['seed'] + turn) % 4]}"


def study(url, seeds, **changes):
    settings = {"ids": ["llf-gridworld-v0"], "teachers": ["oracle"], "feedback_types": ["fp"], "max_turns": 2}
    return Study(students=[f"llm(model='m', base_url='{url}', answer='text')"], seeds=seeds, **(settings | changes))


def played(tmp_path, url, seeds, name, workers, executor="threads"):
    """What was stored, and how long that took."""
    with Store(tmp_path / f"{name}.db") as store:
        began = time.monotonic()
        play_missing(study(url, seeds), store, workers, options=RunOptions(executor))
        took = time.monotonic() - began
        return [dict(row) | {"seconds": None} for row in store.rows()], took


def test_sixty_four_requests_at_once(tmp_path):
    """A study of 64 episodes of two turns takes about as long as one of them, and plays what one at a time plays."""
    model = Slow(2.0)
    with ScriptedEndpoint(model) as server:
        rows, took = played(tmp_path, server.url, 64, "many", 64)
        assert model.most > 32
        assert took < 128
        model.seconds = 0.0
        again, _ = played(tmp_path, server.url, 3, "one", None, "here")
    by_key = {row["key"]: row for row in rows}
    assert len(by_key) == 64
    assert all(by_key[row["key"]] == row for row in again)


@pytest.mark.full
def test_sixty_four_at_once_beside_one_at_a_time(tmp_path):
    """The figures of docs/language-models.md."""
    model = Slow(0.5)
    with ScriptedEndpoint(model) as server:
        many, fast = played(tmp_path, server.url, 64, "many", 64)
        cache = {"LLF_LLM_CACHE": str(tmp_path / "other.llm.db")}
        with Store(tmp_path / "one.db") as store:
            began = time.monotonic()
            play_missing(study(server.url, 64), store, 1, environment=cache, options=RunOptions("threads"))
            slow = time.monotonic() - began
    print(f"128 requests of 0.5 s: {slow:.1f} s one at a time, {fast:.1f} s with 64 at once")
    assert len(many) == 64
    assert fast < slow / 4


def test_one_conversation_that_is_too_long_fails_alone(tmp_path):
    with ScriptedEndpoint(lambda request: too_long(request, ROOM) or Slow(0)(request)) as server:
        long = study(server.url, 4, ids=["llf-gridworld-v0", "llf-poem-Haiku-v0"], max_turns=6)
        with Store(tmp_path / "s.db") as store:
            with pytest.raises(EpisodeError, match=f"maximum context length is {ROOM} tokens"):
                play_missing(long, store, options=RunOptions("threads"))
            failed = list(store.failures())
            there = len(list(store.rows()))
    assert there + len(failed) == 8
    assert there
    assert failed
    assert {failure["reason"] for failure in failed} == {"raised"}
    assert all(f"maximum context length is {ROOM} tokens" in failure["error"] for failure in failed)


def test_a_limit_that_is_reached_stops_all(tmp_path):
    with ScriptedEndpoint(Slow(0.01)) as server:
        dear = f"llm(model='m', base_url='{server.url}', answer='text', input_price=1000, output_price=1000)"
        one = Study(ids=["llf-gridworld-v0"], teachers=["oracle"], students=[dear], seeds=30, max_turns=3)
        with Store(tmp_path / "s.db") as store:
            with pytest.raises(EpisodeError, match="the spending limit of 5 USD is reached"):
                play_missing(one, store, 16, environment={"LLF_LLM_BUDGET": "5"}, options=RunOptions("threads"))
            assert store.manifest()["llm"][0]["usd"] <= 5
            assert not list(store.failures())


@pytest.mark.parametrize(
    ("options", "match"),
    [({"address": "auto"}, "has no address, got address='auto'"), ({"seconds": 3.0}, "cannot enforce limits of time")],
)
def test_what_threads_cannot_do(options, match):
    work = Work(int, abs, 3, options.get("seconds"))
    with pytest.raises(ValueError, match=match):
        start("threads", work, None, options.get("address"))


def test_threads_play_what_they_are_given():
    def call(task):
        if task == 2:
            raise SystemExit
        return -task

    begun = []
    with start("threads", Work(lambda: begun.append(1), call, 5), 2) as engine:
        for task in range(5):
            engine.submit(task)
        results = {}
        while len(results) < 5:
            results |= dict(engine.wait(1.0))
        assert engine.wait(0.01) == []
    lost = results.pop(2)
    assert (lost.reason, begun) == ("died", [1])
    assert results == {0: 0, 1: -1, 3: -3, 4: -4}
