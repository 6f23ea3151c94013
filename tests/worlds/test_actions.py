"""Actions of every kind of space in their canonical form, and observations as text."""

import json
import re

import numpy as np
import pytest
from gymnasium import spaces

from worlds.actions import canonical, describe_space, format_value, is_element, native, syntax
from worlds.wrapped.gym_world import same

SPACES = [
    (spaces.Discrete(3, start=-1), "an integer from -1 to 1"),
    (spaces.Box(-1, 1, (2,)), "a list of 2 numbers, each from -1 to 1"),
    (spaces.Box(0, 1, (1,)), "a list of 1 number, each from 0 to 1"),
    (spaces.Box(0, 1, ()), "a number from 0 to 1"),
    (spaces.Box(0, 9, (), np.int64), "an integer from 0 to 9"),
    (spaces.Box(np.array([0, -1]), np.array([1, 2])), "a list of 2 numbers, from [0.0, -1.0] to [1.0, 2.0]"),
    (spaces.Box(-np.inf, np.inf, (2,)), "a list of 2 numbers"),
    (spaces.Box(0, np.inf, (2,)), "a list of 2 numbers, each of at least 0"),
    (spaces.Box(-np.inf, 5, (2,)), "a list of 2 numbers, each of at most 5"),
    (spaces.Box(0, 255, (2, 2), np.uint8), "lists of integers within a list, of shape (2, 2), each from 0 to 255"),
    (spaces.MultiBinary(3), "a list of 3 integers, each 0 or 1"),
    (spaces.MultiDiscrete([2, 3]), "a list of 2 integers, from [0, 0] to [1, 2]"),
    (
        spaces.Tuple([spaces.Discrete(2), spaces.Box(0, 1, (1,))]),
        "a list of an integer from 0 to 1; a list of 1 number",
    ),
    (
        spaces.Dict(a=spaces.Discrete(2), b=spaces.MultiBinary(2)),
        'a JSON object with "a": an integer from 0 to 1; "b": ',
    ),
    (spaces.Text(5, charset="abc"), "a text of at most 5 characters"),
    (
        spaces.Sequence(spaces.Box(0, 1, (2,))),
        "a list of any length, of which each item is a list of 2 numbers, each from 0 to 1",
    ),
    (
        spaces.OneOf([spaces.Discrete(2), spaces.Box(0, 1, (2,))]),
        "a list of two, one of [0, an integer from 0 to 1]; [1, a list of 2 numbers, each from 0 to 1]",
    ),
    (spaces.Dict(a=spaces.Sequence(spaces.Discrete(2))), 'a JSON object with "a": a list of any length'),
]


@pytest.mark.parametrize(("space", "said"), SPACES, ids=str)
def test_round_trip(space, said):
    space.seed(0)
    for _ in range(20):
        action = space.sample()
        plain = canonical(space, action)
        assert canonical(space, plain) == plain
        hash(plain)
        assert same(native(space, plain), action) or native(space, plain) == action
        read = json.loads(json.dumps(plain))
        assert canonical(space, read if not isinstance(space, spaces.Dict) else dict(read)) == plain
    assert syntax(space).startswith(said)


WRONG = [
    None,
    10**400,
    "\x00",
    [],
    {},
    [[1], [2, 3]],
    float("nan"),
    float("inf"),
    [None, 1],
    {"a": 9},
    1e300,
    *(kind(bytes(n)) for n in (1, 2, 3, 4, 5, 6) for kind in (bytes, bytearray, memoryview)),
]


@pytest.mark.parametrize("space", [space for space, _ in SPACES], ids=str)
def test_what_is_not_in_the_space_is_refused(space):
    for wrong in WRONG:
        if (isinstance(space, spaces.Sequence) and wrong == []) or (wrong == {} and isinstance(space, spaces.Text)):
            continue
        with pytest.raises((ValueError, TypeError, OverflowError)):
            pytest.fail(f"{wrong!r} is taken for {canonical(space, wrong)!r}")


@pytest.mark.parametrize(
    ("space", "match"),
    [
        (spaces.Graph(spaces.Discrete(2), None), "Graph.* cannot be written as text; allowed: spaces other than Graph"),
        (spaces.Tuple([spaces.Graph(spaces.Discrete(2), None)]), "Graph.* cannot be written as text"),
        (spaces.Sequence(spaces.Discrete(2), stack=True), "cannot be written as text; allowed: .* without stack=True"),
        (spaces.Dict({1: spaces.Discrete(2)}), "a key is not a string"),
    ],
)
def test_what_cannot_be_written_is_refused(space, match):
    with pytest.raises(ValueError, match=match):
        syntax(space)


@pytest.mark.parametrize("dtype", [np.int8, np.int64, np.uint8])
def test_integers_are_elements_as_in_gymnasium(dtype):
    space = spaces.Discrete(100, start=20, dtype=dtype)
    for cast in (int, np.int8, np.int16, np.int64, np.uint8, np.uint64, float, str):
        for action in map(cast, (0, 19, 20, 119, 120, 127)):
            assert is_element(space, action) == space.contains(action), repr(action)
    assert not any(is_element(space, action) for action in (-(10**30), 10**30, True, np.True_))


def test_a_fraction_is_no_integer():
    with pytest.raises(ValueError, match="not made of integers"):
        canonical(spaces.MultiDiscrete([3, 3]), [0.5, 1])


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (3, "3"),
        (np.int64(3), "3"),
        ("as it is", "as it is"),
        (np.array([0.123456, -1e-9], np.float64), "[0.1235, 0.0]"),
        ({"a": 1, "b": np.array([[1, 2], [3, 4]])}, "a: 1\nb: [[1, 2], [3, 4]]"),
        ((1, 0.5), "[1, 0.5]"),
    ],
)
def test_format_value(value, text):
    assert format_value(value) == text


def test_a_large_array_is_shortened():
    assert len(format_value(np.zeros((210, 160, 3), np.uint8))) < 2000


class Wishes(spaces.Space):
    """Texts that a function makes: Gymnasium's own text of such a space has the function's address."""

    def __repr__(self):
        return f"Wishes({object()})"

    def sample(self, mask=None, probability=None):
        return f"wish {self.np_random.integers(9)}"


class Secrets(Wishes):
    def sample(self, mask=None, probability=None):
        raise RuntimeError


def test_a_space_is_described_without_addresses():
    wishes = Wishes(seed=1)
    drawn = Wishes(seed=1).sample()
    both = spaces.Dict(a=spaces.Discrete(2), b=spaces.Tuple([wishes, Secrets(), spaces.Box(0, 1, (2,))]))
    said = describe_space(both)
    assert re.fullmatch(
        r"Dict\('a': Discrete\(2\), 'b': Tuple\(Wishes, such as 'wish \d', Secrets, Box\(.*\)\)\)", said
    )
    assert describe_space(both) == said
    assert wishes.sample() == drawn
