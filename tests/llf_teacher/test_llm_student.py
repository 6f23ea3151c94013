"""How the student `llm` converses: with models that reason, that answer in JSON or by tools, that have little room."""

import itertools
import json

import numpy as np
import pytest

import llf_teacher
from llf_teacher.models import LLMError
from llf_teacher.models.testing import Reply, ScriptedEndpoint, completion, refusal, too_long
from llf_teacher.registry import PREFIX
from llf_teacher.students.conversation import STOPS, Conversation
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies.analysis.costs import cost_lines
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.store import Store
from pz_envs.family import all_families
from pz_envs.text.answer_formats import ANSWERS

NOTHING = {"instruction": " ", "feedback": "", "observation": ""}
GRIDWORLD = "llf-gridworld-v0"
FAMILIES = [family for family in all_families() if not family.missing()]


@pytest.fixture(autouse=True)
def _no_settings(monkeypatch):
    for name in ("MODEL", "BASE_URL", "API_KEY", "CACHE", "BUDGET", "TIMEOUT", "RETRIES"):
        monkeypatch.delenv(f"LLF_LLM_{name}", raising=False)
        monkeypatch.delenv(f"OPENAI_{name}", raising=False)


def llm(url, options=""):
    """The spec of a model that answers in words, unless the options say otherwise."""
    form = "" if "answer=" in options else ", answer='text'"
    return f"llm(model='m', base_url='{url}'{form}{options})"


def episode(url, options="", **changes):
    settings = {"ids": [GRIDWORLD], "teachers": ["oracle"], "seeds": 1, "max_turns": 4}
    return play(next(Study(students=[llm(url, options)], **(settings | changes)).episodes()))


def contents(request):
    return [message["content"] for message in request["messages"]]


@pytest.mark.parametrize(
    "reply",
    [
        lambda: "<think>north? no, west.</think>\nResponse: west",
        lambda: Reply(body=completion("Response: west", reasoning_content="north? no, west.")),
        lambda: Reply(body=completion("Response: west", reasoning="north? no, west.")),
        lambda: Reply(
            body=completion(
                [
                    {"type": "thinking", "thinking": [{"type": "text", "text": "north? no, west."}]},
                    {"type": "text", "text": "Response: west"},
                ]
            )
        ),
    ],
)
def test_thoughts_are_neither_read_nor_sent_back(reply):
    with ScriptedEndpoint(lambda request: reply()) as server:
        record = episode(server.url)
    assert {turn.action for turn in record.turns[1:]} == {"2"}
    assert len(server.requests) == 4
    assert "north? no" not in json.dumps(server.requests)
    assert contents(server.requests[-1])[2] == "Response: west"


def test_what_a_model_says_for_others_is_cut_and_kept_apart(tmp_path):
    invented = "Teacher: Go north.\n\nResponse: north"
    with ScriptedEndpoint(lambda request: f"Thought: hm.\nResponse: west\n\n{invented}") as server:
        record = episode(server.url)
    assert {turn.action for turn in record.turns[1:]} == {"2"}
    assert {(turn.answer, turn.invented) for turn in record.turns[1:]} == {("Thought: hm.\nResponse: west", invented)}
    assert all(request["stop"] == list(STOPS) for request in server.requests)
    said = [message["content"] for message in server.requests[-1]["messages"] if message["role"] == "assistant"]
    assert said == ["Thought: hm.\nResponse: west"] * 3
    with Store(tmp_path / "s.db") as store:
        store.add(record)
        (line,) = cost_lines(store)
    assert line.endswith(": 4 of 4 answers went on to speak for others; that part was cut")


@pytest.mark.parametrize(("form", "stops"), [("json", False), ("tool", False), ("text", True)])
def test_only_texts_are_stopped(form, stops):
    with ScriptedEndpoint(lambda request: "Response: west") as server:
        episode(server.url, f", answer='{form}'", max_turns=1)
    assert ("stop" in server.requests[0]) == stops


