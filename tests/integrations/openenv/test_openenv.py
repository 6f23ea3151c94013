"""OpenEnv serves our environments: its own checks, its client and its web page, against a server that runs here."""

import json
import os
import shutil
import socket
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
import requests
import yaml
from openenv import GenericEnvClient
from openenv.cli._cli_utils import validate_env_structure

import llf_teacher
from llf_teacher.integrations import openenv as ours
from llf_teacher.integrations.openenv import FeedbackEnv, graders
from llf_teacher.integrations.openenv.environment import FeedbackServerEnvironment
from llf_teacher.integrations.openenv.models import FeedbackAction
from llf_teacher.registry import entry

GRID = "llf-gridworld-v0"
FOLDER = Path(ours.__file__).parent
DECLARED = yaml.safe_load((FOLDER / "openenv.yaml").read_text())
OPENENV = Path(sys.executable).with_name("openenv")


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    url = f"http://127.0.0.1:{port}"
    command = [sys.executable, "-m", "uvicorn", DECLARED["app"], "--port", f"{port}", "--log-level", "warning"]
    log = tmp_path_factory.mktemp("server") / "log"
    with log.open("w") as file:
        environment = os.environ | {"ENABLE_WEB_INTERFACE": "true", "GRADIO_ANALYTICS_ENABLED": "False"}
        process = subprocess.Popen(command, env=environment, stdout=file, stderr=file, cwd=log.parent)
    try:
        for _ in range(600):
            assert process.poll() is None, log.read_text()
            try:
                requests.get(f"{url}/health", timeout=1)
                break
            except requests.ConnectionError:
                time.sleep(0.2)
        yield url
    finally:
        process.terminate()
        process.wait(20)


def test_their_validation_passes_all_six(server):
    command = [OPENENV, "validate", "--url", server, "--json"]
    result = subprocess.run(command, capture_output=True, text=True, timeout=100, check=False)
    report = json.loads(result.stdout)
    assert result.returncode == 0
    assert report["passed"] is True
    assert (report["summary"]["passed_count"], report["summary"]["total_count"]) == (6, 6)


def test_an_episode_is_that_of_make(server):
    env = llf_teacher.make(GRID, text=True, teacher="mistake(eps=0.5)", feedback_type="fp", max_turns=6)
    expected, _ = env.reset(seed=7)
    with GenericEnvClient(base_url=server).sync() as client:
        seen = client.reset(seed=7, id=GRID, teacher="mistake(eps=0.5)", feedback_type="fp", max_turns=6)
        assert {name: seen.observation[name] for name in expected} == expected
        for action in ("north", "fly", "west", "south", "east", "north"):
            expected, reward, terminated, truncated, _ = env.step(action)
            seen = client.step({"text": action})
            assert {name: seen.observation[name] for name in expected} == expected
            assert (seen.reward, seen.done) == (reward, terminated or truncated)
        assert seen.done
        assert client.state()["step_count"] == 6


def test_the_typed_client(server):
    with FeedbackEnv(base_url=server).sync() as client:
        seen = client.reset(seed=7, id=GRID, teacher="oracle", max_turns=2)
        assert "treasure" in seen.observation.instruction
        assert not seen.done
        seen = client.step(FeedbackAction(text="fly"))
        assert seen.observation.metadata["failure"] == "it names no action that there is"
        seen = client.step(FeedbackAction(text="north"))
        assert seen.observation.feedback
        assert (seen.done, seen.observation.done, seen.reward) == (True, True, seen.observation.reward)
        assert client.state().step_count == 2


def test_the_client_is_a_package_of_its_own(server, tmp_path):
    """Without the rest of llf_teacher, as its `pyproject.toml` says."""
    shutil.copytree(FOLDER, tmp_path / "source")  # building leaves files behind
    where = ["--no-build-isolation", "-t", tmp_path, tmp_path / "source"]
    command = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", *where]
    subprocess.run(command, check=True, timeout=300)
    program = (
        "import sys; from llf_teacher_env import FeedbackAction, FeedbackEnv\n"
        "with FeedbackEnv(base_url=sys.argv[1]).sync() as env:\n"
        "    env.reset(id='llf-gridworld-v0', seed=7, teacher='oracle')\n"
        "    assert env.step(FeedbackAction(text='north')).observation.feedback\n"
        "assert 'llf_teacher' not in sys.modules and 'gymnasium' not in sys.modules\n"
    )
    environment = os.environ | {"PYTHONPATH": f"{tmp_path}"}
    subprocess.run([sys.executable, "-c", program, server], check=True, timeout=300, env=environment, cwd=tmp_path)


