"""Code as people have written it for LLF-Bench runs without an edit, once `install()` was called."""

import json
import os
import random
import subprocess
import sys

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from sampling import IDS

import llf_teacher
import llf_teacher.compat
from llf_teacher.registry import entries, entry

GRID, BANDIT, PICK = "llf-gridworld-v0", "llf-bandits-BanditTwoArmedHighLowFixed-v0", "llf-metaworld-pick-place-v2"
ALFWORLD, PARKING = "llf-alfworld-v0", "llf-highway-parking-v0"
REACH = "llf-metaworld-reach-v3"


@pytest.fixture
def llfbench():
    llf_teacher.compat.install()
    import llfbench

    yield llfbench
    llf_teacher.compat.uninstall()


# --- import llfbench


def run(code, folder):
    return subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=False)


def test_without_installing_there_is_no_llfbench(tmp_path):
    result = run("import llf_teacher.compat, llfbench", tmp_path)
    assert "No module named 'llfbench'" in result.stderr


def test_modules_resolve_to_ours_and_back(tmp_path):
    code = """if True:
        import sys, llf_teacher.compat as compat
        compat.install(); compat.install()
        assert len([finder for finder in sys.meta_path if type(finder).__module__.startswith("llf_teacher")]) == 1
        import llfbench, llfbench.envs.env_wrappers
        from llfbench.envs.llf_env import LLFWrapper, Feedback
        from llfbench.envs.env_wrappers import TextWrapper, EnvCompatibility
        from llfbench.agents.utils import set_seed
        from llfbench.utils import generate_combinations_dict
        assert (llfbench.make, LLFWrapper, TextWrapper) == (compat.make, compat.LLFWrapper, compat.TextWrapper)
        assert llfbench.envs.env_wrappers.TerminalFreeWrapper is compat.TerminalFreeWrapper
        try:
            import llfbench.envs.metaworld
        except ModuleNotFoundError as error:
            assert error.name == "llfbench.envs.metaworld"
        compat.uninstall(); compat.uninstall()
        assert not [name for name in sys.modules if name.startswith("llfbench")]
        try:
            import llfbench
        except ModuleNotFoundError:
            print("gone")
    """
    assert run(code, tmp_path).stdout == "gone\n"


def test_the_real_one_is_left_alone(tmp_path):
    (tmp_path / "llfbench").mkdir()
    (tmp_path / "llfbench" / "__init__.py").write_text("REAL = True\n")
    code = """if True:
        import llf_teacher.compat
        llf_teacher.compat.install()
        import llfbench
        assert llfbench.REAL and not hasattr(llfbench, "make")
        try:
            import llfbench.utils
        except ModuleNotFoundError:
            print("nothing is mixed in")
        llf_teacher.compat.uninstall()
        import llfbench
        assert llfbench.REAL
    """
    assert run(code, tmp_path).stdout == "nothing is mixed in\n"


# --- spaces


SPACES = {
    "alfworld": spaces.Text,
    "bandits": spaces.Discrete,
    "gridworld": spaces.Discrete,
    "metaworld": spaces.Box,
    "movies": spaces.Text,
    "optimization": spaces.Text,
    "parking": spaces.Box,
    "poem": spaces.Text,
}


@pytest.mark.parametrize("family", SPACES)
def test_action_spaces_are_those_of_llfbench(family, llfbench):
    id = next(id for id, entry in entries().items() if entry.family.name == family)
    assert isinstance(llfbench.TextWrapper(llfbench.make(id)).action_space, SPACES[family])


@pytest.mark.parametrize("id", IDS)
def test_actions_are_sampled_and_played(id, llfbench):
    env = llfbench.make(id, feedback_type="n")
    space = env.action_space
    env.reset(seed=0)
    space.seed(0)
    for _ in range(5):
        action = space.sample()
        _, _, terminated, truncated, info = env.step(action)
        if not isinstance(space, spaces.Text):
            assert "parse_failure" not in info
        if terminated or truncated:
            env.reset()
    if isinstance(space, spaces.Discrete):
        assert env.action_space.n == env.unwrapped.aec.world.action_space.n


def test_extreme_actions_are_played(llfbench):
    for id in (PARKING, REACH):
        env = llfbench.make(id, feedback_type="n")
        env.reset(seed=0)
        for action in (env.action_space.low, env.action_space.high, np.nextafter(env.action_space.high, 0)):
            assert "parse_failure" not in env.step(action)[4]


