"""What cannot be taught is refused in a sentence that tells what to do."""

import abc

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces
from lake import Head

import llf_teacher
from teachers.oracle import Oracle
from teachers.reward_oracle import RewardOracle


class Bare(gymnasium.Env):
    """The least environment."""

    observation_space = spaces.Discrete(2)
    action_space = spaces.Discrete(2)

    def __init__(self, **attributes):
        self.__dict__.update(attributes)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return 0, {}

    def step(self, action):
        return 1, 0.0, False, False, {}


@pytest.mark.parametrize(
    ("env", "limit"),
    [
        (lambda: gymnasium.make("CartPole-v1"), 500),
        (lambda: gymnasium.make("CartPole-v1", max_episode_steps=7), 7),
        (lambda: Bare(max_steps=250), 250),
        (lambda: Bare(max_steps=np.int64(250)), 250),
        (lambda: gymnasium.wrappers.TimeLimit(Bare(), 40), 40),
        (lambda: gymnasium.wrappers.TimeLimit(Bare(max_steps=250), 40), 40),
        (Bare, 100),
        (lambda: Bare(max_steps=None), 100),
        (lambda: Bare(max_steps=float("inf")), 100),
        (lambda: Bare(max_steps=True), 100),
    ],
)
def test_the_environments_own_time_limit_is_the_default(env, limit):
    assert llf_teacher.Lesson(env()).max_turns == limit
    assert llf_teacher.Lesson(env(), max_turns=3).max_turns == 3


class Abstract(Bare, abc.ABC):
    @abc.abstractmethod
    def step(self, action):
        """Left to others."""


class Spaceless(gymnasium.Env):
    def reset(self, *, seed=None, options=None):
        return 0, {}


class Undecided(Oracle):
    def _basics(self, truth):
        return ()


@pytest.mark.parametrize(
    ("env", "match"),
    [
        (Abstract, "env must not be an abstract class, got .*Abstract.*, which lacks step"),
        (gymnasium.Env, "env must be complete, got Env, which lacks reset, step, action_space, observation_space"),
        (Spaceless(), "env must be complete, got Spaceless, which lacks step, action_space, observation_space"),
        (Bare(action_space=spaces.Graph(spaces.Discrete(2), None)), "Graph.* cannot be written as text"),
    ],
)
def test_an_environment_that_is_not_complete(env, match):
    with pytest.raises(ValueError, match=match):
        llf_teacher.teach(env)


@pytest.mark.parametrize(
    ("oracle", "match"),
    [
        ("LakeOracle", "oracle must be a subclass of teachers.oracle.Oracle, or a function .*, got 'LakeOracle'"),
        (3, "oracle must be a subclass"),
        (dict, "oracle must be a subclass .*, got <class 'dict'>"),
        (RewardOracle(Bare), "oracle must be a subclass .*, got <teachers.reward_oracle.RewardOracle"),
        (Oracle, "oracle Oracle is abstract: it lacks _advice, _basics, _hindsight"),
        (Undecided, "oracle Undecided is abstract: it lacks _advice, _hindsight"),
        (lambda scratch: "no oracle", "oracle must be a teachers.oracle.Oracle, got 'no oracle'"),
    ],
)
def test_what_is_no_oracle(oracle, match):
    with pytest.raises(ValueError, match=match):
        llf_teacher.teach(Bare(), oracle)


@pytest.mark.parametrize("words", ["left", ["left", "right"], {0: "left"}, 3])
def test_what_are_no_action_words(words):
    with pytest.raises(ValueError, match="action_words must be a dict of words with their actions, got"):
        llf_teacher.teach(Bare(), action_words=words)


@pytest.mark.parametrize("parts", [[], Head(action=0, move="left"), "Go.", ("Go.",), None])
def test_an_instruction_that_is_no_tuple_of_claims(parts):
    class Hasty(RewardOracle):
        def _basics(self, truth):
            return parts

    with pytest.raises(TypeError, match=r"Hasty\._basics must return a tuple of claims, got"):
        llf_teacher.teach(Bare(), Hasty).reset(seed=0)


@pytest.mark.parametrize(
    ("space", "text", "played"),
    [
        (spaces.Dict(m=spaces.Discrete(2), v=spaces.Box(-1, 1, (2,))), '{"m": 1, "v": [0.5, -0.5]}', None),
        (spaces.Sequence(spaces.Discrete(3)), "[0, 2, 2]", (0, 2, 2)),
        (spaces.OneOf([spaces.Discrete(2), spaces.MultiBinary(2)]), "[1, [0, 1]]", None),
        (spaces.OneOf([spaces.Discrete(2), spaces.MultiBinary(2)]), "[0, 1]", (0, 1)),
    ],
)
def test_every_action_can_be_typed(space, text, played):
    class Taking(Bare):
        def step(self, action):
            self.took = action
            assert self.action_space.contains(action)
            return super().step(action)

    env = llf_teacher.teach(Taking(action_space=space), text=True)
    env.reset(seed=0)
    info = env.step(text)[4]
    assert "parse_failure" not in info
    assert played is None or env.session.world.env.took == played
    assert "parse_failure" in env.step("[9, 9]")[4]


@pytest.mark.parametrize(
    ("env", "match"),
    [(object(), "must be a gymnasium.Env, or a function that makes one, got <object"), (lambda: 3, "got 3")],
)
def test_what_is_no_environment(env, match):
    with pytest.raises(ValueError, match=match):
        llf_teacher.teach(env)


def test_an_old_environment_is_told_apart():
    class Old:
        def step(self, action):
            pass

    with pytest.raises(ValueError, match="wrap an environment of the old Gym in OldGym"):
        llf_teacher.teach(Old())
