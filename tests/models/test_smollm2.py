"""SmolLM2-135M behind llama.cpp: a lesson and a quick study, from the commands that a user types."""

import json
import os
import signal

import numpy as np
import pytest
from commands import llf, llf_apart
from local_models import ends, gguf

import llf_teacher
from llf_teacher.models import LLMError, NoAnswerError
from llf_teacher.models.cache import spending
from llf_teacher.models.local import catalogue, endpoint
from llf_teacher.models.local.server import servers
from llf_teacher.models.model import Model, ModelSettings
from llf_teacher.speakers.llm_teacher import LLMTeacher
from llf_teacher.students.conversation import Conversation
from llf_teacher.studies import load
from llf_teacher.suite import take
from pz_envs.text.answer_formats import THOUGHT
from pz_envs.text.message_formats import FEW_CLAIMS

STUDENT = "llm(model='local:smollm2-135m', history=2)"
STUDY = f"""
ids = ["llf-gridworld-v0"]
teachers = ["oracle", "silent"]
students = ["{STUDENT}"]
feedback_types = ["fp"]
seeds = 2
max_turns = 2
"""
IDS = (
    "llf-gridworld-v0",
    "llf-bandits-BanditTenArmedGaussian-v0",
    "llf-poem-Haiku-v0",
    "llf-poem-LineSyllableConstrainedPoem-v0",
    "llf-poem-SyllableConstrainedPoem-v0",
    "llf-reco-movie-v0",
    "llf-optimization-McCormick-v0",
    "llf-highway-parking-v0",
    "llf-alfworld-v0",
    "llf-metaworld-reach-v3",
)
ASK = [{"role": "user", "content": "Say hello."}]


@pytest.fixture(autouse=True)
def model(monkeypatch):
    """The model; its server is left behind at the end."""
    monkeypatch.setenv("LLF_CACHE", os.environ["LLF_TEST_MODELS"])
    yield catalogue.find(catalogue.resolved("local:smollm2-135m"))
    for each in endpoint._connected.values():
        if each._lease is not None:
            each._lease.close()
    endpoint._connected.clear()
    assert all(ends(running.pid) for _, running in servers())


def answer(messages, **settings):
    asked = Model(ModelSettings(model="local:smollm2-135m", **settings))
    return asked.answer(messages)


def test_a_lesson_is_played():
    done = llf("play", "llf-gridworld-v0", "--student", STUDENT, "--seed", "3", "--max-turns", "2")
    assert done.returncode == 0, done.stderr
    for part in ("answers: {", "action: ", "[✓ true]: ", "Over after "):
        assert part in done.stdout