def test_parking_is_seen_as_highway_env_sees_it(llfbench):
    env, bare = llfbench.make(PARKING), entry(PARKING).family.make_world()
    seen, expected = env.reset(seed=3)[0]["observation"], bare.reset(seed=3)[0]
    for action in (None, [1.0, 0.5], "nonsense", [-1.0, 0.0]):
        if action is not None:
            seen = env.step(action)[0]["observation"]
            expected = bare.observe() if action == "nonsense" else bare.step(action)[0]
        assert seen.keys() == expected.keys() == {"observation", "achieved_goal", "desired_goal"}
        assert all((seen[key] == expected[key]).all() for key in seen)
        assert env.observation_space["observation"].contains(seen)


@pytest.mark.parametrize(
    ("id", "reward"),
    [
        (GRID, 0.0),
        (BANDIT, 0.0),
        (PARKING, 0.0),
        (REACH, 0.0),
        ("llf-optimization-Booth-v0", -0.01),
        ("llf-optimization-SixHumpCamel-v0", -0.01),
        ("llf-poem-Haiku-v0", -1.0),
        ("llf-reco-movie-v0", -1.0),
    ],
)
def test_what_is_no_action_pays_what_it_pays_in_llfbench(id, reward, llfbench):
    env = llfbench.make(id)
    env.reset(seed=0)
    observation, paid, _, _, info = env.step("\x00 nothing that could be read")
    assert paid == reward
    assert info["parse_failure"]
    assert observation["feedback"]


# --- texts


def test_alfworld_phrases(llfbench):
    env = llfbench.make(ALFWORLD)
    observation, info = env.reset(seed=0)
    allowed = "You are allowed to take the following actions:"
    goal = env.unwrapped.aec.world.truth.game.goal
    assert observation["instruction"].split("Your task is to: ")[1].startswith(f"{goal}.")
    for action in ("look", "\x00", info["admissible_commands"][0]):
        before, after = observation["observation"].split(allowed)
        assert before
        assert after.strip(" .").split(", ") == env.unwrapped.aec.world.commands()
        observation, *_ = env.step(action)
    assert "Your task is to:" in env.reset(seed=0)[0]["observation"].split(allowed)[0]


@pytest.mark.parametrize("id", [id for id in llf_teacher.ids() if id.startswith("llf-bandits-")])
def test_bandits_are_named(id, llfbench):
    instruction = llfbench.make(id).reset(seed=0)[0]["instruction"]
    name, rest = instruction.split(": ", 1)
    assert name == id.removeprefix("llf-bandits-").removesuffix("-v0")
    world = entry(id).family.make_world(problem=name.removeprefix("Bandit"))
    assert rest.startswith(f"{world.arms} arms")
    world.reset(seed=0)
    truth = world.truth
    for chance in set(truth.chances) if "0." in rest.split("\n")[0] and world.arms == 2 else ():
        assert f"{chance}" in rest.split("\n")[0]


def test_make_is_as_it_was():
    """All of this is the compatible surface's own."""
    env = llf_teacher.make(ALFWORLD, text=True)
    assert "Admissible commands: " in env.reset(seed=0)[0]["observation"]
    instruction = llf_teacher.make(BANDIT, text=True).reset(seed=0)[0]["instruction"]
    assert "BanditTwoArmed" not in instruction


# --- attributes


def test_make_takes_a_seed(llfbench):
    def house(**options):
        return llfbench.make(GRID, **options).reset()[0]["observation"]

    assert house(seed=3) == house(seed=3) == llfbench.make(GRID).reset(seed=3)[0]["observation"] != house(seed=4)
    env = llfbench.TextWrapper(llfbench.make(GRID))
    assert env.seed(3) == [3]
    assert env.reset()[0]["observation"] == house(seed=3)
    env.seed(5)
    assert env.reset(seed=3)[0]["observation"] == house(seed=3)  # the one that is given counts
    assert env.reset()[0]["observation"] != house(seed=5)


def test_make_warns_unless_it_is_told_not_to(llfbench, recwarn):
    llfbench.make(PICK, warning=False)
    assert not recwarn
    with pytest.warns(UserWarning, match="rewards differ from v2"):
        llfbench.make(PICK)


def test_expert_action(llfbench):
    env = llfbench.RandomActionOrderWrapper(llfbench.make(GRID))
    with pytest.raises(ResetNeeded, match="call reset"):
        env.env.expert_action  # noqa: B018 (it raises)
    _, info = env.reset(seed=1)
    for _ in range(20):
        assert env.expert_action == info["expert_action"] == env.external_action(env.env.expert_action)
        _, reward, _, _, info = env.step(env.expert_action)
        if info["success"]:
            break
    assert reward == 1.0
    assert env.expert_action is None


def test_action_order(llfbench):
    env, plain = llfbench.RandomActionOrderWrapper(llfbench.make(GRID)), llfbench.make(GRID)
    env.reset(seed=2)
    plain.reset(seed=2)
    assert sorted(map(env.internal_action, range(4))) == [0, 1, 2, 3]
    assert [env.external_action(env.internal_action(action)) for action in range(4)] == [0, 1, 2, 3]
    for action in range(4):
        assert env.step(action)[0] == plain.step(env.internal_action(action))[0]


