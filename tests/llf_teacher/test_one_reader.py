"""Every door reads answers in the same way."""

import gymnasium
import pytest
from gymnasium import spaces

import llf_teacher
import llf_teacher.compat as llfbench
from teachers.atoms import ParseFailure

EAST = [
    "**Response:** go east",
    '<think>north or east?</think>\n```json\n{"thought": "a door", "action": "east"}\n```',
    "\\boxed{1}",
    "east (1)\n\nThere is a door.",
]
NONE = ["not east", "east or west", "<think>east", "1 (west)"]


def doors():
    yield "make", llf_teacher.make("llf-gridworld-v0", text=True)
    yield "compat", llfbench.make("llf-gridworld-v0")


@pytest.mark.parametrize(("name", "env"), list(doors()))
@pytest.mark.parametrize("text", EAST)
def test_an_answer_means_the_same_at_each_door(name, env, text):
    told = []
    for answer in ("east", text):
        env.reset(seed=3)
        observation, reward, *_, info = env.step(answer)
        assert "parse_failure" not in info
        told.append((observation["observation"], reward))
    assert told[0] == told[1]


@pytest.mark.parametrize(("name", "env"), list(doors()))
@pytest.mark.parametrize("text", NONE)
def test_what_is_none_is_told_why(name, env, text):
    env.reset(seed=3)
    observation, *_, info = env.step(text)
    failure = info["parse_failure"]
    assert type(failure) is ParseFailure
    assert failure.why in observation["feedback"]
    assert failure.expected in observation["feedback"]


class Lever(gymnasium.Env):
    """Pays what it is given."""

    observation_space = spaces.Discrete(1)
    action_space = spaces.Discrete(3)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return 0, {}

    def step(self, action):
        return 0, float(action), False, False, {}


def test_an_environment_of_ones_own_is_answered_likewise():
    env = llf_teacher.teach(Lever, text=True, action_words={"pull up": 2, "go slow": 1, "wait": 0}, reward_range=(0, 2))
    env.reset(seed=0)
    for text, paid in (
        ("**Action:** pull up", 2.0),
        ("I will go slow now.", 1.0),
        ("2 (pull up)", 2.0),
        ('{"thought": "hm", "action": "wait"}', 0.0),
        ("action 1", 1.0),
        ("<think>2</think>[1]", 1.0),
    ):
        assert env.step(text)[1] == paid
    for text in ("slow pull up", "pull", "1 (wait)", "do not wait"):
        assert "parse_failure" in env.step(text)[-1]


def test_what_is_not_known_to_be_harmless_pays_the_least_reward():
    env = llf_teacher.teach(Lever, text=True, reward_range=(-3, 2))
    env.reset(seed=0)
    assert env.step("hm")[1] == -3.0
