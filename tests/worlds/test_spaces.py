"""Prose: any text up to a length, in samples, in vectors and in shared memory."""

import copy
import pickle

import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.vector.utils import (
    batch_space,
    concatenate,
    create_empty_array,
    create_shared_memory,
    iterate,
    read_from_shared_memory,
    write_to_shared_memory,
)
from hypothesis import given
from hypothesis import strategies as st

from worlds.spaces import Prose

TEXTS = ["", "plain", "caf\u00e9 \u2014", "\U0001f525" * 3, "\x00\n\t", "\ud800 lone \udfff", "a" * 20, "0" * 20]
any_text = st.text(st.characters(), max_size=20)


def round_trip(space, texts):
    memory = create_shared_memory(space, n=len(texts))
    for index, text in enumerate(texts):
        write_to_shared_memory(space, index, text, memory)
    return copy.deepcopy(read_from_shared_memory(space, memory, n=len(texts)))


@pytest.mark.parametrize("text", TEXTS)
def test_any_text_that_is_not_too_long_is_contained(text):
    assert text in Prose(20)
    assert text + "x" * 21 not in Prose(20)


@pytest.mark.parametrize("value", [None, 5, b"bytes", ["text"], ("t",), {}])
def test_what_is_no_string_is_not_contained(value):
    assert value not in Prose(20)


@pytest.mark.parametrize(("max_length", "longest"), [(8192, 64), (5, 5), (1, 1)])
def test_samples_are_short_printable_and_contained(max_length, longest):
    space = Prose(max_length, seed=0)
    samples = [space.sample() for _ in range(500)]
    assert all(sample in space and sample.isascii() and (sample == "" or sample.isprintable()) for sample in samples)
    assert {0, longest} <= {len(sample) for sample in samples}
    assert max(map(len, samples)) == longest


def test_the_length_of_samples_can_be_chosen():
    assert max(len(Prose(100, seed=0, sample_length=7).sample()) for _ in range(100)) <= 7


def test_samples_follow_the_seed():
    def samples(space):
        return [space.sample() for _ in range(5)]

    assert samples(Prose(99, seed=1)) == samples(Prose(99, seed=1)) != samples(Prose(99, seed=2))
    space = Prose(99, seed=2)
    space.seed(1)
    assert samples(space) == samples(Prose(99, seed=1))


def test_masked_samples_are_as_in_gymnasium():
    assert len(Prose(20, seed=0).sample(mask=(7, None))) == 7


def test_spaces_are_equal_by_length():
    assert Prose(20) == Prose(20, seed=3, sample_length=5)
    assert Prose(20) != Prose(21)
    assert Prose(20) != spaces.Text(20)
    assert Prose(20) != "Prose(20)"
    assert repr(Prose(20)) == "Prose(20)"


@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda space: pickle.loads(pickle.dumps(space))])
def test_copies_are_equal_and_sample_on(duplicate):
    space = Prose(99, seed=4)
    space.sample()
    copied = duplicate(space)
    assert copied == space
    assert copied.sample() == space.sample()


@pytest.mark.parametrize("text", TEXTS)
def test_json_samples_round_trip(text):
    space = Prose(20)
    assert space.from_jsonable(space.to_jsonable([text])) == [text]


@given(st.lists(any_text | st.sampled_from(TEXTS), min_size=1, max_size=4))
def test_shared_memory_gives_back_what_was_written(texts):
    given_back = round_trip(Prose(20), texts)
    assert given_back == tuple(texts)
    assert all(type(text) is str for text in given_back)


def test_shared_memory_is_empty_at_first_and_forgets_longer_texts():
    space = Prose(20)
    memory = create_shared_memory(space, n=2)
    seen = read_from_shared_memory(space, memory, n=2)
    assert list(seen) == ["", ""]
    write_to_shared_memory(space, 0, "a long sentence", memory)
    write_to_shared_memory(space, 0, "short", memory)
    assert (list(seen), len(seen), seen[0], seen[1]) == (["short", ""], 2, "short", "")


@pytest.mark.parametrize("index", [0, 1, 2])
def test_shared_memory_keeps_neighbours_apart(index):
    texts = ["x" * 20, "y" * 20, "z" * 20]
    space, memory = Prose(20), None
    memory = create_shared_memory(space, n=3)
    for i, text in enumerate(texts):
        write_to_shared_memory(space, i, text, memory)
    write_to_shared_memory(space, index, "", memory)
    texts[index] = ""
    assert list(read_from_shared_memory(space, memory, n=3)) == texts


def test_a_text_that_is_too_long_does_not_spill_over():
    space = Prose(5)
    memory = create_shared_memory(space, n=2)
    with pytest.raises(ValueError, match="broadcast"):
        write_to_shared_memory(space, 0, "sixsix", memory)
    assert read_from_shared_memory(space, memory, n=2)[1] == ""


def test_prose_within_a_dict_goes_through_shared_memory():
    space = spaces.Dict({"words": Prose(20), "room": spaces.Discrete(5)})
    memory = create_shared_memory(space, n=2)
    write_to_shared_memory(space, 0, {"words": "caf\u00e9", "room": 3}, memory)
    write_to_shared_memory(space, 1, {"words": "", "room": 4}, memory)
    seen = copy.deepcopy(read_from_shared_memory(space, memory, n=2))
    assert seen["words"] == ("caf\u00e9", "")
    assert seen["room"].tolist() == [3, 4]


def test_vectors_of_prose_are_tuples_of_text():
    space = Prose(20)
    assert ("one", "two") in batch_space(space, 2)
    assert concatenate(space, ["one", "two"], create_empty_array(space, 2)) == ("one", "two")


def test_texts_are_iterated_over_by_the_space_of_one_and_of_all():
    """SuperSuit does the first, Gymnasium the second."""
    texts = ("", "one", "and another")
    single = spaces.Dict({"words": Prose(20), "number": spaces.Box(0, 1, (1,))})
    numbers = np.zeros((3, 1), np.float32)
    assert [item["words"] for item in iterate(single, {"words": texts, "number": numbers})] == list(texts)
    assert list(iterate(batch_space(Prose(20), 3), texts)) == list(texts)
