"""Code that was written for LLF-Bench's Meta-World, and for tutorials of others, runs as it is."""

import json
import random

import numpy as np
import pytest
from opengl import with_opengl
from sampling import IDS

PICK, REACH = "llf-metaworld-pick-place-v2", "llf-metaworld-reach-v3"


def numbers(text):
    """As tutorials read an array: the brackets are cut, the rest is split at blanks."""
    return [float(part) for part in text.replace("[", "").replace("]", "").split()]


@pytest.mark.parametrize("id", [param for param in IDS if param.values[0].startswith("llf-metaworld-")])
def test_metaworld_observations_are_strings_of_arrays(id, llfbench):
    env = llfbench.make(id, feedback_type="n")
    parts = json.loads(env.reset(seed=0)[0]["observation"])
    assert all(isinstance(value, str) for value in parts.values())
    assert len(parts) >= 2
    assert np.allclose(numbers(parts["hand_pos"]), env.current_observation[:3], atol=6e-4)
    assert len(numbers(parts["hand_pos"])) == 3
    assert not [name for name in parts if "unused" in name or name.startswith("_")]


def test_control_mode(llfbench):
    env = llfbench.make(REACH, paraphrase=0)
    instruction = env.reset(seed=0)[0]["instruction"]
    assert "in absolute coordinates" in instruction
    target, hand = env.expert_action, env.current_observation[:3]
    env.control_mode("relative")
    assert np.allclose(env.expert_action[:3], target[:3] - hand, atol=0.011)
    env.step([0.0, 0.0, 0.05, 0.0])
    assert 0.01 < env.current_observation[2] - hand[2] < 0.06
    advice = next(atom.claim for atom in env.step(env.expert_action)[4]["atoms"] if atom.kind == "fp")
    assert advice.action == tuple(env.expert_action.tolist())  # in relative coordinates, too
    assert "in relative coordinates" in env.reset()[0]["instruction"]
    assert "from where the hand is" in env.reset()[0]["instruction"]
    env.control_mode("absolute")
    env.reset(seed=0)
    assert env.expert_action.tolist() == target.tolist()
    with pytest.raises(ValueError, match="control mode 'polar' is unknown; allowed: absolute, relative"):
        env.control_mode("polar")


def test_what_is_said_under_either_control_is_true(llfbench):
    env = llfbench.make(REACH, privileged_info=True)
    env.reset(seed=1)
    for mode in ("relative", "absolute", "relative"):
        env.control_mode(mode)
        _, info = env.reset()
        for _ in range(3):
            lab = env.unwrapped.session.world.scratch()
            assert lab.relative is (mode == "relative")
            for atom in info["atoms"]:
                assert atom.claim.holds(info["moment"], lab), (mode, atom.text)
            info = env.step(env.action_space.sample())[4]


def test_simulator_and_policy_are_there(llfbench):
    env = llfbench.make(REACH)
    env.reset(seed=0)
    hand = env.current_observation[:3]
    assert np.allclose(env.mw_env.get_endeff_pos(), hand)
    assert np.allclose(env.mw_policy._parse_obs(env.current_observation)["hand_pos"], hand)
    for _ in range(5):
        env.mw_env.step(np.ones(4))  # to no effect
    assert np.allclose(env.mw_env.get_endeff_pos(), hand)
    twin = llfbench.make(REACH)
    twin.reset(seed=0)
    assert env.step(env.expert_action)[:2] == twin.step(twin.expert_action)[:2]


