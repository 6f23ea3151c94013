"""A student's action asks, or is an action of the world."""

import numpy as np
import pytest
from gymnasium import spaces

from pz_envs.text.questions import ASK, asking_space, read_question
from worlds.spaces import Prose
from worlds.testing import plain


@pytest.mark.parametrize(
    ("space", "asking", "plain_action"),
    [
        (spaces.Discrete(3), 3, 2),
        (spaces.Discrete(3, start=2), 5, 4),
        (Prose(), "ask", "go north"),
        (Prose(), "Thought: hm.\nResponse: Ask!", "I ask you to go north"),
        (Prose(), "Response: ask\nThought: I do not know.", "Response: ask\nResponse: north"),
        (spaces.Box(-1, 1, (2,)), {"action": np.zeros(2, "f4"), ASK: 1}, {"action": np.ones(2, "f4"), ASK: 0}),
        (spaces.Box(-1, 1, (2,)), {"action": np.zeros(2, "f4"), ASK: 1}, (0.25, -1.0)),
    ],
)
def test_how_a_question_is_put(space, asking, plain_action):
    wide = asking_space(space)
    assert read_question(asking, wide)[0] is True
    asks, action = read_question(plain_action, wide)
    assert asks is False
    assert plain(action) == plain(plain_action["action"] if isinstance(plain_action, dict) else plain_action)
    if not isinstance(space, Prose):
        assert wide.contains(asking)


@pytest.mark.parametrize("wrong", [1, None, {"action": 0}, {"action": 0, ASK: 2}, {"action": 0, ASK: 0, "why": 1}])
def test_what_is_neither_a_question_nor_an_action(wrong):
    with pytest.raises(
        ValueError, match=r"must be a dict of `action` and `ask` \(0 or 1\), got .*the state is unchanged"
    ):
        read_question(wrong, asking_space(spaces.Box(-1, 1, (2,))))
