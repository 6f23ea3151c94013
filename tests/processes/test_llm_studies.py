"""Studies with a language model: killed, limited, and with broken or slow endpoints."""

import collections
import contextlib
import json
import os
import signal
import sqlite3
import subprocess
import sys
import threading
import time

import pytest
from commands import llf, llf_apart
from design import amount
from endpoints import KEY, MOVES, NORTH, files_with, ledger
from studying import rows

from llf_teacher.models.cache import spending
from llf_teacher.models.testing import Reply, ScriptedEndpoint
from llf_teacher.studies.definition.study import load_study
from llf_teacher.studies.execution.runner import play_missing
from llf_teacher.studies.store import Store

pytestmark = pytest.mark.usefixtures("no_settings")

STUDY = """
ids = ["llf-gridworld-v0"]
teachers = ["oracle", "silent"]
students = ["llm(model='m', base_url='{url}', answer='text', input_price=1000, output_price=1000)"]
feedback_types = ["fp+r"]
seeds = 25
max_turns = 5
"""


def wanderer(delay=0.0):
    """A model that is the same to the same request, and slow enough to be interrupted."""

    def answer(request):
        time.sleep(delay)
        turn = len(request["messages"]) // 2
        return f"Thought: let me see.\nResponse: {MOVES[(request['seed'] + turn) % 4]}"

    return answer


RUN = ("study", "run", "study.toml", "--workers", "2")


def run_here(folder, *options, **environment):
    return llf(*RUN, *options, cwd=folder, LLF_LLM_API_KEY=KEY, **environment)


def run_apart(folder, *options, **environment):
    """Where all counts that is printed, by processes that play, too."""
    return llf_apart(*RUN, *options, cwd=folder, LLF_LLM_API_KEY=KEY, **environment)


def hits(server):
    return collections.Counter(json.dumps(request, sort_keys=True) for request in server.requests)


def cached(path):
    """What the cache holds, as the server sees requests."""
    with contextlib.closing(sqlite3.connect(path)) as db:
        requests = [json.loads(row[0]) for row in db.execute("SELECT request FROM answer")]
    for request in requests:
        del request["base_url"]
    return {json.dumps(request, sort_keys=True) for request in requests}


def test_a_study_that_is_killed_pays_nothing_twice(tmp_path):
    """What is in the cache at the kill is never asked for again; what was under way, one request a worker, may be."""
    workers, seeds = 2, amount(12, full=25)
    with ScriptedEndpoint(wanderer(0.02)) as server:
        study = STUDY.format(url=server.url).replace("seeds = 25", f"seeds = {seeds}")
        (tmp_path / "study.toml").write_text(study)
        command = [sys.executable, "-m", "llf_teacher", *RUN, "--store", "s.db"]
        environment, null = os.environ | {"LLF_LLM_API_KEY": KEY}, subprocess.DEVNULL
        process = subprocess.Popen(
            command, cwd=tmp_path, env=environment, stdout=null, stderr=null, start_new_session=True
        )
        while process.poll() is None and len(server.requests) < 4 * seeds:
            time.sleep(0.005)
        os.killpg(process.pid, signal.SIGKILL)  # the workers, too
        process.wait()
        time.sleep(0.2)  # the server notices
        before, kept = hits(server), cached(tmp_path / "s.llm.db")
        assert kept
        assert set(before.values()) == {1}
        assert kept <= set(before)
        assert len(before) - len(kept) <= workers
        done = len(rows(tmp_path / "s.db")[0])
        assert done < 2 * seeds

        result = run_here(tmp_path, "--store", "s.db", "--report", "r.html")
        assert result.returncode == 0, result.stderr
        assert f"Played {2 * seeds - done} episodes" in result.stderr
        after = hits(server)
        assert all(after[request] == 1 for request in kept)
        assert sum(after.values()) == len(after) + sum(after[request] - 1 for request in set(before) - kept)
        assert sum(after.values()) <= len(after) + workers
        assert cached(tmp_path / "s.llm.db") == set(after)

        asked = len(server.requests)
        with Store(tmp_path / "whole.db") as store:
            environment = {"LLF_LLM_CACHE": str(tmp_path / "s.llm.db")}
            assert (
                play_missing(load_study(tmp_path / "study.toml"), store, workers, environment=environment) == 2 * seeds
            )
        assert len(server.requests) == asked, "a study from the cache asks nothing"
    assert rows(tmp_path / "whole.db") == rows(tmp_path / "s.db")
    assert len(rows(tmp_path / "s.db")[0]) == 2 * seeds
    assert set(server.keys) == {f"Bearer {KEY}"}
    assert files_with(KEY, tmp_path) == []
    (spent,) = spending(f"{tmp_path / 's.llm.db'}")
    assert len(before) - len(kept) <= spent["lost"] <= workers, "what was under way may have been paid"
    assert spent["requests"] == spent["sent"] == len(after) + spent["lost"]
    assert f"m: {spent['requests']} requests paid so far" in result.stderr
    report = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert "Answers of language models that were paid for" in report
    assert f"<td>{spent['requests']}</td>" in report
    assert "Prompt system.j2" in report