def test_an_endpoint_need_not_know_stops():
    with ScriptedEndpoint(lambda request: refusal("stop") if "stop" in request else "Response: west") as server:
        record = episode(server.url)
    assert {turn.action for turn in record.turns[1:]} == {"2"}
    assert ["stop" in request for request in server.requests] == [True, False, False, False, False]


def test_an_answer_of_thoughts_alone_is_not_sent_back():
    """Many chat templates refuse an empty turn, and two turns of one side: what was asked is asked together."""
    answers = iter(["<think>hm", "Response: west", "Response: west", "<think>"])
    with ScriptedEndpoint(lambda request: next(answers)) as server:
        record = episode(server.url)
    assert [turn.parse_failure is not None for turn in record.turns] == [False, True, False, False, True]
    assert [message["role"] for message in server.requests[1]["messages"]] == ["system", "user"]
    assert contents(server.requests[1])[-1].count("Your action?") == 2
    roles = [message["role"] for message in server.requests[3]["messages"]]
    assert roles == ["system", "user", "assistant", "user", "assistant", "user"]
    assert all(content for request in server.requests for content in contents(request))


def test_a_template_may_say_how_many_turns_are_left(tmp_path):
    (tmp_path / "turn.j2").write_text("Turn {{ turn }}, {{ turns_left }} left.")
    with ScriptedEndpoint(lambda request: "Response: north") as server:
        episode(server.url, f", prompts={str(tmp_path)!r}")
    ends = [contents(request)[-1] for request in server.requests]
    assert ends == ["Turn 1, 4 left.", "Turn 2, 3 left.", "Turn 3, 2 left.", "Turn 4, 1 left."]


@pytest.mark.parametrize("answer", ANSWERS)
@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
def test_no_prompt_has_an_action_or_a_thought_to_copy(family, answer):
    world = family.make_world()
    asked = [
        contents({"messages": Conversation(world, answer=answer, rng=np.random.default_rng(seed)).ask(NOTHING)})
        for seed in range(3)
    ]
    assert asked[0] == asked[1] == asked[2], "no action is drawn"
    assert "not tried" not in asked[0][0]
    assert len(" ".join(asked[0]).split()) <= 40


def test_an_answer_that_is_no_action_is_not_sent_back():
    """What is broken would be gone on with."""
    answers = iter(['{"thought": "I go to the", "act', '{"thought": "so", "action": "west"}', "{}", "{}"])
    with ScriptedEndpoint(lambda request: next(answers)) as server:
        record = episode(server.url, ", answer='json'")
    assert [turn.parse_failure is not None for turn in record.turns] == [False, True, False, True, True]
    assert record.turns[1].answer == '{"thought": "I go to the", "act', "the record has it"
    assert "I go to the" not in json.dumps(server.requests)
    roles = [message["role"] for message in server.requests[3]["messages"]]
    assert roles == ["system", "user", "assistant", "user"]


def test_of_an_answer_that_was_cut_the_action_is_sent_back(tmp_path):
    said = "Response: west\n\nI went there because"
    with ScriptedEndpoint(lambda request: Reply(body=completion(said, request, finish="length"))) as server:
        record = episode(server.url)
    assert {turn.action for turn in record.turns[1:]} == {"2"}
    assert contents(server.requests[-1])[2] == "Response: west"
    assert record.episode.truncated == 4
    with Store(tmp_path / "s.db") as store:
        store.add(record)
        assert [line for line in cost_lines(store) if "4 of 4 answers were cut" in line]


@pytest.mark.parametrize("action", ["west", 2])
def test_answers_in_json(action):
    said = json.dumps({"thought": "it said so", "action": action})
    with ScriptedEndpoint(lambda request: said) as server:
        record = episode(server.url, ", answer='json'")
    assert {turn.action for turn in record.turns[1:]} == {"2"}
    form = server.requests[0]["response_format"]["json_schema"]["schema"]
    assert form["properties"]["action"] == {"enum": ["north", "east", "west", "south"]}
    assert contents(server.requests[-1])[2] == said


