"""Rollouts: the conversations of a study, many at once, with what a trainer has to know of each turn."""

import asyncio
import re

import gymnasium
import pytest
from playing import Counting

from llf_teacher import chat_student, rollout
from llf_teacher.models import LLMError
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from pz_envs.lesson import Lesson
from worlds.world import World

GRID = "llf-gridworld-v0"
ARMS = "llf-bandits-BanditTenArmedGaussian-v0"
WEST = "Thought: why not.\nResponse: west"


def west(conversations):
    return [WEST] * len(conversations)


def advised(conversations):
    """Goes where the teacher says, which is the last word that names a direction and is not warned of."""
    said = [re.findall(r"\b(north|east|south|west)\b", each[-1]["content"]) for each in conversations]
    return [f"Response: {(words or ['north'])[-1]}" for words in said]


def render(messages, add_generation_prompt=False):
    """As chat templates do."""
    text = "".join(f"<{message['role']}>{message['content']}</s>\n" for message in messages)
    return text + "<assistant>" * add_generation_prompt


def test_a_policy_may_change_the_messages_that_it_gets():
    """As clients do that add each answer; the record, whose places a trainer weights, keeps what was sent."""

    def one(messages):
        messages[0]["content"] = "Be brief."
        messages.append({"role": "assistant", "content": WEST})
        return WEST

    def many(conversations):
        answers = [one(each) for each in conversations]
        conversations.clear()
        return answers

    def found(policy):
        return [(each.messages, each.spans(render), each.rewards) for each in rollout(policy, GRID, 2, max_turns=4)]

    assert found(one) == found(many) == found(west)


def test_a_conversation_for_each_id_and_seed_in_their_order():
    played = rollout(west, [GRID, ARMS], [3, 1], batch=3, max_turns=4)
    assert [(each.id, each.seed) for each in played] == [(GRID, 3), (GRID, 1), (ARMS, 3), (ARMS, 1)]
    assert [len(each.turns) for each in played] == [4] * 4
    assert [each.seed for each in rollout(west, GRID, 3, max_turns=1)] == [0, 1, 2]
    assert rollout(west, GRID, 0) == []


@pytest.mark.parametrize("batch", [1, 2, 64])
def test_the_batch_changes_nothing_but_how_many_are_asked_at_once(batch):
    sizes = []

    def policy(conversations):
        sizes.append(len(conversations))
        return advised(conversations)

    played = rollout(policy, GRID, 5, batch=batch, feedback_type="fp")
    assert played == rollout(advised, GRID, 5, batch=3, feedback_type="fp")
    assert max(sizes) == min(batch, 5)
    assert len({len(each.turns) for each in played}) > 1  # so that places become free at different times
    assert sum(sizes) == sum(len(each.turns) for each in played)


def test_it_is_what_a_study_plays():
    """The same prompts, and the same numbers."""
    prompts = []

    def answer(messages):
        prompts.append(messages)
        return advised([messages])[0]

    study = Study(
        ids=[GRID], teachers=["mistake(eps=0.3)"], students=[chat_student(answer)], seeds=1, feedback_types=["fp+hn"]
    )
    spec = next(study.episodes())
    record = play(spec)
    (played,) = rollout(answer, GRID, [spec.seed], teacher="mistake(eps=0.3)", feedback_type="fp+hn")
    turns = record.turns[1:]
    assert prompts[: len(turns)] == prompts[len(turns) :] == [turn.prompt for turn in played.turns]
    assert played.rewards == tuple(turn.reward for turn in turns)
    assert played.regrets == tuple(turn.regret for turn in turns)
    assert [turn.feedback for turn in played.turns] == [turn.feedback for turn in turns]
    assert (played.success, played.failures) == (record.episode.success, record.episode.parse_failures)


def test_a_group_is_a_seed_that_comes_several_times():
    one, other, third = rollout(west, GRID, [5, 5, 6], max_turns=2)
    assert one == other != third
    assert one.turns[0].prompt == other.turns[0].prompt


def test_failures_are_told():
    (played,) = rollout(lambda conversations: ["fly"], GRID, 1, max_turns=2)
    assert played.failures == 2
    assert [turn.failure for turn in played.turns] == ["it names no action that there is"] * 2
    assert not played.success
    assert rollout(west, GRID, 1, max_turns=2)[0].turns[0].failure is None