def test_a_limit_stops_a_study_and_a_higher_one_goes_on(tmp_path):
    with ScriptedEndpoint(wanderer()) as server:
        (tmp_path / "study.toml").write_text(STUDY.format(url=server.url).replace("seeds = 25", "seeds = 5"))
        stopped = run_here(tmp_path, "--llm-budget", "8")
        assert stopped.returncode == 1
        assert "llf: the spending limit of 8 USD is reached" in stopped.stderr
        assert "raise it (--llm-budget) to go on" in stopped.stderr
        assert "Traceback" not in stopped.stderr
        spent = [usd for _, _, usd in ledger(tmp_path / "study.llm.db")]
        assert 8 - 2 * 3.6 < sum(spent) <= 8, "never exceeded, and not left by more than two answers could cost"
        played = len(rows(tmp_path / "study.db")[0])
        assert 0 < played < 10

        again = run_here(tmp_path, "--workers", "1", LLF_LLM_BUDGET="8")
        assert again.returncode == 1
        assert sum(usd for _, _, usd in ledger(tmp_path / "study.llm.db")) <= 8
        played = len(rows(tmp_path / "study.db")[0])
        finished = run_here(tmp_path, "--workers", "1", "--llm-budget", "1000")
        assert finished.returncode == 0, finished.stderr
        assert f"Played {10 - played} episodes" in finished.stderr
    assert set(hits(server).values()) == {1}


def test_a_limit_stops_the_suite(tmp_path):
    with ScriptedEndpoint(wanderer()) as server:
        student = f"llm(model='m', base_url='{server.url}', answer='text', input_price=1000, output_price=1000)"
        options = ("--student", student, "--quick", "--only", "advice", "--workers", "1", "--llm-budget", "5")
        stopped = llf("suite", *options, cwd=tmp_path, LLF_LLM_API_KEY=KEY)
    assert stopped.returncode == 1
    assert "llf: the spending limit of 5 USD is reached" in stopped.stderr
    assert "The episodes so far are in llf-suite.db; the next run goes on from there." in stopped.stderr
    assert "Traceback" not in stopped.stderr


def test_a_suite_that_is_interrupted_names_the_command_that_goes_on_and_asks_nothing_twice(tmp_path):
    """What was under way, one request a worker, may be asked again."""
    workers, null = 2, subprocess.DEVNULL
    with ScriptedEndpoint(wanderer(0.05)) as server:
        student = f"llm(model='m', base_url='{server.url}', max_tokens=30, answer='text')"
        options = ("suite", "--student", student, "--quick", "--only", "advice", "--workers", f"{workers}")
        process = subprocess.Popen(
            [sys.executable, "-m", "llf_teacher", *options], cwd=tmp_path, stdout=null, stderr=subprocess.PIPE,
            env=os.environ | {"LLF_LLM_API_KEY": KEY}, start_new_session=True, text=True,
        )  # fmt: skip
        while process.poll() is None and len(server.requests) < 40:
            time.sleep(0.01)
        os.killpg(process.pid, signal.SIGINT)
        _, said = process.communicate(timeout=60)
        assert process.returncode == 130, said
        assert "a turn takes 0." in " ".join(said.split())
        assert "Interrupted. The episodes so far are in llf-suite.db; the same command goes on:\nllf suite --st" in said
        assert "Traceback" not in said
        before, kept = hits(server), cached(tmp_path / "llf-suite.llm.db")
        assert len(before) - len(kept) <= workers
        finished = llf(*options, cwd=tmp_path, LLF_LLM_API_KEY=KEY)
        assert finished.returncode == 1, finished.stderr  # the student hears nothing, so that nothing is measured
        assert "othing was measured" in finished.stdout
        after = hits(server)
    assert all(after[request] == 1 for request in kept)
    assert sum(after.values()) <= len(after) + workers


def test_a_broken_endpoint_is_one_line_without_the_key(tmp_path):
    reply = Reply(404, json.dumps({"error": {"message": f"no such model for {KEY}"}}))
    with ScriptedEndpoint(lambda request: reply) as server:
        (tmp_path / "study.toml").write_text(STUDY.format(url=server.url))
        result = run_apart(tmp_path)
    assert result.returncode == 1
    assert "failed: http://127.0.0.1" in result.stderr
    assert "no such model for ***" in result.stderr
    assert "Traceback" not in result.stderr
    assert KEY not in result.stderr + result.stdout
    assert files_with(KEY, tmp_path) == []


def test_a_model_that_repeats_the_key(tmp_path):
    """It cannot know the key, but an endpoint could."""
    with ScriptedEndpoint(lambda request: f"Thought: {KEY}\nResponse: {KEY}") as server:
        (tmp_path / "study.toml").write_text(STUDY.format(url=server.url).replace("seeds = 25", "seeds = 1"))
        result = run_apart(tmp_path, OPENAI_LOG="debug")
    assert result.returncode == 0, result.stderr
    assert files_with("***", tmp_path)
    assert KEY not in result.stderr + result.stdout
    assert files_with(KEY, tmp_path) == []


def test_a_slow_endpoint_serves_several_workers_at_once(tmp_path):
    """`--workers` is the number of requests under way."""
    under_way, most, lock, workers = [0], [0], threading.Lock(), amount(2, full=4)

    def answer(request):
        with lock:
            under_way[0] += 1
            most[0] = max(most[0], under_way[0])
        time.sleep(0.1)
        with lock:
            under_way[0] -= 1
        return NORTH

    with ScriptedEndpoint(answer) as server:
        (tmp_path / "study.toml").write_text(STUDY.format(url=server.url).replace("seeds = 25", "seeds = 5"))
        result = run_here(tmp_path, "--workers", f"{workers}")
    assert result.returncode == 0
    assert 2 <= most[0] <= workers