@pytest.mark.parametrize("said", ["west or so", '{"action": 1, "action": 2}', "[1, 2]", '{"thought": "west"}'])
def test_what_is_not_the_json_that_was_asked_for_is_a_turn(said):
    with ScriptedEndpoint(lambda request: said) as server:
        assert episode(server.url, ", answer='json'").episode.parse_failures == 4


def call(*actions):
    calls = [
        {"id": f"c{n}", "type": "function", "function": {"name": "act", "arguments": json.dumps({"action": action})}}
        for n, action in enumerate(actions)
    ]
    return Reply(body=completion(None, finish="tool_calls", tool_calls=calls))


def test_answers_by_a_tool():
    with ScriptedEndpoint(lambda request: call("west")) as server:
        record = episode(server.url, ", answer='tool'")
    assert {turn.action for turn in record.turns[1:]} == {"2"}
    last = server.requests[-1]
    assert last["tool_choice"] == "required"
    assert [tool["function"]["name"] for tool in last["tools"]] == ["act"]
    assert [message["role"] for message in last["messages"]] == ["system", "user", *["assistant", "tool"] * 3]
    assert last["messages"][2]["tool_calls"][0]["function"]["arguments"] == '{"action": "west"}'
    assert last["messages"][3]["tool_call_id"] == "c0"
    assert record.turns[1].feedback in last["messages"][3]["content"]


def test_two_calls_are_no_action():
    with ScriptedEndpoint(lambda request: call("west", "east")) as server:
        assert episode(server.url, ", answer='tool'").episode.parse_failures == 4


def test_the_history_is_cut_in_blocks():
    """So that the beginning of a prompt stays as it is for many turns, and an endpoint's cache of it has its worth."""
    with ScriptedEndpoint(lambda request: too_long(request, 800) or "Response: no") as server:
        record = episode(server.url, ", max_prompt_tokens=800, history=1000", max_turns=40, ids=["llf-poem-Haiku-v0"])
    assert record.episode.turns == 40
    starts = [contents(request)[1].rpartition("turn ")[2] for request in server.requests]
    lengths = [len(request["messages"]) for request in server.requests]
    cuts = sum(after != before for before, after in itertools.pairwise(starts))
    assert 2 <= cuts <= 8
    assert max(lengths) > 12
    assert len({contents(request)[0] for request in server.requests}) == 1


def test_a_prompt_that_cannot_be_cut_is_an_error_of_the_episode():
    with (
        ScriptedEndpoint(lambda request: too_long(request, 100) or "Response: no") as server,
        pytest.raises(LLMError, match="maximum context length is 100 tokens"),
    ):
        episode(server.url, ", max_prompt_tokens=100")
    assert len(server.requests[0]["messages"]) == 2, "the instruction is never cut"


def test_prompts_of_ones_own(tmp_path):
    (tmp_path / "system.j2").write_text("Do this: {{ instruction }} Like this: {{ example }}")
    with ScriptedEndpoint(lambda request: "Response: west") as server:
        student = f"llm(model='m', base_url='{server.url}', answer='text', prompts={str(tmp_path)!r})"
        study = Study(ids=[GRIDWORLD], teachers=["oracle"], students=[student], seeds=1, max_turns=1)
        play(next(study.episodes()))
        assert contents(server.requests[0])[0].startswith("Do this: ")
        assert "Your action?" in contents(server.requests[0])[1]
        spec = study.students[0]
        assert parse_student(spec).facts()["prompts"]["system.j2"]["text"].startswith("Do this")
        assert f"{parse_student(spec)}" == spec
        (tmp_path / "system.j2").write_text("Do that: {{ instruction }}")
        with pytest.raises(ValueError, match="have changed since"):
            parse_student(spec)
        assert f"{parse_student(student)}" != spec


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("{{ secret }}", "is not a valid template: 'secret' is undefined; allowed: instruction, example, answer"),
        ("{% if %}", "is not a valid template"),
        (None, r"prompts must be neutral, or a folder with any of system\.j2, turn\.j2, examples\.jsonl"),
    ],
)
def test_prompts_that_are_none(tmp_path, text, match):
    if text is not None:
        (tmp_path / "system.j2").write_text(text)
    with pytest.raises(ValueError, match=match):
        parse_student(f"llm(model='m', prompts={str(tmp_path)!r})")


