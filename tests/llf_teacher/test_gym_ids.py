"""Ids of Gymnasium's registry: the same doors as for families, with a teacher who plans."""

import copy
import json
import pickle
import re
import sys
from functools import partial
from itertools import pairwise

import gymnasium
import numpy as np
import pytest
from commands import llf

import llf_teacher
from llf_teacher.episodes.loop import play_turns
from llf_teacher.registry import entry
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.tools.audit import audit
from llf_teacher.tools.film import film
from llf_teacher.web.plan import read_plan
from pz_envs.settings import Settings
from pz_envs.testing import check_seats
from teachers.atoms import Label
from teachers.planning import PlanningError

pytestmark = pytest.mark.usefixtures("short_trials")

LAKE, DOOR, CART = "gym:FrozenLake-v1", "gym:MiniGrid-DoorKey-5x5-v0", "gym:CartPole-v1"


MODULE = '''
import gymnasium
import gymnasium.envs.toy_text

class Corridor(gymnasium.Env):
    """Five cells with a treasure."""

    observation_space, action_space = gymnasium.spaces.Discrete(5), gymnasium.spaces.Discrete(2)

    def __init__(self, length=5):
        self.length = length

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.cell = 0
        return 0, {}

    def step(self, action):
        self.cell = min(max(self.cell + (-1, 1)[action], 0), self.length - 1)
        over = self.cell == self.length - 1
        return self.cell, float(over), over, False, {}

class Wrong(Corridor):
    def step(self, action):
        return super().step(action)[:4]

class Endless(Corridor):
    def step(self, action):
        self.steps = getattr(self, "steps", 0) + 1
        return super().step(action)

class Opaque(Corridor):
    def reset(self, *, seed=None, options=None):
        self.part = object()
        return super().reset(seed=seed)

class Spaceless(gymnasium.Env):
    reset, step = Corridor.reset, Corridor.step

class Failing(Corridor):
    def __init__(self):
        raise OSError("no disk")

class Windy(gymnasium.envs.toy_text.BlackjackEnv):
    def step(self, action):
        return super().step(action)

if "Own/Corridor-v0" not in gymnasium.registry:  # the module may be imported anew in one process
    gymnasium.register("Own/Corridor-v0", Corridor, max_episode_steps=9)
number = 3
'''


@pytest.fixture(scope="module")
def own_module(tmp_path_factory):
    folder = tmp_path_factory.mktemp("own")
    (folder / "own_corridor.py").write_text(MODULE)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(folder))
        yield folder
    gymnasium.registry.pop("Own/Corridor-v0", None)
    sys.modules.pop("own_corridor", None)


def test_options_are_those_of_gymnasium_and_of_the_planner():
    env = llf_teacher.make(LAKE, map_name="8x8", is_slippery=False, oracle="exact(gamma=0.9)", text=True)
    instruction = env.reset(seed=0)[0]["instruction"]
    assert "0.9" in instruction
    assert env.session.world.observation_space.n == 64
    assert env.teacher.oracle.tier == "exact"
    assert llf_teacher.make(LAKE, oracle="rewards").teacher.oracle.feedback_types == ("r",)
    assert llf_teacher.supported_types(LAKE)[0] == ("b", "p")
    assert llf_teacher.supported_types(LAKE, is_slippery=False)[0] == ("b", "p", "c")


def test_the_objective_is_stated():
    _, info = llf_teacher.make(LAKE, max_turns=12).reset(seed=0)
    assert info["objective"].startswith("the sum of rewards within 12 actions")
    assert llf_teacher.make(LAKE, max_turns=1000).session.max_turns == 100  # the environment's own limit


@pytest.mark.parametrize("id", [LAKE, DOOR])
def test_one_seed_is_one_world(id):
    envs = [llf_teacher.make(id, teacher="silent"), llf_teacher.make(id), gymnasium.make(id.removeprefix("gym:"))]
    traces = [[env.reset(seed=5)[0], *(env.step(action)[0] for action in (1, 2, 1))] for env in envs]
    bare = list(map(str, traces.pop()))
    for trace in traces:
        assert [str(seen["observation"]) for seen in trace] == bare


def test_copies_go_on_alike():
    env = llf_teacher.make(LAKE)
    env.reset(seed=3)
    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        results = []
        for each in (env, other):
            going = copy.deepcopy(each)
            results.append([str(going.step(action)[0]) for action in (1, 2)])
        assert results[0] == results[1]
    subject = entry(LAKE).family
    assert pickle.loads(pickle.dumps(subject)) is subject
    assert pickle.loads(pickle.dumps(env.family)) is copy.deepcopy(env.family) is env.family