# --- environments of one's own


def line_of(llfbench):
    from llfbench.envs.llf_env import Feedback, LLFWrapper

    class Line(gymnasium.Env):
        observation_space = spaces.Discrete(9)
        action_space = spaces.Discrete(2)
        length = 4

        def reset(self, *, seed=None, options=None):
            super().reset(seed=seed)
            self.at = int(self.np_random.integers(2))
            return self.at, {}

        def step(self, action):
            self.at = max(self.at + (1 if action else -1), 0)
            return self.at, float(self.at == self.length), False, False, {}

    class Wrapper(LLFWrapper):
        INSTRUCTION_TYPES = ("b", "c")
        FEEDBACK_TYPES = ("r", "hn", "fp")

        def _reset(self, *, seed=None, options=None):
            at, info = self.env.reset(seed=seed, options=options)
            instruction = self.format(("Go right.", "The right is where to go."))
            if self.instruction_type == "c":
                instruction += " It is 1."
            return {"instruction": instruction, "observation": f"{at}", "feedback": None}, info | {"success": False}

        def _step(self, action):
            at, reward, terminated, truncated, info = self.env.step(action)
            feedback = Feedback(r=self.format(("You got {reward}.", "{reward} is yours."), reward=reward))
            if "hn" in self._feedback_type and not action:
                feedback["hn"] = "That was left."
            if "fp" in self._feedback_type:
                feedback.fp = "Go right."
            info["success"] = reward > 0
            observation = {"instruction": None, "observation": f"{at}", "feedback": feedback}
            return observation, reward, terminated, truncated, info

    return lambda *types: Wrapper(Line(), *types)


def test_a_wrapper_of_ones_own(llfbench):
    line = line_of(llfbench)
    env = line("b", "a")
    env.set_paraphrase_method(0)
    observation, _ = env.reset(seed=0)
    assert observation == {"instruction": "Go right.", "observation": f"{env.env.at}", "feedback": None}
    assert env.step(0)[0]["feedback"] == "You got 0.0. That was left. Go right."
    assert env.step(1)[0]["feedback"] == "You got 0.0. Go right."
    assert env.length == 4  # attributes of what is within are reached
    env.set_feedback_type("hn")
    assert env.feedback_type == {"hn"}
    assert [env.step(action)[0]["feedback"] for action in (0, 1)] == ["That was left.", ""]
    env.set_feedback_type("n")
    assert env.step(0)[0]["feedback"] == ""
    env.set_instruction_type("c")
    env.set_paraphrase_method(3)
    assert env.reset()[0]["instruction"] == "The right is where to go. It is 1."
    env.set_paraphrase_method(lambda templates, **slots: f"{len(templates)} {slots}")
    assert env.reset()[0]["instruction"] == "2 {} It is 1."
    with pytest.raises(ValueError, match="instruction type 'p' is not supported; allowed: b, c"):
        env.set_instruction_type("p")
    with pytest.raises(ValueError, match="feedback type 'fn' is not supported; allowed: a, n, m, and of r, hn, fp"):
        line("b", "fn")
    with pytest.raises(AttributeError, match="nowhere"):
        env.nowhere  # noqa: B018 (it raises)


def test_a_wrapper_of_ones_own_draws_from_its_own_stream(llfbench):
    def words(seed):
        env = line_of(llfbench)("b", "m")
        said = [env.reset(seed=seed)[0]["instruction"]]
        before = random.getstate(), np.random.get_state()[1].tolist()  # noqa: NPY002 (it must not change)
        said += [env.step(action)[0]["feedback"] for action in (0, 1, 0, 1, 0, 1)]
        assert (random.getstate(), np.random.get_state()[1].tolist()) == before  # noqa: NPY002
        return said

    assert words(0) == words(0)
    assert len({tuple(words(seed)) for seed in range(6)}) > 1
    assert len({len(said) for said in words(0)[1:]}) > 1  # what is mixed changes by turns


def test_wrappers_fit_environments_of_ones_own(llfbench):
    env = llfbench.TextWrapper(line_of(llfbench)("b", "a"))
    env.reset(seed=0)
    at = env.unwrapped.at
    assert env.step("1")[0]["observation"] == f"{at + 1}"
    observation, reward, terminated, truncated, info = env.step("import os")
    assert (observation["observation"], reward, terminated, truncated, info["success"]) == (
        None,
        0.0,
        False,
        False,
        False,
    )
    assert observation["feedback"] == "'import os' is no action; the answer must be an integer from 0 to 1."
    assert env.unwrapped.at == at + 1
    shuffled = llfbench.RandomActionOrderWrapper(line_of(llfbench)("b", "a"))
    shuffled.reset(seed=0)
    assert shuffled.step(shuffled.external_action(1))[0]["observation"] == f"{at + 1}"
    assert llfbench.TerminalFreeWrapper(env).reset(seed=0)[0]["feedback"] is None


