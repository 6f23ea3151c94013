"""The server of a local model: one for all its users, however they begin and end. A scripted engine is llama.cpp."""

import importlib.util
import os
import signal
import stat
import subprocess
import sys
from pathlib import Path

import pytest
from commands import llf, llf_apart
from local_models import ENGINE, ends, environment, gguf, lives, requests

from llf_teacher.models import LLMError, NoAnswerError
from llf_teacher.models.local import endpoint, memory, server
from llf_teacher.models.local.server import servers
from llf_teacher.models.model import Model, ModelSettings
from llf_teacher.studies import load
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.limits import Limits
from llf_teacher.studies.execution.runner import RunOptions, asks_here

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="local models need POSIX locks")
ASK = [{"role": "user", "content": "Go west."}]
STUDY = """
ids = ["llf-gridworld-v0"]
teachers = ["oracle"]
students = ["llm(model='local:tiny')"]
feedback_types = ["fp"]
seeds = 4
max_turns = 3
"""


@pytest.fixture
def tiny(tmp_path, monkeypatch, no_settings):
    """A model on a machine of its own, whose servers end at once without users."""
    folder = tmp_path / "cache"
    for name, value in environment(folder).items():
        monkeypatch.setenv(name, value)
    monkeypatch.syspath_prepend(f"{ENGINE}")
    monkeypatch.setattr(server, "LINGER", 0.1)
    path = gguf(tmp_path / "tiny.gguf")
    assert llf("models", "add", path).returncode == 0
    yield path
    leave()
    assert all(ends(running.pid) for _, running in servers())


def leave():
    """End what this process uses."""
    for each in endpoint._connected.values():
        if each._lease is not None:
            each._lease.close()
    endpoint._connected.clear()


def model(name="tiny", **settings):
    return Model(ModelSettings(model=f"local:{name}", **settings))


def one():
    """The server that runs."""
    ((_, running),) = servers()
    return running


USER = """
import sys
from llf_teacher.models.local import server
from llf_teacher.models.model import Model, ModelSettings
server.LINGER = 0.1
model = Model(ModelSettings(model="local:tiny"))
print(model.answer([{"role": "user", "content": f"Go {sys.argv[1]}."}]).text, flush=True)
sys.stdin.read()
"""


def user(way):
    """Another process that asks the model and stays."""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    return subprocess.Popen([sys.executable, "-c", USER, way], **pipes)


def test_a_server_is_started_shared_and_ended(tiny):
    users = [user(way) for way in ("east", "south", "west")]  # all at once
    try:
        assert [each.stdout.readline().strip() for each in users] == [
            f"Response: {w}" for w in ("east", "south", "west")
        ]
        running = one()
        assert model().answer(ASK).text == "Response: west"
        assert one() == running
        assert "runs, process" in llf("models", COLUMNS="200").stdout
        leave()
        users[0].kill()  # however they end
        users[1].communicate("")
        users[0].wait()
        assert lives(running.pid)
        os.kill(users[2].pid, signal.SIGKILL)
        users[2].wait()
        assert ends(running.pid)
        assert not servers()
    finally:
        for each in users:
            each.kill()
            each.communicate()
    assert (server.folder_of(resolved_digest()) / "server.log").read_text().count("== ") == 1


def resolved_digest():
    from llf_teacher.models.local.catalogue import digest_of, resolved

    return digest_of(resolved("local:tiny"))


def test_a_server_whose_starter_dies_while_it_loads_ends_or_serves_the_next(tiny, monkeypatch):
    monkeypatch.setenv("SCRIPTED_LOAD", "1")
    first = user("east")
    settings = server.folder_of(resolved_digest()) / "server.lock"
    while not settings.exists() or not server.is_alive(settings.parent):
        assert first.poll() is None
    first.kill()
    first.communicate()
    assert model().answer(ASK).text == "Response: west"
    assert (settings.parent / "server.log").read_text().count("== ") == 1