def test_the_teacher_of_a_world_knows_its_options():
    subject = entry(LAKE).family
    for slippery, types in ((True, ("b", "p")), (False, ("b", "p", "c"))):
        world = subject.make_world(is_slippery=slippery)
        assert subject.make_teacher(world).oracle.instruction_types == types


@pytest.mark.parametrize(
    ("id", "options", "match"),
    [
        (LAKE, {"map_nam": "4x4"}, "unknown option 'map_nam'; did you mean map_name"),
        (LAKE, {"is_slippery": "no"}, "is_slippery of gym:FrozenLake-v1 must be true or false, got 'no'"),
        (
            LAKE,
            {"options": {"render_mode": "human"}},
            "render_mode is no option of gym:Froz.* but a setting of",
        ),
        (LAKE, {"map_name": "9x9"}, "cannot be made with map_name='9x9': KeyError: '9x9'; options that it has: oracle"),
        (LAKE, {"oracle": "exakt"}, "oracle must be .* the name of one .*, got 'exakt'"),
        (LAKE, {"oracle": "exact(gama=1)"}, "unknown parameter 'gama'; did you mean gamma"),
        (LAKE, {"oracle": "exact(states=0)"}, "states must be an integer of at least 1, got 0"),
        (LAKE, {"oracle": "exact(steps=-1)"}, "steps must be an integer of at least 1, got -1"),
        (LAKE, {"oracle": 3}, "oracle must be a planner or its spec string, such as .*, got 3"),
        ("gym:FrozenLake-v0", {}, "has no 'FrozenLake-v0'; allowed: .*gym:FrozenLake for the newest"),
        ("gym:FrozenLaek-v1", {}, r"did you mean gym:FrozenLake-v1.*'gym:package.module:FrozenLaek-v1'"),
        ("gym:no_such_module:X-v0", {}, "the module 'no_such_module' cannot be imported"),
        ("gym:math:pi", {}, "the module 'math' neither registers nor defines 'pi'"),
        ("gym:llf-gridworld-v0", {}, "has a teacher already; leave the prefix 'gym:' out: 'llf-gridworld-v0'"),
        ("gym:CartPole-v1", {"oracle": "exact"}, "its state has real numbers in state, which hardly recur"),
    ],
)
def test_bad_ids_and_options_are_named(id, options, match):
    with pytest.raises(ValueError, match=match):
        llf_teacher.make(id, **options)


def test_no_version_is_the_newest():
    with pytest.warns(UserWarning, match="gym:CliffWalking stands for gym:CliffWalking-v"):
        assert entry("gym:CliffWalking").id.startswith("gym:CliffWalking-v")


@pytest.mark.usefixtures("own_module")
def test_modules_register_or_define_environments():
    for id in ("gym:own_corridor:Own/Corridor-v0", "gym:own_corridor:Corridor"):
        assert entry(id).id == id
        env = llf_teacher.make(id, length=4)
        assert env.family.planned.tier == "exact"
        assert "length" in env.family.options()
    assert entry("gym:own_corridor:Own/Corridor-v0").family.turns() == 9
    with pytest.raises(ValueError, match="neither registers nor defines 'number'"):
        entry("gym:own_corridor:number")
    with pytest.raises(
        PlanningError, match=r"'part' has a value of class object, which cannot be compared; pass .*state=f"
    ):
        llf_teacher.make("gym:own_corridor:Opaque", oracle="exact")
    with pytest.raises(PlanningError, match=r"more than \d+ states can be reached, .* the bounds are states=50"):
        llf_teacher.make("gym:own_corridor:Endless", oracle="exact(states=50)")


def test_seats():
    subject = entry(LAKE).family
    check_seats(partial(subject.env, max_cycles=8))
    env = subject.raw_env(seating="classroom", students=2, map_name="8x8", is_slippery=False, instruction_type="c")
    env.reset(seed=0)
    assert env.observation_space("student_0")["state"].n == 64
    with pytest.raises(ValueError, match="unknown option 'map_nam'"):
        subject.env(map_nam="8x8")


def test_numbers_budgets_and_kinds():
    env = llf_teacher.make(LAKE, numbers=True)
    assert env.observation_space.contains(env.reset(seed=0)[0])
    door = llf_teacher.make(DOOR, numbers=True, embed=lambda text: [len(text)])
    assert door.observation_space.contains(door.reset(seed=0)[0])
    env = llf_teacher.make(LAKE, budget=1, feedback_type="fp+fn")
    student = parse_student("random").seat(env.family, env.session.world)
    assert sum(len(turn.feedback.atoms) for turn in play_turns(env, student, 0)) == 1
    with pytest.raises(ValueError, match="cannot be played in arrays"):
        entry(LAKE).family.make_batch(2)


