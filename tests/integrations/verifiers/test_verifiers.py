"""verifiers plays episodes with scripted models in one seat or both, and its traces say what came of them."""

import json
import os
import subprocess
import sys
from itertools import islice
from pathlib import Path

import pytest
from endpoints import obey
from verifiers.v1.cli.eval.main import main

from llf_teacher import chat_student
from llf_teacher.integrations.dialogue import SCORES
from llf_teacher.integrations.verifiers import LLFSeats, LLFSeatsConfig, LLFTaskset, LLFTasksetConfig
from llf_teacher.models.testing import ScriptedEndpoint
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play

MODULE = "from llf_teacher.integrations.verifiers import LLFHarness, LLFSeats, LLFTaskset, __all__\n"


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    """A module that verifiers finds by its name."""
    (tmp_path / "llf.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("SCRIPTED_KEY", "none")
    return tmp_path


def arguments(endpoint, folder, *more):
    where = ["--client.base-url", endpoint.url, "--client.api-key-var", "SCRIPTED_KEY", "-o", f"{folder}/out"]
    where += ["--env.taskset.env-ids", '["llf-gridworld-v0"]']
    return ["llf", "-m", "scripted", *where, "--no-push", "--no-rich", "--env.feedback-type", "fp", *more]


def traces(folder):
    """The traces of all episodes, by seat."""
    (path,) = Path(folder, "out").glob("*/traces.jsonl")
    found = {}
    for line in path.read_text().splitlines():
        record = json.loads(line)
        for trace in record.get("traces", [record]):
            assert trace["ok"], trace["errors"]
            found.setdefault(trace["agent"]["name"], []).append(trace)
    return found


def test_an_episode_is_that_of_a_study(home):
    """By the command, with a model behind an endpoint."""
    with ScriptedEndpoint(obey) as endpoint:
        command = [Path(sys.executable).with_name("vf-eval"), *arguments(endpoint, home, "-n", "2")]
        result = subprocess.run(
            command, env=os.environ | {"PYTHONPATH": f"{home}"}, capture_output=True, text=True, check=False
        )
    assert result.returncode == 0, result.stdout + result.stderr

    def answer(messages: list) -> str:
        return obey({"messages": messages})

    study = Study(ids=["llf-gridworld-v0"], teachers=["oracle"], students=[chat_student(answer)], seeds=2,
        feedback_types=["fp"], baseline="oracle")  # fmt: skip
    played = {spec.seed: play(spec).episode for spec in study.episodes()}
    found = {trace["task"]["data"]["seed"]: trace for trace in traces(home)["student"]}
    assert found.keys() == played.keys()
    for seed, trace in found.items():
        assert trace["rewards"]["return"]["score"] == played[seed].total_reward == 1
        scores = {name: value for name, value in trace["metrics"].items() if name in SCORES}
        assert scores == {name: getattr(played[seed], field) for name, field in SCORES.items() if name != "return"}
        assert len(trace["info"]["llf_teacher"]["turns"]) == played[seed].turns + 1


def teach(request):
    """A model for both seats: as the teacher it passes on what it knows."""
    if request["messages"][0]["content"].startswith("You teach a student"):
        known = request["messages"][-1]["content"].partition("What is known: ")[2].partition("\n\n")[0]
        return f"Listen! {known}"
    return obey(request)


def test_a_model_may_teach(home):
    with ScriptedEndpoint(teach) as endpoint:
        main(
            arguments(endpoint, home, "-n", "1", "--env.model-teaches", "--env.taskset.env-ids", '["llf-gridworld-v0"]')
        )
    found = traces(home)
    ((student,), (teacher,)) = found["student"], found["teacher"]
    assert student["metrics"]["success"] == teacher["metrics"]["success"] == 1
    assert teacher["rewards"]["return"]["score"] == 1
    opening, *turns = student["info"]["llf_teacher"]["turns"]
    assert opening["atoms"]
    assert all(turn["feedback"].startswith("Listen! ") and turn["atoms"] == [] for turn in turns)
    asked = [request["messages"] for request in endpoint.requests]
    assert "The student was told this:" in asked[1][0]["content"]
    assert "Teacher: Listen!" in asked[2][-1]["content"]


def test_a_limit_of_verifiers_ends_the_episode(home):
    with ScriptedEndpoint(lambda request: "Response: north") as endpoint:
        limits = ["--env.student.max-turns", "3", "--env.personality", "silent", "--env.reward", "regret"]
        main(arguments(endpoint, home, "-n", "1", *limits))
    (trace,) = traces(home)["student"]
    assert trace["metrics"]["turns"] == 3
    assert trace["rewards"]["regret"]["score"] > 0
    assert len(endpoint.requests) == 3


def test_tasks_are_seeds_of_environments():
    ids = ["llf-gridworld-v0", "verbal-poem-Haiku-v0"]
    tasks = LLFTaskset(LLFTasksetConfig(id="llf", env_ids=ids, first_seed=5)).take(3)
    assert [task.data.name for task in tasks] == ["llf-gridworld-v0:5", "llf-poem-Haiku-v0:5", "llf-gridworld-v0:6"]
    with pytest.raises(ValueError, match="gridworl"):
        next(islice(LLFTaskset(LLFTasksetConfig(id="llf", env_ids=["llf-gridworl-v0"])), 1, None))


def test_no_mean_is_over_units_of_families(home):
    ids = '["llf-gridworld-v0", "llf-bandits-BanditTenArmedRandomFixed-v0"]'
    with ScriptedEndpoint(obey) as endpoint:
        main(arguments(endpoint, home, "-n", "2", "--env.max-turns", "2", "--env.taskset.env-ids", ids))
    for trace in traces(home)["student"]:
        assert trace["rewards"].keys() == {"success"}
        assert not {"return", "regret"} & trace["metrics"].keys()
        assert {"turns", "parse_failures", "said_fp"} <= trace["metrics"].keys()
        assert {"return", "regret"} < trace["info"]["llf_teacher"]["scores"].keys()
    for reward in ("return", "regret"):
        with pytest.raises(
            ValueError, match=r"reward must be success for environments of several families \(alfworld, "
        ):
            LLFSeats(LLFSeatsConfig(taskset={"id": "llf"}, reward=reward))
    LLFSeats(LLFSeatsConfig(taskset={"id": "llf", "env_ids": ["llf-gridworld-v0"]}, reward="regret"))


def test_a_reward_is_a_score():
    with pytest.raises(ValueError, match=r"reward must be one of success, return, regret, .*, got 'retrun'"):
        LLFSeats(LLFSeatsConfig(taskset={"id": "llf"}, reward="retrun"))
