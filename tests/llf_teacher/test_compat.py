"""A user of LLF-Bench changes one import: its checks, its evaluation loop and its paper's listing, rewritten."""

import copy
import re

import numpy as np
import pytest
from design import sampled
from gymnasium import spaces
from gymnasium.utils.env_checker import data_equivalence
from playing import steps
from sampling import IDS

import llf_teacher
import llf_teacher.compat as llfbench
from llf_teacher.registry import entry
from llf_teacher.students.agents import as_text

DISCRETE = [id for id in llf_teacher.ids() if isinstance(llf_teacher.make(id).action_space, spaces.Discrete)]
GRID = "llf-gridworld-v0"


def random_actions(env, count=8):
    world = env.unwrapped.session.world
    rng = np.random.default_rng(0)
    return [world.sample_action(rng) for _ in range(count)]


# --- its environment checks


@pytest.mark.parametrize("id", IDS)
def test_reset_and_step_have_its_shapes(id):
    env = llfbench.make(id)
    observation, info = env.reset(seed=0)
    assert set(observation) == {"observation", "instruction", "feedback"}
    assert observation["feedback"] is None
    assert isinstance(observation["instruction"], str)
    assert info["success"] is False
    assert "expert_action" in info
    for observation, reward, terminated, truncated, info in steps(env, random_actions(env)):
        assert observation["instruction"] is None
        assert isinstance(observation["feedback"], str)
        seen = observation["observation"]
        assert seen is None or env.observation_space["observation"].contains(seen)
        low, high = env.reward_range
        assert low <= reward <= high
        assert isinstance(info["success"], bool)
        assert not truncated
        assert isinstance(terminated, bool)


@sampled(lambda id: {entry(id).family.name})
@pytest.mark.parametrize("id", IDS)
def test_all_types_can_be_set(id):
    instructions, feedbacks = llfbench.supported_types(id)
    env = llfbench.make(id)
    assert (instructions, feedbacks) == (env.INSTRUCTION_TYPES, env.FEEDBACK_TYPES)
    assert (env.instruction_type, env.feedback_type) == ("b", "a")
    for instruction in instructions:
        env.set_instruction_type(instruction)
        assert env.instruction_type == instruction
        for feedback in (*feedbacks, "a", "n", "m", set(feedbacks[:2]), list(feedbacks), tuple(feedbacks)):
            env.set_feedback_type(feedback)
            observation, _ = env.reset(seed=1)
            assert observation["instruction"]
            for observation, *_ in steps(env, random_actions(env, 3)):
                if feedback == "n":
                    assert observation["feedback"] == ""
    env.set_feedback_type(set(feedbacks[:2]))
    assert env.feedback_type == set(feedbacks[:2])


def test_what_is_not_supported_is_refused():
    with pytest.raises(ValueError, match="feedback type 'x'"):
        llfbench.make(GRID, feedback_type="x")
    env = llfbench.make(GRID)
    with pytest.raises(ValueError, match="instruction type 'q' is not supported"):
        env.set_instruction_type("q")
    with pytest.raises(ValueError, match="names 'z'"):
        env.set_feedback_type(["r", "z"])
    with pytest.raises(ValueError, match="paraphrase must be"):
        env.set_paraphrase_method(None)


@sampled(lambda id, method: {id, (entry(id).family.name, method)})
@pytest.mark.parametrize("id", IDS)
@pytest.mark.parametrize("method", [0, 5, 1000, "random", lambda templates, **slots: templates[0].format(**slots)])
def test_paraphrases(id, method):
    def words():
        env = llfbench.make(id)
        env.set_paraphrase_method(method)
        assert env.paraphrase_method is method
        said = [env.reset(seed=2)[0]["instruction"]]
        return said + [observation["feedback"] for observation, *_ in steps(env, random_actions(env))]

    assert words() == words()


def test_seeded_once_then_plain_resets():
    def houses():
        env = llfbench.make(GRID)
        env.reset(seed=5)
        return [env.reset()[0]["observation"] for _ in range(3)]

    assert houses() == houses()


@pytest.mark.parametrize("id", IDS)
def test_texts_and_native_actions_are_the_same(id):
    spoken, native = llfbench.TextWrapper(llfbench.make(id)), llfbench.make(id)
    spoken.reset(seed=3)
    native.reset(seed=3)
    actions = random_actions(native)
    for said, done in zip(steps(spoken, map(as_text, actions)), steps(native, actions), strict=True):
        assert data_equivalence(said[:3], done[:3], exact=True)
    assert spoken.reward_range == native.reward_range


def test_gridworld_takes_numbers_and_names():
    outcomes = []
    for action in (1, np.int64(1), "1", "east", "East", "Thought: why not?\nResponse: east"):
        env = llfbench.make(GRID)
        env.reset(seed=0)
        outcomes.append(env.step(action)[0]["observation"])
    assert len(set(outcomes)) == 1


@pytest.mark.parametrize("nonsense", ["dig", "import os", "", 17, None, {"a": object()}, [[]]])
def test_nonsense_costs_a_turn_and_is_told(nonsense):
    env = llfbench.make(GRID)
    env.reset(seed=0)
    observation, reward, terminated, truncated, info = env.step(nonsense)
    assert (reward, terminated, truncated, info["success"]) == (0.0, False, False, False)
    assert "one of north, east, west, south" in observation["feedback"]
    assert env.unwrapped.session.moment.turn == 1