def test_what_a_wrapper_of_ones_own_must_give(llfbench):
    from llfbench.envs.llf_env import Feedback, LLFWrapper

    class Silent(LLFWrapper):
        def _reset(self, *, seed=None, options=None):
            return {"instruction": None, "observation": "", "feedback": None}, {"success": False}

        def _step(self, action):
            return {"instruction": None, "observation": "", "feedback": None}, 0.0, False, False, {}

    within = line_of(llfbench)("b", "a").env
    with pytest.raises(ValueError, match=r"Silent\._reset must give an instruction and no feedback"):
        Silent(within, "b", "a").reset()
    with pytest.raises(ValueError, match=r"Silent\._step must give `success` in the info, got \{\}"):
        Silent(within, "b", "a").step(0)
    for method in ("reset", "step"):
        with pytest.raises(NotImplementedError, match=f"LLFWrapper must have _{method}"):
            getattr(LLFWrapper(within, "b", "a"), method)(*[0] * (method == "step"))
    feedback = Feedback("1", fn="no")
    del feedback["r"]
    assert feedback.asdict() == {"r": None, "hp": None, "hn": None, "fp": None, "fn": "no"}
    assert "fn" in feedback
    assert "zz" not in feedback
    with pytest.raises(KeyError):
        feedback["zz"] = "?"


# --- its helpers


class Eastward:
    def reset(self, docstring):
        self.heard = [docstring]

    def act(self, observation, feedback):
        self.heard.append(feedback)
        return "east"


def test_agents_are_evaluated(llfbench):
    from llfbench.agents import utils

    env, agent = llfbench.make(GRID), Eastward()
    score, data = utils.rollout(agent, env, horizon=4, log_data=True, seed=2)
    assert agent.heard[0] == data["observations"][0]["instruction"]
    assert agent.heard[1] is None
    assert agent.heard[2] == data["observations"][1]["feedback"]
    assert score == sum(data["rewards"])
    assert [len(values) for values in data.values()] == [5, 4, 4, 4, 4]

    class Expert(Eastward):
        def act(self, observation, feedback):
            return env.expert_action

    scores = utils.evaluate_agent(Expert(), env, horizon=20, n_episodes=3, seed=0, sparse_reward=True)
    assert scores.tolist() == [1.0, 1.0, 1.0]
    scores, data = utils.evaluate_agent(Expert(), env, horizon=20, n_episodes=2, seed=0, log_data=True)
    assert scores.tolist() == [1.0, 1.0]
    assert data[0]["observations"][0] != data[1]["observations"][0]  # seeded once


def test_small_helpers(llfbench, capsys):
    from llfbench.agents import utils
    from llfbench.utils.utils import generate_combinations_dict

    assert generate_combinations_dict({"a": [1, 2], "b": "x"}) == [{"a": 1, "b": "x"}, {"a": 2, "b": "x"}]
    assert utils.extract_action("I go #1#.", 4) == 1
    assert utils.extract_action("I go #arm 3 now#", 4) == 3
    assert utils.extract_action("I say #hello#", None) == "hello"
    assert utils.extract_action("no idea", 4) == "no idea"
    assert utils.extract_action("#9#", 4) == "#9#"
    utils.print_color("red", "red")
    assert capsys.readouterr().out == "\033[91mred\033[0m\n"
    buffer = utils.ReplayBuffer(2)
    buffer.update(x=0)
    for x in range(3):
        buffer.append(x=x)
    buffer.update(y=1)
    assert list(buffer) == [{"x": 1}, {"x": 2, "y": 1}]
    buffer.reset()
    assert len(buffer) == 0
    state = random.getstate(), np.random.get_state()  # noqa: NPY002 (what is tested)
    utils.set_seed(1)
    drawn = random.random(), np.random.random()  # noqa: NPY002
    utils.set_seed(1)
    assert (random.random(), np.random.random()) == drawn  # noqa: NPY002
    random.setstate(state[0])
    np.random.set_state(state[1])  # noqa: NPY002


# --- Meta-World


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
            lab = env.unwrapped.aec.world.scratch()
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
    environment = os.environ | {"MUJOCO_GL": "egl"}
    program = [sys.executable, "-c", IMAGES]
    result = subprocess.run(program, capture_output=True, text=True, env=environment, check=False)
    if "images need off-screen OpenGL" in result.stderr:
        pytest.skip("no off-screen OpenGL here: install libegl1")
    assert result.stdout == "seen\n", result.stderr


# --- Trace's tutorial on Meta-World, its calls in their order, and its guides


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