@pytest.mark.parametrize("answer", ANSWERS)
def test_neutral_prompts_do_not_say_what_to_think_of_the_teacher(answer):
    with ScriptedEndpoint(lambda request: "Response: north") as server:
        for prompts in ("", ", prompts='neutral'"):
            episode(server.url, f", answer='{answer}'{prompts}", max_turns=1)
    usual, neutral = (contents(request)[0] for request in server.requests)
    assert "A teacher tells you how to do it better" in usual
    assert "what the teacher advises" in usual
    assert "better" not in neutral
    assert "advises" not in neutral
    task = usual.split("\n\n")[1]
    assert task in neutral
    assert len(contents(server.requests[0])) == len(contents(server.requests[1])) == 2


@pytest.mark.parametrize("answer", ANSWERS)
def test_examples_stand_before_the_conversation(tmp_path, answer):
    shown = {"thought": "so it is", "action": "west"}
    said = "Thought: so it is\nResponse: west" if answer == "text" else shown
    lines = [json.dumps({"question": f"You see {n}.", "answer": said}) for n in range(2)]
    (tmp_path / "examples.jsonl").write_text("\n".join(lines), "utf-8")
    student = f", answer='{answer}', prompts={str(tmp_path)!r}"
    with ScriptedEndpoint(lambda request: "Response: north") as server:
        episode(server.url, f"{student}, history=1")
    roles = ["system", "user", "assistant", "tool" if answer == "tool" else "user", "assistant"]
    assert [[message["role"] for message in request["messages"]][:5] for request in server.requests] == [roles] * 4
    assert [len(request["messages"]) for request in server.requests] == [6, 8, 8, 8]
    last = server.requests[-1]["messages"]
    assert last[3]["content"] == "You see 1."
    given = last[2]["tool_calls"][0]["function"]["arguments"] if answer == "tool" else last[2]["content"]
    assert given == (said if answer == "text" else json.dumps(shown))
    assert last[4].get("content") or last[5]["tool_call_id"] == last[4]["tool_calls"][0]["id"]
    made = parse_student(f"llm(model='m'{student})")
    assert "examples.jsonl" in made.facts()["prompts"]
    (tmp_path / "examples.jsonl").write_text(lines[0], "utf-8")
    assert parse_student(f"llm(model='m'{student})") != made, "the digest has the examples"


def test_examples_may_begin_with_a_byte_order_mark(tmp_path):
    (tmp_path / "examples.jsonl").write_text('{"question": "?", "answer": "north"}', "utf-8-sig")
    assert len(Conversation(prompts=tmp_path)._examples) == 1


@pytest.mark.parametrize(
    "line",
    [
        "[]",
        "north",
        '{"question": "Where?"}',
        "[" * 100_000,
        '{"question": 1, "answer": "north"}',
        '{"question": "\\ud800", "answer": "north"}',
        '{"question": "?", "answer": "\\ud800"}',
    ],
)
def test_examples_that_are_none(tmp_path, line):
    (tmp_path / "examples.jsonl").write_text(f'{{"question": "?", "answer": "!"}}\n{line}', "utf-8")
    with pytest.raises(
        ValueError, match=r"examples\.jsonl:2 must be an object with question, a text, and answer, got "
    ):
        Conversation(prompts=tmp_path)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ("memory=-1", "memory must be an integer from 0"),
        ("answer='xml'", "answer must be one of auto, json, tool, text, got 'xml'"),
        ("max_prompt_tokens=0", "max_prompt_tokens must be an integer from 1"),
        ("cached_price=-1", "cached_price must be a number from 0"),
        ("extra={'tools': []}", "without the keys model, messages, stream, n, tools"),
    ],
)
def test_options_that_are_not_allowed(options, match):
    with pytest.raises(ValueError, match=match):
        parse_student(f"llm(model='m', {options})")


