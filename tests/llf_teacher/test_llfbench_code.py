"""Code as people have written it for LLF-Bench runs without an edit, once `install()` was called."""

import random

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
        assert env.action_space.n == env.unwrapped.session.world.action_space.n


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
    goal = env.unwrapped.session.world.truth.game.goal
    assert observation["instruction"].split("Your task is to: ")[1].startswith(f"{goal}.")
    for action in ("look", "\x00", info["admissible_commands"][0]):
        before, after = observation["observation"].split(allowed)
        assert before
        assert after.strip(" .").split(", ") == env.unwrapped.session.world.commands()
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
    with pytest.raises(ValueError, match="n_workers must be 1, got 2; a study plays in several"):
        utils.evaluate_agent(Expert(), env, horizon=20, n_episodes=2, n_workers=2)


def test_agents_have_its_bases(llfbench):
    class Mine(llfbench.agents.abstract_agent.BasicAgent):
        def act(self, observation, feedback):
            self.buffer.append(feedback=feedback)
            return "east"

    agent = Mine(buffer_size=3)
    scores = llfbench.agents.utils.evaluate_agent(agent, llfbench.make(GRID), horizon=4, n_episodes=2, n_workers=1)
    assert len(scores) == 2
    assert len(agent.buffer) == 3
    assert agent.docstring
    agent.reset("Go on.")
    assert (agent.docstring, len(agent.buffer)) == ("Go on.", 0)
    with pytest.raises(NotImplementedError, match=r"AbstractAgent must have act\(observation, feedback\)"):
        llfbench.agents.abstract_agent.Agent().act()


# --- its loop over the registry


def test_each_id_that_its_loop_finds_can_be_made(llfbench):
    found = [id for id in gymnasium.envs.registry if id.startswith("llf-")]
    assert set(llf_teacher.ids()) <= set(found)
    made = {llfbench.make(id, warning=False).unwrapped.env_id for id in found}
    assert made == set(llf_teacher.ids())
    assert not [id for id in gymnasium.envs.registry if "llf" in id and not id.startswith("llf-")]


def test_ids_without_a_version_are_those_of_gymnasium(llfbench):
    for id in ("llf-gridworld", "verbal-metaworld-reach"):
        with pytest.warns(UserWarning, match="latest versioned"):
            expected = gymnasium.make(id).unwrapped.env_id
        with pytest.warns(UserWarning, match=f"stands for {expected}, its newest version"):
            assert llf_teacher.make(id).unwrapped.env_id == expected
        assert llfbench.make(id, warning=False).unwrapped.env_id == expected


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