@pytest.mark.parametrize("teacher", ["oracle", "worked_example", "delayed(turns=2) | mix"])
def test_personalities_and_audits(teacher):
    found = audit(LAKE, teacher, turns=60, students=("random", "obedient"), is_slippery=False)
    assert found.count(Label.DISTORTED) == found.leaks == 0 < found.checked
    assert not found.caught


def test_a_personality_that_needs_more_is_refused():
    with pytest.raises(ValueError, match="worked_example"):
        llf_teacher.make("gym:CartPole-v1", oracle="rewards", teacher="worked_example")
    assert (
        not entry("gym:CartPole-v1").family.for_lesson(Settings(options={"oracle": "rewards"})).serves("worked_example")
    )


def study(**changes):
    given = {"ids": [LAKE, DOOR], "teachers": ["oracle", "silent"], "students": ["obedient", "random"], "seeds": 2}
    given |= {"max_turns": 30, "options": {"gym:Frozen*": {"map_name": "8x8", "oracle": "exact(gamma=0.9)"}}}
    return Study(**given | changes)


def test_studies_have_them_with_options():
    found = list(study().episodes())
    assert len(found) == 16
    lake = next(spec for spec in found if spec.id == LAKE and spec.student == "obedient")
    assert json.loads(lake.options) == {"map_name": "8x8", "oracle": "exact(gamma=0.9)"}
    assert f"+gymnasium-{gymnasium.__version__}" in lake.version
    record = play(lake)
    assert record == play(lake)
    assert record.episode.family == "gym-FrozenLake-v1"
    claims = [atom["claim"] for turn in record.turns for atom in turn.atoms]
    assert {name.rpartition(".")[0] for name in claims} == {"gym-FrozenLake-v1", "common"}
    assert {spec.max_turns for spec in study(max_turns=None).episodes()} == {100, 250}


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"ids": [CART], "options": {CART: {"oracle": "exact"}}}, f'options."{CART}": .*real numbers'),
        ({"options": {"gym:Frozen*": {"map_name": "9x9"}}}, "cannot be made with map_name='9x9'"),
        ({"options": {"gym:Frozen*": {"maps": 1}}}, "unknown option 'maps'"),
        ({"instruction_types": ["c"]}, f"{LAKE} cannot have 'c'"),
    ],
)
def test_studies_say_what_is_wrong(changes, match):
    with pytest.raises(ValueError, match=match):
        study(**changes)


def test_films_show_the_environment_itself():
    frames = film(LAKE, student="obedient", seed=1, max_turns=3, privileged_info=True)
    assert all(frame[240:, :190].std() > 10 for frame in frames)
    assert any((one != other).any() for one, other in pairwise(frames))
    env = llf_teacher.make(LAKE, render_mode="rgb_array", privileged_info=True)
    for seed in (0, 1):  # a rendered environment could not be copied at a reset
        env.reset(seed=seed)
        env.render()


def test_the_page_offers_only_what_it_was_given():
    given = {"id": LAKE, "seat": "student"}
    assert read_plan(given, (LAKE,)).settings.max_turns == 100
    for id in (LAKE, "gym:os:system"):
        with pytest.raises(ValueError, match="unknown environment of this page"):
            read_plan(given | {"id": id})


def test_success_is_what_the_environment_means_by_it():
    """CliffWalking's goal pays nothing, and ends the episode: that is success there."""
    env = llf_teacher.make(entry("gym:CliffWalking-v1").id)
    policy = parse_student("obedient").seat(env.family, env.session.world)
    turns = list(play_turns(env, policy, 0))
    assert turns[-1].moment.success
    assert len(turns) == 14


def test_list_says_what_each_tier_says():
    shown = llf("list", LAKE).stdout
    for text in (
        "exact",
        "16 states",
        "left, down, right, up",
        "map_name",
        "with practice (p)",
        "what the student sees",
    ):
        assert text in shown
    assert "reward (r), praise (hp), blame (hn), advice (fp), warning (fn)" in shown
    shown = llf("list", "gym:CartPole-v1").stdout
    first = shown.splitlines()[0]
    assert first.endswith(
        'Anderson in "Neuronlike Adaptive Elements That Can Solve Difficult Learning Control Problem".'
    )
    assert "real numbers" in shown
    assert "pass oracle=Expert(policy=f)" in shown
    assert "with oracle='rewards' what was paid is said in words" in shown


def test_play_takes_options():
    assert "square 4" in llf("play", LAKE, "--option", "is_slippery=false", text="down\nquit\n").stdout
    assert "square 4" in llf("play", LAKE, "--option", "is_slippery=False", text="down\nquit\n").stdout
    assert "an option must be NAME=VALUE" in llf("play", LAKE, "--option", "slippery").stderr
    twice = llf("play", LAKE, "--option", "is_slippery=false", "--option", "is_slippery=true")
    assert "each option must be given once, got is_slippery twice" in twice.stderr


