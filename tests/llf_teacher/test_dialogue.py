"""An episode that a framework plays turn by turn is the one that a study plays."""

import pytest

from llf_teacher import chat_student
from llf_teacher.integrations.dialogue import SCORES, Dialogue
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play

ANSWERS = {
    "llf-gridworld-v0": ("Response: west", "I do not know.", "<think>Perhaps.</think>Response: north"),
    "llf-bandits-BanditTwoArmedHighLowFixed-v0": ("Response: 1", "0"),
    "llf-optimization-Booth-v0": ("x = [1.0, 2.0]", "nothing"),
}


def scripted(answers):
    def answer(messages: list) -> str:
        turn = sum(message["content"].count("Your action?") for message in messages if message["role"] == "user")
        return answers[turn % len(answers)]

    return answer


@pytest.mark.parametrize("id", ANSWERS)
@pytest.mark.parametrize("teacher", ["oracle", "mistake(eps=0.5) | delayed(turns=1)"])
def test_it_is_the_episode_of_a_study(id, teacher):
    """The messages, too: the answers depend on them."""
    asked = []

    def answer(messages: list) -> str:
        asked.append(messages)
        return scripted(ANSWERS[id])(messages)

    study = Study(
        ids=[id], teachers=[teacher], students=[chat_student(answer)], seeds=[5], instruction_types=["p"], max_turns=6,
        baseline=teacher,
    )  # fmt: skip
    (spec,) = study.episodes()
    played = play(spec)
    seen, asked = asked, []
    dialogue = Dialogue(id, 5, teacher=teacher, instruction_type="p", max_turns=6)
    while not dialogue.over:
        dialogue.answer(answer(dialogue.messages))
        dialogue.speak()
    assert asked == seen
    assert dialogue.messages == []
    told = {"answer": None, "thought": None, "asked": None}  # what was asked is compared above
    assert [row._replace(**told) for row in dialogue.turns] == [row._replace(**told) for row in played.turns]
    assert dialogue.episode()._replace(answers=None, truncated=None) == played.episode
    assert dialogue.scores()["parse_failures"] == played.episode.parse_failures
    assert dialogue.scores()["regret"] == played.episode.regret


def test_what_is_thought_is_kept_apart():
    dialogue = Dialogue("llf-gridworld-v0", 0)
    dialogue.answer("<think>Perhaps.</think>Response: north")
    dialogue.speak()
    assert dialogue.turns[1].thought == "Perhaps."
    assert dialogue.turns[1].answer == "Response: north"
    assert not any("Perhaps" in message["content"] for message in dialogue.messages)


def test_what_an_answer_cost_is_recorded():
    dialogue = Dialogue("llf-gridworld-v0", 0)
    dialogue.answer("Response: north", {"input_tokens": 300, "output_tokens": 5, "finish": "length"})
    dialogue.speak()
    row = dialogue.episode()
    assert (row.input_tokens, row.output_tokens, row.truncated) == (300, 5, 1)
    opening, turn = dialogue.record()
    assert opening["instruction"]
    assert turn["finish"] == "length"
    assert {atom["kind"] for atom in turn["atoms"]} > {"r", "fp"}


def test_the_teacher_may_be_another():
    """Its words are heard as they are, and nothing is claimed of them."""
    dialogue = Dialogue("llf-gridworld-v0", 0)
    dialogue.answer("Response: north")
    dialogue.speak("Well done!")
    assert "Teacher: Well done!" in dialogue.messages[-1]["content"]
    assert dialogue.turns[1].atoms == []
    assert tuple(dialogue.scores()) == tuple(SCORES)
    assert dialogue.scores()["turns"] == 1


def test_it_ends_with_success_where_the_task_is_not_repeated():
    """As the evaluation of LLF-Bench does."""
    dialogue = Dialogue("llf-gridworld-v0", 3, instruction_type="c")
    for action in dialogue.env.session.teacher.oracle.plan(dialogue.env.session.world.truth, 20):
        assert not dialogue.over
        dialogue.answer(f"Response: {action}")
        dialogue.speak()
    assert dialogue.over
    assert dialogue.scores()["success"] == 1.0
    assert dialogue.scores()["regret"] == 0.0