def test_the_students_own_characters():
    (played,) = rollout(advised, GRID, [2], feedback_type="fp")
    assert len(played.turns) > 1
    assert played.whole
    text, spans = played.spans(render)
    assert text == render(played.messages)
    assert [text[slice(*span)] for span in spans] == [f"{turn.answer}</s>\n" for turn in played.turns]
    assert [played.messages[place]["content"] for place in played.answers] == [turn.answer for turn in played.turns]
    roles = [message["role"] for message in played.messages]
    assert roles == ["system", *["user", "assistant"] * len(played.turns)]


@pytest.mark.parametrize("answer", ["<think>Hm.</think>Response: west", ""])
def test_what_was_left_out_of_later_prompts_is_trained_turn_by_turn(answer):
    (played,) = rollout(lambda conversations: [answer], GRID, 1, max_turns=3)
    assert [turn.answer for turn in played.turns] == [answer] * 3
    assert not played.whole
    with pytest.raises(ValueError, match=r"with seed 0 is not whole: .* train on each of `turns` instead"):
        played.spans(render)


def test_a_window_is_that_of_the_student():
    played = rollout(chat_student(lambda prompt: WEST, history=1), GRID, 1, max_turns=4)[0]
    assert [len(turn.prompt) for turn in played.turns] == [2, 4, 4, 4]
    assert not played.whole
    assert len(rollout(west, GRID, 1, max_turns=4)[0].turns[-1].prompt) == 8


def test_a_rendering_that_changes_what_was_before():
    def numbered(messages, add_generation_prompt=False):
        return f"{len(messages)}: {render(messages)}"

    (played,) = rollout(west, GRID, 1, max_turns=2)
    with pytest.raises(ValueError, match=r"got another text for the answer of turn 1; train on each of `turns`"):
        played.spans(numbered)


def test_functions_of_one_conversation_and_coroutines():
    together = []

    def by_prompt(prompt):
        assert "Your action?" in prompt
        return WEST

    async def by_messages(messages):
        together.append(1)
        await asyncio.sleep(0.01)
        assert len(together) == 3  # all are asked before the first is answered
        return WEST

    async def by_batch(conversations):
        await asyncio.sleep(0.001)
        return west(conversations)

    def oddly(text):
        return by_prompt(text)

    expected = rollout(west, GRID, 3, max_turns=1)
    for policy in (by_prompt, by_messages, by_batch, chat_student(oddly)):
        assert rollout(policy, GRID, 3, max_turns=1) == expected

    async def cell():  # as in a notebook, where a loop is running
        return rollout(by_batch, GRID, 3, max_turns=1)

    assert asyncio.run(cell()) == expected


def test_a_lesson_of_ones_own():
    lesson = Lesson(lambda: gymnasium.make("CartPole-v1"))
    (played,) = rollout(lambda conversations: ["1"], lesson, 1, max_turns=2)
    assert played.rewards == (1.0, 1.0)
    assert played.regrets == (-1.0, -1.0)  # nobody knows the values: the negated rewards, as in a store
    assert "reward" in played.messages[0]["content"]


def test_a_teacher_of_ones_own_has_each_conversation_to_itself():
    for played in rollout(west, GRID, 3, teacher=Counting(), max_turns=3):
        assert [turn.feedback for turn in played.turns] == ["That makes 2.", "That makes 3.", "That makes 4."]


def test_environments_are_kept_for_the_next_episode_and_closed_at_the_end(monkeypatch):
    closed = []
    close = World.close
    monkeypatch.setattr(World, "close", lambda world: (closed.append(world), close(world))[1])
    rollout(west, GRID, 6, batch=2, max_turns=2)
    assert len(closed) == 2

    def breaks(conversations):
        raise RuntimeError("no model")

    with pytest.raises(RuntimeError, match="no model"):
        rollout(breaks, GRID, 6, batch=2)
    assert len(closed) == 4


class Unshown:
    def __repr__(self):
        raise KeyError