def test_the_key_is_in_no_list_and_no_log(tiny):
    model().answer(ASK)
    running = one()
    folder = server.folder_of(resolved_digest())
    assert running.url.startswith("http://127.0.0.1:")
    assert running.key not in Path(f"/proc/{running.pid}/cmdline").read_text()
    assert running.key not in (folder / "server.log").read_text()
    assert running.key not in repr(running)
    for name in ("server.json", "settings.json"):
        assert stat.S_IMODE((folder / name).stat().st_mode) == 0o600


def test_the_key_and_address_of_others_are_not_sent(tiny, monkeypatch):
    monkeypatch.setenv("LLF_LLM_API_KEY", "sk-of-somebody-else")
    monkeypatch.setenv("LLF_LLM_BASE_URL", "http://127.0.0.1:9/v1")
    assert model().answer(ASK).text == "Response: west"


def test_an_answer_is_known_by_the_digest_wherever_it_was_given(tiny, tmp_path, monkeypatch):
    monkeypatch.setenv("LLF_LLM_CACHE", f"{tmp_path / 'answers.db'}")
    first = model().answer(ASK)
    leave()
    llf("models", "add", tiny, "--name", "another-name")
    assert model("another-name").answer(ASK) == first  # on another port with another key
    assert len(requests(tiny)) == 1
    other = gguf(tmp_path / "other.gguf", end=b"other weights")
    llf("models", "add", other)
    model("other").answer(ASK)
    assert len(requests(other)) == 1


def in_order(rows):
    return sorted(rows, key=lambda row: row["key"])


def test_an_answer_that_is_known_needs_no_model(tiny, tmp_path, monkeypatch):
    (tmp_path / "study.toml").write_text(STUDY)
    run = ("study", "run", "study.toml", "--workers", "2")
    assert llf(*run, cwd=tmp_path).returncode == 0
    with load(tmp_path / "study.db") as played:
        before = in_order(played.rows())
    leave()
    spec = before[0]["student"]
    (tmp_path / "study.toml").write_text(STUDY.replace("llm(model='local:tiny')", spec))
    tiny.unlink()
    again = llf(*run, "--store", "again.db", cwd=tmp_path, LLF_LLM_CACHE=f"{tmp_path / 'study.llm.db'}")
    assert again.returncode == 0, again.stderr
    with load(tmp_path / "again.db") as recomputed:
        assert in_order(recomputed.rows()) == before
    assert "cannot be read" in llf(*run, "--store", "third.db", cwd=tmp_path).stderr


def test_a_server_that_dies_is_one_message_and_the_study_goes_on(tiny, tmp_path):
    """It asks nothing twice but what was under way."""
    (tmp_path / "study.toml").write_text(STUDY)
    run = ("study", "run", "study.toml", "--workers", "1")
    done = llf_apart(*run, cwd=tmp_path, SCRIPTED_DEATH="5")
    assert done.returncode == 1
    said = " ".join(done.stderr.split())
    assert (
        "the server of the local model 'tiny' ended while it was asked, perhaps for want of memory; its log is" in said
    )
    assert said.count("ended while it was asked") == 1
    assert "Traceback" not in said
    asked = len(requests(tiny))
    assert asked == 5
    whole = llf_apart(*run, cwd=tmp_path)
    assert whole.returncode == 0, whole.stderr
    texts = [f"{request}" for request in requests(tiny)]
    assert len(texts) - len(set(texts)) == 1


def test_a_server_that_died_is_started_again_in_the_same_process(tiny, monkeypatch):
    monkeypatch.setattr(endpoint, "PAUSE", 0.0)
    asked = model()
    asked.answer(ASK)
    os.kill(one().pid, signal.SIGKILL)
    with pytest.raises(LLMError, match="ended while it was asked"):
        asked.answer([{"role": "user", "content": "Go east."}])
    assert model().answer(ASK).text == "Response: west"
    assert model().answer([{"role": "user", "content": "Go south."}]).text == "Response: south"


def test_a_model_that_llama_cpp_refuses_is_one_message(tiny, tmp_path):
    llf("models", "add", gguf(tmp_path / "bad.gguf", end=b"broken"))
    with pytest.raises(
        LLMError, match=r"the server of the model 'bad' ended while it began: .*Failed to init server.*its log is"
    ):
        model("bad").answer(ASK)