IMAGES = """if True:
    import numpy as np
    import llf_teacher.compat as llfbench
    env = llfbench.make("llf-metaworld-reach-v3", visual=True, feedback_type="n")
    observation, info = env.reset(seed=0)
    seen = observation["observation"]
    assert seen.keys() == {"text", "image"}
    assert "hand_pos" in seen["text"]
    assert (seen["image"].shape, seen["image"].dtype) == ((240, 240, 3), np.uint8)
    assert env.observation_space["observation"].contains(seen)
    assert info["video"] is None
    assert env.step(env.expert_action)[4]["video"] is None
    env.render_video(True)
    assert len(env.reset()[1]["video"]) == 1
    assert env.step("nonsense")[4]["video"] is None
    film = env.step(env.expert_action)[4]["video"]
    assert 3 <= len(film) <= 15
    assert all(frame.shape == (240, 240, 3) for frame in film)
    assert (film[0] != film[-1]).any()
    env.render_video(False)
    assert env.step(env.expert_action)[4]["video"] is None
    print("seen")
"""


def test_images():
    assert with_opengl(IMAGES) == "seen\n"


def parse(text):
    return {key: numbers(value) for key, value in json.loads(text).items()}


class TracedEnv:
    """The environment of the tutorial."""

    def __init__(self, llfbench, name, seed=0, relative=True):
        random.seed(seed)
        self.env = llfbench.make(name, feedback_type=("hp", "hn"), warning=False)
        self.env.reset(seed=seed)
        self.env.action_space.seed(seed)
        self.env.control_mode("relative" if relative else "absolute")

    def reset(self):
        observation, info = self.env.reset()
        observation["observation"] = parse(observation["observation"])
        return observation, info

    def step(self, action):
        observation, *rest = self.env.step(action)
        observation["observation"] = parse(observation["observation"])
        return observation, *rest


def rollout(env, horizon, controller):
    observation, _ = env.reset()
    trajectory = [(observation, 0.0, False)]
    for _ in range(horizon):
        observation, reward, terminated, truncated, info = env.step(controller(observation["observation"]))
        trajectory.append((observation, reward, info["success"]))
        if terminated or truncated or info["success"]:
            break
    return trajectory


def test_the_tutorial(llfbench):
    env = TracedEnv(llfbench, PICK)

    def expert(observation):
        action = env.env.expert_action
        return env.env.action_space.sample() if action is None else action

    def controller(observation):
        """What a model might write: above the puck, down to it, grip, and to the goal."""
        hand, puck, goal = (np.array(observation[key]) for key in ("hand_pos", "puck_pos", "goal_pos"))
        if np.abs(hand[:2] - puck[:2]).max() > 0.02:
            return [*(puck - hand + [0, 0, 0.1]), 0]
        if hand[2] - puck[2] > 0.04:
            return [*(puck - hand), 0]
        if observation["gripper_distance_apart"][0] > 0.73:
            return [0, 0, 0, 1]
        return [*(goal - hand), 1]

    for policy in (expert, controller):
        trajectory = rollout(env, 30, policy)
        assert trajectory[-1][2] is True
        assert all(isinstance(observation["feedback"], str) for observation, *_ in trajectory[1:])
    instruction = trajectory[0][0]["instruction"]
    infix = "You will get observations of the robot state "
    prefix, postfix = instruction.split(infix)
    goal = "The goal of the task is to pick up a puck and put it to a goal position. "
    hint = prefix + goal + infix + postfix
    assert hint.startswith("Your job is to control a Sawyer robot arm to solve a pick-place task. The goal of")
    assert instruction.replace("json strings.", "dicts.") != instruction
    assert "absolute" not in instruction


def test_a_guide(llfbench):
    class Guide:
        """Judges a poem: the query is the seed of the task, the response the poem; there is no reference."""

        def get_feedback(self, query, response, reference=None, **kwargs):
            env = llfbench.make("llf-poem-Haiku-v0", feedback_type=("hp", "hn"))
            env.reset(seed=query)
            observation, reward, _, _, info = env.step(response)
            return float(info["success"]) if reference is None else reward, observation["feedback"]

    guide = Guide()
    right = "rain taps on the tin\nnobody answers the bell\none cup on the sill"
    score, feedback = guide.get_feedback(0, right)
    assert score == 1.0
    assert feedback
    score, feedback = guide.get_feedback(0, right.replace("tin", "window"), reference="reward")
    assert score == pytest.approx(-1 / 3)
    assert feedback