ODD = {"None": None, "7": 7, "bytes": b"Response: north", "error": ValueError("no idea"), "unshown": Unshown()}


@pytest.mark.parametrize("id", ["llf-poem-Haiku-v0", "llf-gridworld-v0"])
def test_a_lone_surrogate_is_a_question_mark(id):
    (played,) = rollout(lambda prompt: "Rain \ud800 falls", id, 1, max_turns=2)
    assert [turn.answer for turn in played.turns] == ["Rain ? falls"] * 2
    assert "\ud800" not in f"{played.messages}"


@pytest.mark.parametrize("id", [GRID, "llf-poem-Haiku-v0", "llf-bandits-BanditTwoArmedHighLowFixed-v0"])
@pytest.mark.parametrize("odd", ODD.values(), ids=ODD)
def test_an_odd_answer_is_a_turn_without_an_action_and_no_other_changes(id, odd):
    def policy(conversations):
        return [odd if number == 1 else "north" for number in range(len(conversations))]

    with pytest.warns(RuntimeWarning, match=r"2 answers were no texts, the first: the policy must answer with a text"):
        one, other, third = rollout(policy, id, [0, 0, 0], max_turns=2)
    assert one == third
    assert other.failures == len(other.turns) == 2
    assert {turn.failure.partition(", got ")[2].partition(":")[0] for turn in other.turns} == {type(odd).__name__}
    assert {turn.answer for turn in other.turns} == {""}
    assert one.turns[0].answer == "north"


@pytest.mark.parametrize("waits", [False, True])
def test_an_error_of_one_conversation_is_a_turn_without_an_action(waits):
    asked = []

    def said(prompt):
        asked.append(prompt)
        if len(asked) == 2:
            raise KeyError("no idea")
        return "north"

    async def later(prompt):
        return said(prompt)

    with pytest.warns(RuntimeWarning, match="1 answers were no texts, .* got KeyError: KeyError"):
        played = rollout(later if waits else said, GRID, [0, 0], max_turns=2)
    assert [[turn.answer for turn in each.turns] for each in played] == [["north", "north"], ["", "north"]]


@pytest.mark.parametrize("error", [LLMError("the endpoint is gone"), KeyboardInterrupt()])
def test_an_error_of_all_conversations_ends_a_rollout(error):
    def said(prompt):
        raise error

    with pytest.raises(type(error)):
        rollout(said, GRID, 2)


def test_a_rollout_in_a_policy_that_it_awaits_is_an_error():
    async def policy(prompt):
        return rollout(lambda prompt: "north", GRID, 1)[0].turns[0].answer

    async def inner(prompt):
        return await asyncio.to_thread(policy_of_others, prompt)

    async def nested(prompt):
        return "north"

    def policy_of_others(prompt):
        return rollout(nested, GRID, 1)[0].turns[0].answer

    async def bad(prompt):
        return rollout(nested, GRID, 1)

    with pytest.raises(RuntimeError, match=r"would wait for itself for ever; call it in a thread: await asyncio.to_th"):
        rollout(bad, GRID, 1)
    assert rollout(inner, GRID, 1, max_turns=1)[0].turns[0].answer == "north"
    assert rollout(policy, GRID, 1, max_turns=1)[0].turns[0].answer == "north", "it waits for nothing"


@pytest.mark.parametrize("said", ["west", ["west"], 7, None])
def test_what_is_no_text_for_each_conversation(said):
    with pytest.raises(TypeError, match="policy must return a list of 2 texts, one per conversation, got"):
        rollout(lambda conversations: said, GRID, 2)


@pytest.mark.parametrize(
    ("policy", "settings", "match"),
    [
        (west, {"batch": 0}, "batch must be an integer from 1"),
        (west, {"seeds": -1}, "seeds must be an integer from 0"),
        (west, {"text": False}, "rollout always plays in text mode; leave out text=False"),
        (west, {"feedback": "a"}, "does not take these options: unknown option 'feedback'"),
        (3, {}, "policy must be a function of conversations or come from chat_student, got 3"),
    ],
)
def test_refusals(policy, settings, match):
    with pytest.raises(ValueError, match=match):
        rollout(policy, GRID, **({"seeds": 1} | settings))
