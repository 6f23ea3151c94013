"""Inspect plays its tasks with a scripted model, and its logs say what came of them."""

import inspect
import math
import os
import re
import subprocess
import sys
from importlib.metadata import requires
from statistics import mean

import pytest
from endpoints import heard, obey
from inspect_ai import eval as play_tasks
from inspect_ai import eval_set
from inspect_ai.log import list_eval_logs, read_eval_log
from inspect_ai.model import ModelOutput, ModelUsage, get_model
from inspect_ai.model._providers import providers
from packaging.requirements import Requirement

from llf_teacher import chat_student
from llf_teacher.integrations.dialogue import SCORES
from llf_teacher.integrations.inspect import STORED, TASKS, suite
from llf_teacher.models.testing import ScriptedEndpoint
from llf_teacher.registry import family
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.suite import take
from pz_envs.family import all_families


def scripted(answer=obey):
    """Inspect's own scripted model; without usage it would load a tokenizer to count."""

    def output(messages, tools, tool_choice, config):
        request = {"messages": [{"content": message.text} for message in messages]}
        made = ModelOutput.from_content("mockllm/model", answer(request))
        made.usage = ModelUsage(input_tokens=7, output_tokens=3, total_tokens=10)
        return made

    return get_model("mockllm/model", custom_outputs=output, memoize=False)


def metrics(log):
    """The values of the metrics of each score."""
    return {score.name: {name: metric.value for name, metric in score.metrics.items()} for score in log.results.scores}


def run(folder, *tasks, model=None, **settings):
    logs = play_tasks(list(tasks), model=model or scripted(), log_dir=f"{folder}", display="none", **settings)
    assert [log.status for log in logs] == ["success"] * len(tasks), [log.error for log in logs]
    return logs


def test_every_family_has_a_task():
    assert set(TASKS) == {family.name for family in all_families()} | {"gym"}


def test_environments_of_the_registry_are_played(tmp_path):
    """One whose teacher knows values, and one whose teacher knows none."""

    def walk(request):
        told = heard(request).lower()
        return next((word for word in re.findall(r"[a-z]+", told) if word in ("left", "down", "right", "up")), "0")

    lake = TASKS["gym"](ids="gym:FrozenLake-v1", options={"is_slippery": False}, seeds=2, feedback_type="fp")
    pole = TASKS["gym"](ids=["gym:CartPole-v1"], options={"oracle": "rewards"}, seeds=1, max_turns=3)
    first, second = play_tasks([lake, pole], model=scripted(walk), log_dir=f"{tmp_path}", display="none")
    assert metrics(first)["success"]["mean"] == 1
    assert metrics(first)["regret"]["mean"] == 0
    assert first.eval.metadata["max_turns"] == 100
    assert metrics(second)["regret"]["mean"] == -3
    with pytest.raises(ValueError, match=r"ids must have environments of Gymnasium's registry, .* got none"):
        TASKS["gym"]()
    with pytest.raises(ValueError, match="ids must be of the family gym, got llf-gridworld-v0, which is of gridworld"):
        TASKS["gym"](ids="llf-gridworld-v0")


def test_scores_are_those_of_a_study(tmp_path):
    (log,) = run(tmp_path, TASKS["gridworld"](seeds=3, first_seed=2))

    def answer(messages: list) -> str:
        return obey({"messages": messages})

    study = Study(ids=["llf-gridworld-v0"], teachers=["oracle"], students=[chat_student(answer)], seeds=[2, 3, 4],
        baseline="oracle")  # fmt: skip
    played = [play(spec).episode for spec in study.episodes()]
    assert [sample.scores["outcome"].value["regret"] for sample in log.samples] == [each.regret for each in played]
    assert [sample.scores["outcome"].value["turns"] for sample in log.samples] == [each.turns for each in played]
    for name, field in SCORES.items():
        assert metrics(log)[name]["mean"] == pytest.approx(mean(getattr(each, field) for each in played)), name


def take_advice(request):
    """Obeys the last sentence but one, which advises where the last one warns."""
    advice = " ".join(re.split(r"(?<=[.!]) ", heard(request).strip())[:-1])
    return obey({"messages": [{"content": f"Teacher: {advice}"}]})


def pull_what_was_named(request):
    """The arm that the last words name last, or the first."""
    arms = re.findall(r"\b\d\b", heard(request))
    return f"Response: {arms[-1] if arms else 0}"


@pytest.mark.parametrize(
    ("only", "model", "measured"),
    [("advice", pull_what_was_named, True), ("voice", take_advice, True), ("voice", obey, False)],
    ids=["advice", "voice", "what is not measured is no number"],
)
def test_the_suite_has_the_scores_of_a_card(tmp_path, only, model, measured):
    """Of one experiment, with another voice, and of the quick suite's."""

    def answer(messages: list) -> str:
        return model({"messages": messages})

    store = f"{tmp_path / 'suite.db'}"
    (log,) = run(tmp_path, suite(only=only, quick=True, store=store), model=scripted(model))
    (line,) = take(chat_student(answer), store, [only], quick=True, workers=1).lines
    found = metrics(log)["regret"][only]
    assert measured == (line.score is not None)
    if measured:
        assert found == pytest.approx(line.score)
        assert 0 < line.score <= 1.5
    else:
        assert math.isnan(found)