def test_a_study_is_played_and_recomputed_without_a_server(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    done = llf_apart("study", "run", "study.toml", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    with load(tmp_path / "study.db") as played:
        before = sorted(played.rows(), key=lambda row: row["key"])
        assert (
            played.manifest["students"][before[0]["student"]]["model"]["sha256"]
            == catalogue.KNOWN["smollm2-135m"].sha256
        )
        assert "xllamacpp" in played.manifest["versions"]
    assert {row["parse_failures"] for row in before} == {0}  # answers are constrained
    asked = sum(row["answers"] for row in before)
    assert asked == sum(row["turns"] for row in before)
    cache = f"{tmp_path / 'study.llm.db'}"
    again = llf("study", "run", "study.toml", "--store", "again.db", cwd=tmp_path, LLF_LLM_CACHE=cache)
    assert again.returncode == 0, again.stderr
    with load(tmp_path / "again.db") as recomputed:
        assert sorted(recomputed.rows(), key=lambda row: row["key"]) == before
    assert not endpoint._connected or all(each._lease is None for each in endpoint._connected.values())


def test_the_suite_says_how_long_it_takes_and_goes_on(tmp_path, monkeypatch):
    """It is ended after the measurement: two lessons of five turns."""

    def stop(outlook):
        outlooks.append(outlook)
        raise KeyboardInterrupt

    outlooks, spent = [], []
    monkeypatch.setenv("LLF_LLM_CACHE", f"{tmp_path / 'answers.db'}")
    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            take(STUDENT, tmp_path / "it.db", (), quick=True, announce=stop)
        spent.append(sum(each["requests"] for each in spending(f"{tmp_path / 'answers.db'}")))
    assert spent[0] >= 10
    assert spent[1] == spent[0]  # the second run knows the speed from the first
    for each in outlooks:
        assert "advice" in each.names
        assert each.episodes >= 16
        assert each.seconds > 5 * min(each.turn_seconds.values()) > 0


@pytest.mark.parametrize("id", IDS)
def test_its_grammar_keeps_the_schema_of_each_family(id):
    """Also at a temperature at which it talks nonsense."""
    env = llf_teacher.make(id, text=True)
    observation, _ = env.reset(seed=1)
    settings = ModelSettings(model="local:smollm2-135m", temperature=1.5, extra={"top_k": 0})
    asked = Model(settings, np.random.default_rng(0))
    talk = Conversation(env, answer=asked.form("auto").name)
    assert talk.form == "json"
    said = asked.answer(talk.ask(observation), talk.options, talk.most_tokens)
    action = talk.answer(said.split, cut=said.finish == "length")
    assert said.finish == "stop"
    assert env.step(action)[-1].get("parse_failure") is None
    assert len(talk.thought) <= THOUGHT


def test_a_model_teaches():
    teacher = "llm_teacher(model='local:smollm2-135m')"
    done = llf(
        "play", "llf-gridworld-v0", "--student", "random", "--teacher", teacher, "--seed", "3", "--max-turns", "1"
    )
    assert done.returncode == 0, done.stderr
    assert "The teacher's model gave 2 answers: " in done.stdout
    assert "cut at max_tokens" not in done.stdout


@pytest.mark.parametrize("id", IDS)
def test_its_grammar_keeps_the_schema_of_each_familys_claims(id):
    """Also at a temperature at which it talks nonsense, and without the claims that it could copy."""
    teacher = LLMTeacher("local:smollm2-135m", temperature=1.5, extra={"top_k": 0}, knows="nothing")
    policy = teacher.arguments()["teacher"]
    env = llf_teacher.make(id, teacher=policy)
    env.reset(seed=1)
    env.step(env.unwrapped.session.world.sample_action(np.random.default_rng(0)))
    assert policy.reply.form == "json"
    assert policy.reply.finish == "stop"
    said = json.loads(policy.reply.answer)["claims"]
    assert len(said) <= FEW_CLAIMS
    assert {each["type"] for each in said} <= set(env.unwrapped.session.teacher_turns[0].vocabulary.classes)


def test_the_same_question_has_the_same_answer():
    first = answer(ASK, max_tokens=12)
    assert first.text
    assert first.usage.output_tokens <= 12
    assert answer(ASK, max_tokens=12).text == first.text


def test_what_does_not_fit_is_one_message(monkeypatch):
    monkeypatch.setenv("LLF_LOCAL_CONTEXT", "512")
    with pytest.raises(NoAnswerError, match=r"exceeds the available context size .* or set LLF_LOCAL_CONTEXT to more"):
        answer([{"role": "user", "content": "word " * 900}])


def test_a_server_that_is_killed_is_one_message():
    answer(ASK, max_tokens=2)
    ((_, running),) = servers()
    os.kill(running.pid, signal.SIGKILL)
    with pytest.raises(LLMError, match=r"ended while it was asked.*its log is"):
        answer([{"role": "user", "content": "Say goodbye."}], max_tokens=2)


def test_a_file_that_llama_cpp_cannot_load_is_one_message(tmp_path, monkeypatch):
    monkeypatch.setenv("LLF_CACHE", f"{tmp_path / 'cache'}")
    assert llf("models", "add", gguf(tmp_path / "empty.gguf")).returncode == 0
    with pytest.raises(LLMError, match=r"the server of the model 'empty' ended while it began: .*its log is"):
        Model(ModelSettings(model="local:empty")).answer(ASK)