def test_a_limit_is_refused_where_answers_have_no_length():
    with pytest.raises(ValueError, match="a spending limit needs a maximum length"):
        parse_student("llm(model='m', input_price=1, output_price=1, max_tokens=None)").check({"LLF_LLM_BUDGET": "1"})


def test_a_student_remembers_its_lifetime():
    with ScriptedEndpoint(lambda request: "Response: north") as server:
        student = llm(server.url)
        env = llf_teacher.TeacherEnv(GRIDWORLD, student=student, episodes=2, max_turns=2)
        for seed in (1, 2):
            env.reset(seed=seed)
            over = False
            while not over:
                _, _, terminated, truncated, _ = env.step(31)
                over = terminated or truncated
    assert [len(request["messages"]) for request in server.requests] == [2, 4, 6, 8] * 2
    last = contents(server.requests[2])[-1]
    assert last.startswith("A new episode of the same task begins.\n\nTeacher: ")


def test_a_note_that_is_withheld_is_none():
    def reply(request):
        asked = request["messages"][-1]["content"]
        return (
            Reply(body=completion(None, finish="content_filter"))
            if asked.startswith("The episode is over")
            else "north"
        )

    with ScriptedEndpoint(reply) as server:
        student = llm(server.url, ", memory=5")
        env = llf_teacher.TeacherEnv(GRIDWORLD, student=student, episodes=2, max_turns=2)
        env.reset(seed=1)
        over = False
        while not over:
            _, _, terminated, truncated, _ = env.step(31)
            over = terminated or truncated
    assert [len(request["messages"]) for request in server.requests] == [2, 4, 6, 2, 4]
    assert not any("Your notes" in request["messages"][0]["content"] for request in server.requests)


@pytest.mark.parametrize("answer", ANSWERS)
def test_a_student_remembers_what_it_wrote_down(answer):
    """In a lifetime of three episodes, before the second and the third."""

    def reply(request):
        asked = request["messages"][-1]["content"]
        return f"Note {len(server.requests)}. " + "word " * 100 if asked.startswith("The episode is over") else "north"

    with ScriptedEndpoint(reply) as server:
        student = f"llm(model='m', base_url='{server.url}', memory=5, answer='{answer}')"
        env = llf_teacher.TeacherEnv(GRIDWORLD, student=student, episodes=3, max_turns=2)
        env.reset(seed=1)
        over = False
        while not over:
            _, _, terminated, truncated, _ = env.step(31)
            over = terminated or truncated
    assert [len(request["messages"]) for request in server.requests] == [2, 4, 6, 2, 4, 6, 2, 4]
    first, *_, review, second, _, again, third, _ = map(contents, server.requests)
    assert "in at most 5 words" in review[-1]
    assert "The teacher said at its end: " in review[-1]
    assert "response_format" not in server.requests[2]
    assert "tools" not in server.requests[2]
    assert "Your notes" not in first[0]
    for noted, number in ((second, 3), (again, 3), (third, 6)):
        notes = noted[0].partition("Your notes of earlier episodes:\n")[2]
        assert notes == f"Note {number}. {'word ' * 100}"[:50]
    words = review[-1].partition("The teacher said at its end: ")[2].partition("\n\n")[0]
    assert len(words) > 10
    assert words not in second[-1]


def test_a_conversation_of_ones_own():
    """As in the README: what `llm` sends, for any model."""
    env = llf_teacher.make(PREFIX + "gridworld-v0", text=True, max_turns=3)
    talk = Conversation(env)
    sent = []
    for seed in (1, 2):
        observation, _ = env.reset(seed=seed)
        over = False
        while not over:
            sent.append(talk.ask(observation))
            action = talk.answer("<think>hm</think>Response: north")
            observation, _, terminated, truncated, _ = env.step(action)
            over = terminated or truncated
        assert talk.thought == "hm"
    assert [len(messages) for messages in sent] == [2, 4, 6] * 2
    assert all(messages[0] == sent[0][0] for messages in sent[:3])
    assert sent[3][1]["content"].endswith("Your action?")