def test_scores_have_intervals_over_seeds(tmp_path):
    ids = ["llf-bandits-BanditTwoArmedHighLowFixed-v0", "llf-bandits-BanditTenArmedGaussian-v0"]
    (log,) = run(tmp_path, TASKS["bandits"](ids=ids, seeds=4, max_turns=3))
    assert len(log.samples) == 8
    found = metrics(log)
    assert set(found) == set(SCORES)
    by_seed = [
        mean(s.scores["outcome"].value["regret"] for s in log.samples if s.metadata["seed"] == seed)
        for seed in range(4)
    ]
    regret = found["regret"]
    assert regret["mean"] == pytest.approx(mean(by_seed))
    assert regret["ci_lower"] < regret["mean"] < regret["ci_upper"]
    half = 3.182446 * (sum((each - mean(by_seed)) ** 2 for each in by_seed) / 3 / 4) ** 0.5  # t of 3 degrees of freedom
    assert regret["ci_upper"] - regret["mean"] == pytest.approx(half, rel=1e-6)


def test_the_log_has_the_conversation_and_what_was_said(tmp_path):
    (log,) = run(tmp_path, TASKS["gridworld"](seeds=1, teacher="mistake(eps=1)", feedback_type="fp", max_turns=4))
    (sample,) = log.samples
    assert log.eval.task_args["teacher"] == "mistake(eps=1)"
    assert log.eval.metadata["regret_unit"] == family("gridworld").regret_unit
    turns = sample.store[STORED]["turns"]
    assert len(turns) == 5
    assert {atom["kind"] for turn in turns[1:] for atom in turn["atoms"]} == {"fp"}
    assert not any(atom["holds"] for turn in turns[1:] for atom in turn["atoms"])
    assert all(turn["input_tokens"] == 7 for turn in turns[1:])
    assert [message.role for message in sample.messages] == ["system", *["user", "assistant"] * 4]
    assert turns[2]["feedback"] in sample.messages[5].text


def test_what_a_limit_ends_is_scored(tmp_path):
    (log,) = run(tmp_path, TASKS["gridworld"](seeds=1, teacher="silent"), message_limit=6)
    (sample,) = log.samples
    assert sample.limit.type == "message"
    assert 0 < sample.scores["outcome"].value["turns"] < family("gridworld").max_turns


def test_an_eval_set_compares_teachers(tmp_path):
    tasks = [TASKS["gridworld"](teacher=teacher, feedback_type="fp", seeds=3) for teacher in ("oracle", "silent")]
    done, logs = eval_set(tasks, model=scripted(), log_dir=f"{tmp_path}", display="none")
    assert done
    regret = {log.eval.task_args["teacher"]: metrics(log)["regret"]["mean"] for log in logs}
    assert regret["oracle"] == 0 < regret["silent"]
    again, _ = eval_set(tasks, model=scripted(lambda request: 1 / 0), log_dir=f"{tmp_path}", display="none")
    assert again  # nobody is asked: it has been played


def test_a_task_is_of_its_family():
    with pytest.raises(
        ValueError, match="ids must be of the family bandits, got llf-gridworld-v0, which is of gridworld"
    ):
        TASKS["bandits"](ids="llf-gridworld-v0")


def test_the_named_install_brings_what_the_command_needs():
    """`--model openai/...` of the page: Inspect does not bring its client, and wants at least this version."""
    brought = {
        each.name
        for each in map(Requirement, requires("llf-teacher"))
        if each.marker and each.marker.evaluate({"extra": "inspect"})
    }
    assert {"inspect-ai", "openai"} <= brought
    least = re.search(r'MIN_VERSION = "(.*)"', inspect.getsource(providers.validate_openai_client))[1]
    (ours,) = [each for each in map(Requirement, requires("llf-teacher")) if f"{each}".startswith("openai>=3")]
    assert not ours.specifier.contains("3.3.9")
    assert ours.specifier.contains(least)


def test_the_command_finds_the_tasks(tmp_path):
    """By their names, with a model behind an endpoint."""
    with ScriptedEndpoint(obey) as endpoint:
        command = ["-m", "inspect_ai", "eval", "llf_teacher/gridworld", "--model", "openai-api/scripted/m"]
        settings = ["-T", "seeds=2", "-T", "teacher=oracle", "-T", "feedback_type=r,fp", "--display", "none"]
        result = subprocess.run(
            [sys.executable, *command, *settings, "--log-dir", f"{tmp_path}"],
            env=os.environ | {"SCRIPTED_BASE_URL": endpoint.url, "SCRIPTED_API_KEY": "none"},
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
        )
    assert result.returncode == 0, result.stderr
    (info,) = list_eval_logs(f"{tmp_path}")
    log = read_eval_log(info)
    assert log.status == "success", log.error
    assert log.eval.task == "llf_teacher/gridworld"
    assert metrics(log)["success"]["mean"] == 1
    assert {request["model"] for request in endpoint.requests} == {"m"}
    assert [sample.id for sample in log.samples] == ["llf-gridworld-v0:0", "llf-gridworld-v0:1"]