def test_a_model_that_is_too_large_is_refused_before_it_starts(tiny, monkeypatch):
    model().answer(ASK)
    monkeypatch.setattr(memory, "available", lambda: 300_000_000)
    other = gguf(tiny.with_name("large.gguf"), end=b"large")
    llf("models", "add", other)
    said = (
        r"the model 'large' needs about \d+ MB of memory with 2 slots of 4096 tokens, and 300 MB are available; set "
        r"LLF_LOCAL_CONTEXT or LLF_LOCAL_SLOTS to a smaller number, or take a smaller model; 1 other local models run"
    )
    with pytest.raises(LLMError, match=said):
        model("large").answer(ASK)
    assert len(servers()) == 1
    assert model().answer([{"role": "user", "content": "Go south."}]).text == "Response: south"  # which runs already


def test_a_context_that_is_too_short_is_one_message(tiny, monkeypatch):
    monkeypatch.setenv("LLF_LOCAL_CONTEXT", "256")
    asked = model()
    with pytest.raises(NoAnswerError, match="a smaller max_prompt_tokens; or set LLF_LOCAL_CONTEXT to more than 256"):
        asked.answer([{"role": "user", "content": "word " * 300}])
    assert asked.answer(ASK).text == "Response: west"
    leave_to = server.ServerLease(endpoint.find(ModelSettings(model="local:tiny").model))
    monkeypatch.setenv("LLF_LOCAL_CONTEXT", "512")
    with pytest.raises(ValueError, match=r"runs with LLF_LOCAL_CONTEXT=256, got 512; unset LLF_LOCAL_CONTEXT, or end"):
        leave_to.running()
    leave_to.close()


def test_without_llama_cpp_the_command_to_install_it_is_shown(tiny, monkeypatch):
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "xllamacpp" else find(name))
    with pytest.raises(
        LLMError, match=r"local models need 'xllamacpp', which is not installed; run: pip install 'llf-t"
    ):
        model().answer(ASK)


def test_threads_play_students_of_local_models(tiny):
    students = ["llm(model='local:tiny') | forgetful(half_life=2)", "random"]
    study = Study(ids=["llf-gridworld-v0"], teachers=["oracle"], students=students, seeds=1)
    assert asks_here(study, study.students)
    assert not asks_here(study, ["random"])
    teaching = Study(
        ids=["llf-gridworld-v0"], teachers=["llm_teacher(model='local:tiny')"], students=["random"], seeds=1
    )
    assert asks_here(teaching, teaching.students)
    assert RunOptions().engine(None, True) == "threads"
    assert RunOptions(limits=Limits(5.0, None, None)).engine(None, True) == "processes"
    assert RunOptions("ray").engine(None, True) == "ray"


def test_a_student_is_watched(tiny):
    watch = ("play", "llf-gridworld-v0", "--feedback-type", "fp", "--seed", "3", "--max-turns", "2")
    done = llf(*watch, "--student", "llm(model='local:tiny')")
    assert done.returncode == 0, done.stderr
    told = done.stdout
    assert "The student's model is asked for answers as json." in told
    assert '"action": "east"}' in told
    assert "action: east" in told
    assert "teacher, advice [✓ true]: Now head east." in told
    assert "Over after 2 turns" in told


def test_a_model_teaches(tiny):
    done = llf("play", "llf-gridworld-v0", "--student", "random", "--teacher",
               "llm_teacher(model='local:tiny', says='words')", "--seed", "3", "--max-turns", "2")  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "teacher, words [unchecked]: Response:" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--seat", "student", "--student", "random"), "with --seat student you are the student"),
        (("--student", "random", "--bits", "3"), "are for your own seat"),
        (("--student", "randon"), "did you mean random"),
    ],
)
def test_what_a_watcher_cannot_ask_is_refused(arguments, said, no_settings):
    assert said in llf("play", "llf-gridworld-v0", *arguments).stderr