def test_the_graders(capsys):
    """The oracle is the ceiling, silence the floor, and whom a liar teaches ends nearer to it."""
    assert graders.main([GRID, "llf-poem-Haiku-v0", "llf-bandits-BanditTenArmedRandomFixed-v0"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == ["ok"] * 3
    found = graders.regrets(GRID)
    assert found["ceiling"] == 0
    assert graders.score(found["ceiling"], found) == 1
    assert graders.score(found["floor"], found) == 0


def test_a_helpful_liar_is_found_out(capsys, monkeypatch):
    monkeypatch.setitem(graders.ROLES, "canary", ("oracle", "text_only"))
    assert graders.main([GRID]) == 1
    assert capsys.readouterr().out.startswith(f"WRONG  {GRID}")


def test_the_canaries_are_paid_so(tmp_path):
    assert FOLDER / DECLARED["validation"]["capabilities"]["canaries"] == FOLDER / "canaries.jsonl"
    lines = [json.loads(line) for line in (FOLDER / "canaries.jsonl").read_text().splitlines()]
    assert {entry(each["id"]).family.name for each in lines} == {entry(id).family.name for id in llf_teacher.ids()}
    environment = FeedbackServerEnvironment()
    for each in lines:
        environment.reset(id=each["id"], seed=each["seed"], max_turns=each["max_turns"], teacher="silent")
        seen = [environment.step(FeedbackAction(text=f"{action}")) for action in each["actions"]]
        assert not any(step.metadata["failure"] for step in seen), each["id"]
        assert sum(step.reward for step in seen) == pytest.approx(each["reward"], abs=1e-6), each["id"]
    environment.close()


def test_the_image(tmp_path):
    """What its file says, without Docker: the command starts the declared server, the source is the extra."""
    lines = dict(line.split(" ", 1) for line in (FOLDER / "Dockerfile").read_text().splitlines() if line[:1] != "#")
    command = json.loads(lines["CMD"])
    assert command[:2] == ["uvicorn", DECLARED["app"]]
    assert command[-1] == f"{DECLARED['port']}" == lines["EXPOSE"]
    assert lines["ARG"] == 'LLF_TEACHER="llf-teacher[openenv]"'


def test_many_play_at_once(server):
    with GenericEnvClient(base_url=server).sync() as one, GenericEnvClient(base_url=server).sync() as other:
        rooms = [client.reset(seed=seed, id=GRID).observation["observation"] for client, seed in ((one, 1), (other, 2))]
        assert rooms[0] != rooms[1]
        assert one.step({"text": "nowhere"}).observation["observation"] == rooms[0]
        assert other.step({"text": "nowhere"}).observation["observation"] == rooms[1]


def test_tasks_have_splits(server):
    assert [each["name"] for each in requests.get(f"{server}/llf_teacher/splits", timeout=10).json()] == [
        "train",
        "test",
    ]
    environment = FeedbackServerEnvironment()
    ids = llf_teacher.ids()
    assert environment.num_tasks("test") == 1000 * len(ids)
    assert [task["id"] for task in environment.list_tasks("train")] == list(ids)
    place = ids.index(GRID)
    task = environment.get_task("test", place + 2 * len(ids))
    assert (task["id"], task["seed"]) == (GRID, 1_000_002)
    told = environment.reset(split="test", index=place + 2 * len(ids))
    assert told.observation == environment.reset(seed=1_000_002, id=GRID).observation
    assert environment.reset(seed=4).observation == environment.reset(seed=4, id=ids[0]).observation
    with pytest.raises(IndexError, match="index must be from 0 to"):
        environment.get_task("train", -1)
    with pytest.raises(ValueError, match="split must be one of train, test, got 'dev'"):
        environment.num_tasks("dev")


def test_the_web_page_answers(server):
    page = requests.get(f"{server}/web/", timeout=30)
    assert page.status_code == 200
    assert "gradio" in page.text.lower()
    begun = requests.post(f"{server}/web/reset", json={"seed": 3, "id": GRID}, timeout=30).json()
    assert "treasure" in begun["observation"]["instruction"]
    went = requests.post(f"{server}/web/step", json={"action": {"text": "north"}}, timeout=30).json()
    assert went["observation"]["feedback"]


def test_what_is_refused():
    environment = FeedbackServerEnvironment()
    with pytest.raises(RuntimeError, match="there is no episode; call reset before step"):
        environment.step(FeedbackAction(text="north"))
    with pytest.raises(ValueError, match="unknown personality 'llm_teacher'"):  # a model would be paid by the server
        environment.reset(teacher="llm_teacher(model='m')")
    with pytest.raises(ValueError, match="got 'os:system'; a server imports nothing for clients"):
        environment.reset(teacher="os:system")
    environment.reset(id=GRID, max_turns=1)
    assert environment.web_actions({})[0] == ("north", {"text": "north"})
    told = environment.step(FeedbackAction(text="fly"))
    assert told.metadata["failure"] == "it names no action that there is"
    environment.close()


def test_the_declaration():
    command = [OPENENV, "validate", FOLDER, "--level", "static"]
    validated = subprocess.run(command, capture_output=True, text=True, timeout=100, check=False)
    assert validated.returncode == 0
    assert "Verdict: PASS" in validated.stdout
    assert "WARN" not in validated.stdout
    assert validate_env_structure(FOLDER) == []
    assert DECLARED["name"] == FeedbackServerEnvironment().get_metadata().name
    assert llf_teacher.__version__.startswith(DECLARED["version"])
    least, greatest = DECLARED["validation"]["reward"]["range"]
    seen = Counter()
    for id in llf_teacher.ids():
        family = entry(id).family.name
        seen[family] += 1
        if seen[family] <= 8:  # one family has fifty, which differ in other things
            low, high = llf_teacher.make(id).reward_range
            assert least <= low < high <= greatest, id