# --- its evaluation loop


class Follower:
    """An agent of LLF-Bench's form that reads its feedback."""

    def reset(self, docstring):
        self.docstring = docstring

    def act(self, observation, feedback):
        found = re.search(
            r"Go (\w+) next|should be (\w+)|(\w+) from here|right way is (\w+)|Now head (\w+)|move (\w+) now",
            feedback or "",
        )
        return next(filter(None, found.groups())) if found else "north"


def evaluate(agent, env, *, horizon=30, episodes=5, seed=0, sparse_reward=False):
    """The mean score: seeded once, plain resets, stopping at success, termination or truncation."""
    env.reset(seed=seed)
    scores = []
    for _ in range(episodes):
        observation, info = env.reset()
        agent.reset(observation["instruction"])
        score = 0.0
        for _ in range(horizon):
            action = agent.act(observation["observation"], observation["feedback"])
            observation, reward, terminated, truncated, info = env.step(action)
            score += float(info["success"]) if sparse_reward else reward
            if info["success"] or terminated or truncated:
                break
        scores.append(score)
    return np.mean(scores)


def test_an_agent_that_reads_solves_the_gridworld():
    assert evaluate(Follower(), llfbench.make(GRID)) == 1.0
    assert evaluate(Follower(), llfbench.make(GRID), sparse_reward=True) == 1.0
    assert evaluate(Follower(), llfbench.make(GRID, feedback_type="n")) < 1.0


@pytest.mark.parametrize("id", IDS)
def test_experts_succeed(id):
    class Expert:
        def reset(self, docstring):
            pass

        def act(self, observation, feedback):
            plan = env.unwrapped.teacher.oracle.plan(env.unwrapped.session.world.truth, 1)
            return plan[0]

    env = llfbench.make(id)
    assert evaluate(Expert(), env, horizon=entry(id).family.max_turns, sparse_reward=True) == 1.0


@pytest.mark.parametrize("id", IDS)
def test_the_papers_listing(id):
    """`input` is a function; the episode ends when the environment says so."""
    env = llfbench.make(id.replace("llf-", "verbal-"), max_turns=5)
    actions = iter(random_actions(env, 5))
    prompts = []

    def ask(prompt):
        prompts.append(prompt)
        return as_text(next(actions))

    done = False
    cumulative_reward = 0.0
    observation, _ = env.reset(seed=0)
    while not done:
        action = ask("\n".join(f"{part}" for part in observation.values() if part) + "\nAction: ")
        observation, reward, terminated, truncated, _info = env.step(action)
        cumulative_reward += reward
        done = terminated or truncated
    assert len(prompts) == 5 or terminated
    assert all(prompt.endswith("Action: ") and len(prompt) > 20 for prompt in prompts)


# --- its wrappers


def test_terminal_free():
    env = llfbench.TerminalFreeWrapper(llfbench.make(GRID, max_turns=2))
    env.reset(seed=0)
    for turn in range(1, 5):
        _, _reward, terminated, truncated, info = env.step(0)
        assert (terminated, truncated) == (False, False)
        assert info["truncated"] is (turn >= 2)
    env.set_feedback_type("r")
    assert env.feedback_type == {"r"}


@pytest.mark.parametrize("id", DISCRETE)
def test_shuffled_actions(id):
    env = llfbench.RandomActionOrderWrapper(llfbench.make(id))
    plain = llfbench.make(id)
    orders = set()
    for seed in range(12):
        env.reset(seed=seed)
        plain.reset(seed=seed)
        order = tuple(env._order)
        orders.add(order)
        for number, action in enumerate(order[:3]):
            outcome = env.step(number)[1:4]
            assert outcome == plain.step(action)[1:4]
            if any(outcome[1:]):
                break
    assert len(orders) > 1
    _, info = env.reset(seed=1)
    plain.reset(seed=1)
    expert = plain.unwrapped.teacher.oracle.plan(plain.unwrapped.session.world.truth, 1)[0]
    assert env._order[info["expert_action"]] == expert
    again = llfbench.RandomActionOrderWrapper(llfbench.make(id))
    again.reset(seed=11)
    env.reset(seed=11)
    assert again._order == env._order


def test_names_are_not_shuffled():
    env, plain = llfbench.RandomActionOrderWrapper(llfbench.make(GRID)), llfbench.make(GRID)
    env.reset(seed=4)
    plain.reset(seed=4)
    assert env.step("west")[0] == plain.step("west")[0]


@pytest.mark.parametrize("id", DISCRETE)
def test_full_information(id):
    env = llfbench.FullInformationWrapper(llfbench.make(id))
    env.reset(seed=0)
    for action in random_actions(env, 4):
        before = copy.deepcopy(env.env)
        result = env.step(action)
        outcomes = result[4]["full_information"]
        assert len(outcomes) == env.action_count
        same = outcomes[int(action)]
        assert (same["observation"], same["reward"]) == result[:2]
        for number, outcome in enumerate(outcomes):
            assert copy.deepcopy(before).step(number)[0] == outcome["observation"]
        if result[2] or result[3]:
            env.reset()


@pytest.mark.parametrize("wrapper", [llfbench.RandomActionOrderWrapper, llfbench.FullInformationWrapper])
def test_wrappers_of_discrete_actions_refuse_others(wrapper):
    with pytest.raises(ValueError, match="needs discrete actions"):
        wrapper(llfbench.make("llf-poem-Haiku-v0"))
