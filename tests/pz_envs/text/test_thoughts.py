"""Answers of chat models: thoughts are parted from what is said."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from timing import grows_linearly

from pz_envs.text.thoughts import split_thought

PARTED = [
    ("<think>a door</think>north", "a door", "north"),
    ("<think>\na door\n</think>\n\nnorth\n", "a door", "north"),
    ("<THINK>a door</THINK> north", "a door", "north"),
    ("<thinking>a door</thinking>north", "a door", "north"),
    ("<reasoning>a door</reasoning>north", "a door", "north"),
    ("<seed:think>a door</seed:think>north", "a door", "north"),
    ("[THINK]a door[/THINK]north", "a door", "north"),
    ("\u25c1think\u25b7a door\u25c1/think\u25b7north", "a door", "north"),
    ("<|begin_of_thought|>a door<|end_of_thought|><|begin_of_solution|>north<|end_of_solution|>", "a door", "north"),
    (
        "<|channel|>analysis<|message|>a door<|end|><|start|>assistant<|channel|>final<|message|>north",
        "a door",
        "north",
    ),
    ("<|channel>thought\na door<channel|>north", "a door", "north"),
    ("<think>one</think>north<think>two</think>east", "one\n\ntwo", "north\neast"),
    ("<think>my <think> mark</think>north", "my <think> mark", "north"),
    ("a door</think>north", "a door", "north"),
    ("<think>a door", "a door", ""),
    ("north<think>a door", "a door", "north"),
    ("<think></think>\n\nsnow\n\nrain", "", "snow\n\nrain"),
    ("", "", ""),
]


@pytest.mark.parametrize(("text", "thought", "answer"), PARTED, ids=[text[:30] for text, _, _ in PARTED])
def test_reasoning_is_parted_from_the_answer(text, thought, answer):
    parted = split_thought(text)
    assert parted == (thought, answer, text, text.endswith("<think>a door"))
    assert split_thought(parted) is parted


@pytest.mark.parametrize("text", [" north \n", "a < b", "I think </b> so", "<thin>", "think: north", "north<|end|>"])
def test_a_text_without_marks_is_an_answer_as_it_is(text):
    assert split_thought(text) == ("", text, text, False)


marks = st.sampled_from(["<think>", "</think>", "[THINK]", "<|channel|>final<|message|>", "<|end|>", "north", " ", "<"])


@given(st.lists(marks, max_size=20).map("".join) | st.text())
def test_what_is_said_is_in_the_text_and_holds_no_thought(text):
    thought, answer, whole, unended = split_thought(text)
    assert whole == text
    assert unended == ("behind it" in split_thought(f"{text} behind it").thought)
    assert all(line.strip() in text for line in [*thought.splitlines(), *answer.splitlines()])
    assert split_thought(answer) == ("", answer, answer, False)


@pytest.mark.parametrize("piece", ["<think>", "</think>", "a</think>b", "<", "<|channel|>analysis", "[THINK]x[/THINK]"])
def test_a_long_text_is_parted_in_linear_time(piece):
    assert grows_linearly(lambda size: split_thought(piece * (size // len(piece))))
