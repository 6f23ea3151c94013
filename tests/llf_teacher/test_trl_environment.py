"""The environment that TRL is given, without TRL; tests/integrations/trl trains in it."""

import inspect

import pytest
from playing import Counting

import llf_teacher
from llf_teacher.integrations.trl import OVER, FeedbackEnvironment
from teachers.oracle import RefusalError
from teachers.oracles.gridworld import GridworldOracle

GRID = "llf-gridworld-v0"
ARMS = "llf-bandits-BanditTenArmedGaussian-v0"


def test_the_model_sees_one_tool():
    """Every other public method would be one, too."""
    methods = {name for name, _ in inspect.getmembers(FeedbackEnvironment, inspect.isfunction) if name[0] != "_"}
    assert methods == {"reset", "act", "get_reward"}


def actions(seed):
    """The shortest way from where a seed begins."""
    env = llf_teacher.make(GRID, text=True)
    env.reset(seed=seed)
    return env.session.teacher.oracle.plan(env.session.world.truth, 20)


@pytest.mark.parametrize("reward", ["return", "success", "regret"])
def test_it_pays_what_an_episode_is_worth(reward):
    way = actions(3)
    words = ("north", "east", "west", "south")
    played = llf_teacher.rollout(lambda each: [words[way[len(each[0]) // 2 - 1]]], GRID, [3])[0]
    environment = FeedbackEnvironment(GRID, reward=reward)
    told = environment.reset(seed=3, prompt=[{"role": "user", "content": ""}], other=1)
    assert played.turns[0].prompt[1]["content"] in told
    for action in way:
        said = environment.act(words[action], thought="That is the way.")
    assert played.success
    assert said.endswith(OVER)
    assert environment.get_reward() == {"return": sum(played.rewards), "success": 1.0, "regret": 0.0}[reward]
    with pytest.raises(ValueError, match="The episode is over; there is nothing more to do"):
        environment.act("north")


def test_it_hears_what_students_hear():
    (played,) = llf_teacher.rollout(lambda each: ["3"], ARMS, [5], max_turns=4)
    environment = FeedbackEnvironment(ARMS, max_turns=4)
    environment.reset(seed=5)
    heard = [environment.act(3) for _ in range(4)]  # models give numbers, too
    assert heard[:3] == [turn.prompt[-1]["content"] for turn in played.turns[1:]]
    assert played.turns[-1].feedback in heard[-1]
    assert environment.get_reward() == sum(played.rewards)


@pytest.mark.parametrize("reward", ["return", "regret"])
def test_silence_pays_no_better_than_nonsense(reward):
    """A model that calls no tool, or stops early, has given texts that are no action."""
    silent, babbling = (FeedbackEnvironment(ARMS, reward=reward, max_turns=5) for _ in range(2))
    silent.reset(seed=1)
    babbling.reset(seed=1)
    for _ in range(5):
        assert "arm" in babbling.act("fly").lower()
    assert silent.get_reward() == babbling.get_reward() == silent.get_reward()
    acting = FeedbackEnvironment(ARMS, reward=reward, max_turns=5)
    for arm in range(10):
        acting.reset(seed=1)
        for _ in range(5):
            acting.act(str(arm))
        assert acting.get_reward() >= silent.get_reward()


def test_a_row_says_what_is_played():
    environment = FeedbackEnvironment(GRID, max_turns=2)
    assert "treasure" in environment.reset(seed=0)
    row = {"id": ARMS, "seed": 2, "teacher": "silent", "max_turns": 7, "feedback_type": None}  # as tables fill gaps
    first = environment.reset(**row)
    assert "arm" in first
    assert "Teacher: " not in environment.act("1")
    assert "treasure" in environment.reset(seed=0)
    assert environment.reset(**row) == first


def test_a_teacher_of_ones_own_has_each_conversation_to_itself():
    teacher = Counting()
    one, other = (FeedbackEnvironment(GRID, teacher=teacher) for _ in range(2))
    assert "That makes 1." in one.reset(seed=1)
    assert "That makes 1." in other.reset(seed=1)
    assert "That makes 2." in one.act("north")


def test_an_unknown_reward():
    with pytest.raises(ValueError, match="reward must be one of return, success, regret, got 'sum'"):
        FeedbackEnvironment(reward="sum")


def test_without_values_the_reward_of_regret_is_the_return(monkeypatch):
    def refuse(self, moment):
        raise RefusalError("nobody knows")

    monkeypatch.setattr(GridworldOracle, "regret", refuse)
    rewards = []
    for reward in ("return", "regret"):
        environment = FeedbackEnvironment(GRID, max_turns=2, failure_reward=0.5, reward=reward)
        environment.reset(seed=0)
        environment.act("west")
        environment.act("nonsense")
        rewards.append(environment.get_reward())
    assert rewards == [0.5, 0.5]
