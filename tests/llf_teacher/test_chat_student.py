"""A function is a student: for prompts or for messages, at once or awaited, by its name or as it is."""

import asyncio
import subprocess
import sys

import pytest

import llf_teacher
from llf_teacher import chat_student
from llf_teacher.episodes.record import pack_turns
from llf_teacher.students.chat import takes_messages
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play

MODULE = """
import asyncio

def by_prompt(prompt):
    return "Thought: why not.\\nResponse: west"

def by_messages(messages):
    assert messages[0]["role"] == "system"
    return f"Response: {['north', 'west'][len(messages) // 2 % 2]}"

def by_list(history: "list[dict[str, str]]") -> str:
    return by_messages(history)

async def slowly(prompt: str) -> str:
    await asyncio.sleep(0.001)
    return "<think>north?</think>Response: west"

def broken(prompt):
    return "Response: \\ud800"

def wrong(prompt):
    return 3

def two(prompt, temperature):
    return ""
"""


@pytest.fixture(autouse=True)
def _module(tmp_path, monkeypatch):
    (tmp_path / "chat_functions.py").write_text(MODULE)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "chat_functions", raising=False)


def study(student, **changes):
    return Study(ids=["llf-gridworld-v0"], teachers=["oracle"], students=[student], seeds=1, max_turns=3, **changes)


def record(student):
    return play(next(study(student).episodes()))


@pytest.mark.parametrize(
    ("name", "actions"),
    [
        ("by_prompt", ["2", "2", "2"]),
        ("by_messages", ["1", "0", "1"]),
        ("by_list", ["1", "0", "1"]),
        ("slowly", ["2", "2", "2"]),
    ],
)
def test_a_function_plays_in_a_study(name, actions):
    actions = [{"0": "0", "1": "2", "2": "2"}[action] for action in actions]
    played = record(f"chat:chat_functions:{name}")
    assert [turn.action for turn in played.turns[1:]] == actions
    assert (played.episode.reads, played.episode.parse_failures) == ("words", 0)


def test_a_lone_surrogate_loses_no_episode():
    played = record("chat:chat_functions:broken")
    assert played.episode.parse_failures == len(played.turns) - 1 == 3
    assert played.turns[1].parse_failure == "Response: ?"
    assert pack_turns(played.turns)


def test_a_function_may_change_the_messages_that_it_gets():
    """The record has what it was asked."""

    def plain(messages):
        return "north"

    def changing(messages):
        messages[0]["content"] = "Be brief."
        messages.append({"role": "assistant", "content": "north"})
        return "north"

    def asked(function):
        study = Study(
            ids=["llf-gridworld-v0"], teachers=["oracle"], students=[chat_student(function)], seeds=1, max_turns=3
        )
        return [turn.asked for turn in play(next(study.episodes())).turns]

    assert any(asked(plain))
    assert asked(changing) == asked(plain)


def test_a_function_as_it_is(monkeypatch):
    import chat_functions

    student = chat_student(chat_functions.by_prompt, history=3)
    assert f"{student}" == "chat:chat_functions:by_prompt(history=3)"
    assert study(student).students == (f"{student}",)
    assert parse_student(f"{student}") == student
    assert record(student).turns[1].action == "2"


def test_a_function_of_a_notebook():
    """No module has it: it is known in this process."""
    prompts = []

    def answer(prompt):
        prompts.append(prompt)
        return "Response: north"

    student = chat_student(answer)
    assert "chat:" in f"{student}"
    assert record(student).turns[1].action == "0"
    assert prompts[2].count("Your answer: Response: north") == 2
    assert "treasure" in prompts[2]
    assert prompts[2].endswith("Your action?")
    env = llf_teacher.TeacherEnv("llf-gridworld-v0", student=student, max_turns=2)
    env.reset(seed=1)
    env.step(31)
    assert len(prompts) == 4


def test_a_coroutine_within_a_running_loop():
    """As in a notebook's cell."""

    async def cell():
        return record("chat:chat_functions:slowly")

    assert asyncio.run(cell()).turns[1].action == "2"


def test_a_function_of_the_main_module_plays_in_processes(tmp_path):
    (tmp_path / "script.py").write_text(
        """
from llf_teacher.studies.execution.runner import play_missing
from llf_teacher.studies.store import Store
from llf_teacher.studies.definition.study import Study

def answer(prompt):
    return "Response: west"

if __name__ == "__main__":
    study = Study(ids=["llf-gridworld-v0"], teachers=["oracle"], students=["chat:answer"], seeds=2, max_turns=2)
    with Store("s.db") as store:
        print(play_missing(study, store, workers=1), "episodes")
"""
    )
    result = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert result.stdout == "2 episodes\n", result.stderr


@pytest.mark.parametrize(
    ("spec", "match"),
    [
        ("chat:nowhere_at_all:f", "cannot import the module 'nowhere_at_all'"),
        ("chat:chat_functions:nothing", "the module chat_functions has no function 'nothing'; put it into a module"),
        (
            "chat:nobody",
            "this process has no function 'nobody'; put it into a module and name that, as in `chat:my_module:nob",
        ),
        ("chat:chat_functions:two", r"cannot call two\(prompt, temperature\) with a prompt, or with messages"),
        (
            "chat:chat_functions:by_prompt(histor=1)",
            "by_prompt': unknown parameter 'histor'; did you mean history",
        ),
        ("chat:chat_functions:by_prompt(history=-1)", "history must be an integer from 0"),
        ("chat:", "bad student spec 'chat:'; expected .*`chat:package.module:function`"),
        ("chat_functions:by_prompt", "a function that answers prompts is named 'chat:chat_functions:by_prompt'"),
    ],
)
def test_what_is_no_function_that_answers(spec, match):
    with pytest.raises(ValueError, match=match):
        parse_student(spec)


def test_what_is_no_function_at_all():
    with pytest.raises(ValueError, match=r"function must be a function f\(prompt\) or f\(messages\), got 3"):
        chat_student(3)


def test_an_answer_must_be_a_text():
    with pytest.raises(TypeError, match="chat:chat_functions:wrong must give a text, got int 3"):
        record("chat:chat_functions:wrong")


def test_what_a_function_takes():
    def plain(messages: str): ...
    def listed(chat: list): ...
    def named(messages): ...

    assert [takes_messages(each) for each in (plain, listed, named)] == [False, True, True]