def test_audits_take_options():
    command = "audit", LAKE, "--turns", "20", "--option"
    assert "0 false" in llf(*command, "is_slippery=False").stdout
    assert f"{LAKE} has no option maps; allowed: oracle, max_episode_steps, map_name" in llf(*command, "maps=1").stderr


@pytest.mark.parametrize(
    ("name", "status", "said"),
    [
        (
            "Corridor",
            0,
            ("copies        continue", "3 states", "solved after 2 turns", "describe=", "max_turns="),
        ),
        ("Wrong", 1, ("check_env shows it",)),
        (
            "Opaque",
            0,
            (
                "'part' has a value of class object",
                "rewards       with oracle='rewards'",
                "missing       a teacher that plans",
            ),
        ),
        ("Windy", 0, ("rules         Windy overrides step, so that rules known of BlackjackEnv may not hold",)),
        ("Spaceless", 1, ("Spaceless, which lacks action_space, observation_space",)),
        ("Failing", 2, ("OSError: no disk",)),
        ("Nothing", 2, ("neither registers nor defines 'Nothing'",)),
    ],
)
def test_teach_tries_an_environment(own_module, name, status, said):
    options = ("--option", "length=3") if name == "Corridor" else ()
    found = llf("teach", f"own_corridor:{name}", *options, cwd=own_module)
    assert found.returncode == status
    for text in said:
        assert text in found.stdout + found.stderr


@pytest.mark.parametrize(
    ("planner", "said", "unsaid"),
    [
        ("exact(states=10)", "more than 10 states", "expert  "),
        ("rewards", "says what was paid", "exact  "),
    ],
)
def test_teach_asks_the_planner_that_is_given(own_module, planner, said, unsaid):
    shown = llf(
        "teach", "own_corridor:Corridor", "--option", "length=12", "--option", f"oracle={planner}", cwd=own_module
    )
    assert said in shown.stdout
    assert unsaid not in shown.stdout


def test_teach_needs_a_prefix():
    assert "must be an id of Gymnasium with its prefix, gym:CartPole-v1" in llf("teach", "CartPole-v1").stderr
    assert "did you mean gym:CartPole-v1?" in llf("play", "CartPole-v1").stderr
    assert "did you mean gym:ferry:Fery?" in llf("audit", "ferry:Fery").stderr


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("FrozenLaek-v1", "FrozenLake-v1"),
        ("frozen_lake", "FrozenLake-v1"),
        ("Pendulum3-v0", "Pendulum-v1"),
        ("Bipedal", "BipedalWalker-v3"),
        ("LavaGap", "MiniGrid-LavaGapS5-v0 or gym:MiniGrid-LavaGapS6-v0 or gym:MiniGrid-LavaGapS7-v0"),
        ("Xyzzy-v1", ""),
        ("Fery", ""),
    ],
)
def test_only_ids_like_it_are_suggested(name, near):
    with pytest.raises(ValueError, match="unknown environment") as refused:
        entry(f"gym:{name}")
    _, _, said = f"{refused.value}".partition("did you mean gym:")
    assert said.startswith(near) if near else not said


def test_teach_says_only_what_makes_sense():
    """Numbers that are no choices have no words; and no text has an address in memory."""
    shown = llf("teach", "gym:Pendulum-v1").stdout
    assert "describe=" in shown
    assert "action_words" not in shown
    assert re.search(r"^turn 1 +\[-?\d\.\d+\]\. ", shown, re.MULTILINE)
    shown = llf("teach", "gym:MiniGrid-LavaGapS5-v0").stdout
    assert "'mission': MissionSpace, such as 'avoid the lava and get to the green goal square')" in shown
    assert "0x" not in shown


def test_random_play_teaches_what_values_say():
    """The advice of an id is that of `teach` with the same environment."""
    ours = llf_teacher.make(LAKE, teacher="oracle")
    theirs = llf_teacher.teach(gymnasium.make("FrozenLake-v1"), oracle="auto")
    rng = np.random.default_rng(4)
    for env in (ours, theirs):
        env.reset(seed=4)
    for _ in range(5):
        action = int(rng.integers(4))
        one, other = (env.step(action) for env in (ours, theirs))
        assert one[0]["feedback"] == other[0]["feedback"]
        if one[2] or one[3]:
            break


def test_where_nobody_knows_values_a_study_has_the_negated_reward_as_regret():
    """Teachers differ by as much as they would in regret."""
    (spec, *_) = study(ids=[CART], max_turns=3, seeds=1, options={CART: {"oracle": "rewards"}}).episodes()
    record = play(spec)
    assert record.episode.regret == -record.episode.total_reward == -3
    assert [turn.regret for turn in record.turns] == [0, -1, -1, -1]
