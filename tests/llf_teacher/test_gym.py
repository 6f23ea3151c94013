"""The Gymnasium side: make, registration, StudentEnv, TeacherEnv, vector environments, text mode."""

import copy
import json
import pickle
import subprocess
import sys

import gymnasium
import numpy as np
import pettingzoo
import pytest
from design import sampled
from gymnasium.error import ResetNeeded
from houses import STOCK
from playing import steps
from sampling import IDS
from shelf import is_complete

import llf_teacher
from llf_teacher.episodes.recorder import Recorder
from llf_teacher.registry import PREFIX, entry
from pz_envs.family import all_families
from teachers.atoms import Atom, ParseFailure, Utterance
from teachers.personalities.delayed import Delayed
from teachers.words import VERDICTS
from worlds.testing import plain, some_actions

SHOWCASE = [PREFIX + family.showcase[0] for family in all_families()]
GRID = "llf-gridworld-v0"
BANDIT = "llf-bandits-BanditTenArmedRandomFixed-v0"
HAIKU = "llf-poem-Haiku-v0"


@pytest.mark.parametrize("id", IDS)
def test_all_ways_to_make_lead_to_the_same_environment(id):
    def opening(env):
        return plain(env.reset(seed=11)[0])

    alias = id.replace("llf-", "verbal-")
    made = [
        llf_teacher.make(id),
        llf_teacher.make(alias),
        gymnasium.make(id),
        gymnasium.make(alias),
        gymnasium.make(f"llf_teacher:{id}"),
        gymnasium.make(gymnasium.spec(id)),
    ]
    assert all(isinstance(env, llf_teacher.StudentEnv) for env in made)
    assert len({opening(env) for env in made}) == 1
    assert made[0].spec.id == id
    assert pettingzoo.make("aec", id.replace("llf-", "llf/")).unwrapped.max_turns == made[0].session.max_turns


def test_specs_are_json():
    env = llf_teacher.make(GRID, teacher="mistake(eps=0.5)", num_rooms=6, min_goal_dist=2, text=True)
    again = gymnasium.make(gymnasium.envs.registration.EnvSpec.from_json(env.spec.to_json()))
    assert plain(again.reset(seed=2)[0]) == plain(env.reset(seed=2)[0])
    assert again.unwrapped.session.world.options["num_rooms"] == 6


@pytest.mark.parametrize("alias", ["llf-metaworld-reach-v2", "verbal-metaworld-reach-v2"])
def test_an_older_name_warns(alias):
    with pytest.warns(UserWarning, match="stands for llf-metaworld-reach-v3: .* rewards differ from v2's"):
        env = llf_teacher.make(alias)
    assert env.spec.id == "llf-metaworld-reach-v3"
    with (
        pytest.warns(UserWarning, match="stands for llf-metaworld-reach-v3"),
        pytest.warns(DeprecationWarning, match="out of date"),  # Gymnasium's own
    ):
        assert gymnasium.make(alias).unwrapped.env_id == "llf-metaworld-reach-v3"
    assert alias not in llf_teacher.ids()


def test_an_older_name_warns_once_a_process_wherever_it_is_used():
    """Warnings are filtered again and again on the way, which makes Python forget what it has shown."""
    lines = [
        "import llf_teacher, llf_teacher.compat, warnings",
        "from llf_teacher.studies.definition.study import Study",
        "name = 'llf-metaworld-reach-v2'",
        "llf_teacher.compat.make(name, warning=False)",
        "for each in (name, name, 'verbal' + name[3:]):",
        "    with warnings.catch_warnings(): llf_teacher.make(each)",
        "llf_teacher.supported_types(name)",
        "Study(ids=(name, name), teachers=('oracle',), students=('random',), seeds=1)",
        "llf_teacher.make('llf-metaworld-push-v2')",
    ]
    result = subprocess.run([sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True, check=False)
    assert result.stderr.count("llf-metaworld-reach-v2 stands for llf-metaworld-reach-v3") == 1, result.stderr
    assert result.stderr.count("llf-metaworld-push-v2 stands for llf-metaworld-push-v3") == 1
    assert result.stderr.count("rewards differ") == 2


def test_images_are_asked_for_where_there_are_any():
    env = llf_teacher.make("llf-metaworld-reach-v3", visual=True)
    assert env.observation_space["observation"]["image"].shape == (240, 240, 3)


def test_supported_types():
    for id in llf_teacher.ids():
        instructions, kinds = llf_teacher.supported_types(id)
        if is_complete(entry(id).family):
            assert (instructions, kinds) == (("b", "p", "c"), ("r", "hp", "hn", "fp", "fn"))
        for type_ in {"b", "p", "c"} - set(instructions):
            with pytest.raises(ValueError, match=f"'{type_}' is not supported; allowed: {', '.join(instructions)}"):
                llf_teacher.make(id, instruction_type=type_)
        for kind in {"r", "hp", "hn", "fp", "fn"} - set(kinds):
            with pytest.raises(
                ValueError, match=f"'{kind}' is not supported; allowed: a, n, m, and of {', '.join(kinds)}"
            ):
                llf_teacher.make(id, feedback_type=kind)


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        ({"id": "llf-bandits-BanditTenArmed-v0"}, "did you mean llf-bandits-BanditTenArmed"),
        ({"id": 3}, "an id must be a string such as 'llf-alfworld-v0', got 3"),
        ({"id": ["llf-gridworld-v0"]}, r"an id must be a string such as .*, got \['llf-gridworld-v0'\]"),
        ({"instruction_type": "x"}, "instruction type 'x' is not supported; allowed: b, p, c"),
        ({"feedback_type": "hq"}, "names 'hq'; allowed: 'a'"),
        ({"teacher": "mistak"}, "unknown personality 'mistak'; did you mean mistake"),
        ({"teacher": 5}, "teacher must be a spec string"),
        ({"teacher": Delayed}, r"teacher must be a spec string, .*Delayed'>; call it, as in Delayed\(\)"),
        ({"voice": "loud"}, "unknown voice 'loud'; allowed: plain"),
        ({"paraphrase": 1.5}, "paraphrase must be"),
        ({"visual": True}, "visual=True is not supported"),
        ({"max_turns": 0}, "must be an integer of at least 1, got 0"),
        ({"num_rooms": 1}, "num_rooms must be an integer from 2"),
        ({"num_romos": 3}, "llf-gridworld-v0 does not take .*unknown option 'num_romos'; did you mean num_rooms"),
        ({"feedback_tpye": "a"}, "unknown option 'feedback_tpye'; did you mean feedback_type"),
        ({"student": "obedient"}, r"unknown option 'student'; .*; a student is for TeacherEnv\(stu"),
        ({"text": "yes"}, "text must be True or False, got 'yes'"),
        ({"privileged_info": 1}, "privileged_info must be True or False, got 1"),
        ({"visual": "no"}, "visual must be True or False, got 'no'"),
        ({"until_success": None}, "until_success must be True or False, got None"),
    ],
)
def test_bad_arguments_are_value_errors_that_say_what_is_allowed(arguments, match):
    with pytest.raises(ValueError, match=match):
        llf_teacher.make(**({"id": GRID} | arguments))


@pytest.mark.parametrize("id", SHOWCASE)
def test_strange_options_and_actions_are_refused_and_change_nothing(id):
    env, twin = llf_teacher.make(id), llf_teacher.make(id)
    env.reset(seed=0)
    twin.reset(seed=0)
    for strange in ({"no such option": 1}, "text"):
        with pytest.raises(ValueError, match="option"):
            env.reset(seed=5, options=strange)
    with pytest.raises(ValueError, match="the state is unchanged"):
        env.step(True)
    for action in some_actions(twin.session.world, 3):
        outcome = twin.step(action)
        assert plain(env.step(action)[:4]) == plain(outcome[:4])
        if outcome[2] or outcome[3]:
            break
    assert plain(env.reset()[0]) == plain(twin.reset()[0])


def test_an_action_in_words_that_is_refused_names_the_mode_that_takes_words():
    env = gymnasium.make("llf_teacher:llf-gridworld-v0")
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"0 north.*; the state is unchanged; for actions in words .* text=True"):
        env.step("north")
    with pytest.raises(ValueError, match=r"the state is unchanged$"):
        env.step(9)


@pytest.mark.parametrize(
    ("id", "options", "match"),
    [
        ("llf-poem-Haiku-v0", {"syllable": 7}, "does not apply to form"),
        ("llf-poem-SyllableConstrainedPoem-v0", {"syllable": "7"}, "must be an integer from 1 to 40, got '7'"),
        pytest.param("llf-alfworld-v0", {"game": "no/game.tw-pddl"}, "no/game.tw-pddl is not a game .*", marks=STOCK),
        ("llf-alfworld-v0", {"game": 3}, "option 'game' must be the path of a game file, got 3"),
    ],
)
def test_an_option_of_another_type_is_refused_and_changes_nothing(id, options, match):
    env = llf_teacher.make(id)
    env.reset(seed=0)
    before = env.session.world.save()
    with pytest.raises(ValueError, match=match):
        env.reset(seed=1, options=options)
    assert env.session.world.save() == before


def test_a_class_refuses_options_before_anything_is_drawn():
    """Of those that the world does not know, PettingZoo's doors take what its checkers pass, and no others."""
    env = pettingzoo.make("aec", "llf/poem-SyllableConstrainedPoem-classroom-v0")
    env.reset(seed=0)
    before = env.unwrapped.seeds.episode
    with pytest.raises(ValueError, match="syllable"):
        env.reset(options={"syllable": "many"})
    assert env.unwrapped.seeds.episode == before
    with pytest.raises(ValueError, match="reset option 'x' is unknown; allowed: syllable"):
        env.reset(options={"x": 1})
    assert env.unwrapped.seeds.episode == before
    env.reset(options={"options": 1})
    with pytest.raises(ValueError, match="reset option 'x' is unknown; allowed: none"):
        llf_teacher.make("llf-gridworld-v0").reset(options={"x": 1})


@pytest.mark.parametrize("id", SHOWCASE)
def test_observations(id):
    env = llf_teacher.make(id)
    observation, info = env.reset(seed=0)
    assert list(observation) == ["observation", "instruction", "feedback"]
    assert observation["instruction"]
    assert info["success"] is False
    assert all(type(atom) is Atom for atom in info["atoms"])
    assert "moment" not in info
    observation, reward, terminated, truncated, info = env.step(some_actions(env.session.world)[0])
    assert observation["instruction"] == ""
    assert type(observation["feedback"]) is Utterance
    assert observation["feedback"].atoms == info["atoms"]
    assert (type(reward), terminated, truncated) == (float, False, False)
    assert observation in env.observation_space


def test_privileged_info():
    env = llf_teacher.make(GRID, privileged_info=True)
    assert env.reset(seed=0)[1]["moment"].after == env.session.world.truth
    assert env.step(0)[4]["moment"].turn == 1


@pytest.mark.parametrize(
    ("id", "teacher", "values"),
    [
        *((id, "mistake(eps=0.5) | delayed(turns=1)", {True, False}) for id in SHOWCASE),
        (GRID, "misaligned", {True, False}),
        ("llf-bandits-BanditTenArmedRandomFixed-v0", "partial", {True, None}),  # it hedges
    ],
)
def test_the_info_says_of_each_claim_whether_it_is_true(id, teacher, values):
    """As the labels of studies do; without `privileged_info` nothing says it."""
    env, plain = llf_teacher.make(id, teacher=teacher, privileged_info=True), llf_teacher.make(id, teacher=teacher)
    recorder, said = Recorder(env.family.name, env.student_view), []
    for seed in (0, 1):
        _, info = env.reset(seed=seed)
        assert "true" not in plain.reset(seed=seed)[1]
        for action in (None, *some_actions(env.session.world, 4)):
            if action is not None:
                *_, info = env.step(action)
            labels = [label for _, label in recorder.check(env.session.turn)]
            assert info["true"] == tuple(VERDICTS[label].holds for label in labels)
            assert len(info["true"]) == len(info["atoms"])
            said += info["true"]
            if env.session.done:
                break
    assert set(said) == values


def test_truth_is_unknown_of_turns_that_were_played_elsewhere():
    first = llf_teacher.make(GRID, teacher="delayed(turns=1)", privileged_info=True)
    moments = [first.reset(seed=0)[1]["moment"], first.step(0)[4]["moment"]]
    said = {}
    for past in (moments[:1], ()):
        env = llf_teacher.make(GRID, teacher="delayed(turns=2)", privileged_info=True)
        env.reset(seed=0)
        env.resume_from(moments[1], past=past)
        *_, info = env.step(0)
        said[len(past)] = {true for atom, true in zip(info["atoms"], info["true"], strict=True) if not atom.about_turn}
    assert said == {1: {True}, 0: {None}}


@pytest.mark.parametrize("id", SHOWCASE)
def test_an_unseeded_reset_goes_on_reproducibly(id):
    def episodes():
        env = llf_teacher.make(id, teacher="mix")
        first = env.reset(seed=3)
        return [plain(first[0])] + [plain(env.reset()[0]) for _ in range(3)]

    assert episodes() == episodes()
    assert len(set(episodes())) > 1


@sampled(lambda id, copier, teacher: {(id, copier), (id, teacher)})
@pytest.mark.parametrize("id", SHOWCASE)
@pytest.mark.parametrize("copier", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
@pytest.mark.parametrize("teacher", ["oracle", "mix", "mistake | delayed(turns=1)", "placebo", "misaligned"])
def test_copies_go_on_alike(id, copier, teacher):
    env = llf_teacher.make(id, teacher=teacher, max_turns=12)
    env.reset(seed=0)
    actions = some_actions(env.session.world, 10)
    list(steps(env, actions[:1]))
    copied = copier(env)
    assert [plain(turn) for turn in steps(env, actions)] == [plain(turn) for turn in steps(copied, actions)]
    assert plain(env.reset()[0]) == plain(copied.reset()[0])


def test_steps_out_of_turn():
    env = llf_teacher.make(BANDIT, max_turns=1)
    with pytest.raises(ResetNeeded, match="call reset"):
        env.step(0)
    env.reset(seed=0)
    assert env.step(0)[3] is True
    with pytest.raises(ResetNeeded, match="call reset"):
        env.step(0)
    aec = pettingzoo.make("aec", "llf/gridworld-v0")
    with pytest.raises(AssertionError, match="needs to be called before step"):
        aec.step(0)


def test_the_family_without_its_dependency_names_the_pip_line(monkeypatch):
    family = entry(GRID).family
    monkeypatch.setattr(
        "importlib.import_module", lambda name: (_ for _ in ()).throw(ModuleNotFoundError(name="mujoco"))
    )
    with pytest.raises(ModuleNotFoundError, match=r"needs 'mujoco'.*pip install 'llf-teacher'"):
        family.make_world()


@pytest.mark.parametrize("id", SHOWCASE)
def test_text_mode_is_three_strings(id):
    env = llf_teacher.make(id, text=True)
    observation, _ = env.reset(seed=0)
    assert all(isinstance(value, str) for value in observation.values())
    assert observation in env.observation_space
    assert observation["instruction"] in llf_teacher.prompt(observation)


@pytest.mark.parametrize("text", ["\x00", "a\x1bb", "x" * 1_000_000])
@pytest.mark.parametrize("mode", [False, True])
def test_a_world_of_texts_answers_to_what_it_cannot_take(text, mode):
    env = llf_teacher.make(HAIKU, text=mode)
    env.reset(seed=0)
    _, reward, _, _, info = env.step(text)
    assert reward == -1.0
    assert type(info["parse_failure"]) is ParseFailure


def test_a_number_is_no_text():
    env = llf_teacher.make(GRID, text=True)
    env.reset(seed=0)
    with pytest.raises(ValueError, match="must be a string, got 3"):
        env.step(3)


@sampled(lambda id, text, mode: {(id, text), (id, mode)})
@pytest.mark.parametrize("id", SHOWCASE)
@pytest.mark.parametrize("text", [False, True])
@pytest.mark.parametrize("mode", ["sync", "async"])
def test_vector_environments_give_the_right_text(id, text, mode):
    envs = gymnasium.make_vec(id, num_envs=2, vectorization_mode=mode, text=text)
    singles = [llf_teacher.make(id, text=text) for _ in range(2)]
    try:
        observations, infos = envs.reset(seed=[4, 5])
        expected = [env.reset(seed=seed)[0] for env, seed in zip(singles, (4, 5), strict=True)]
        for key in ("instruction", "feedback"):
            assert tuple(observations[key]) == tuple(each[key] for each in expected)
        world = singles[0].session.world
        for action in some_actions(world, 4):
            said = action if isinstance(action, str) or not text else json.dumps(np.asarray(action).tolist())
            observations, rewards, *_, infos = envs.step([said, said])
            expected = [env.step(said) for env in singles]
            assert tuple(observations["feedback"]) == tuple(each[0]["feedback"] for each in expected)
            if text:
                assert tuple(observations["observation"]) == tuple(each[0]["observation"] for each in expected)
            assert rewards.tolist() == [each[1] for each in expected]
            assert infos["success"].tolist() == [each[4]["success"] for each in expected]
            if any(each[2] or each[3] for each in expected):
                break
    finally:
        envs.close()


def test_reset_options_reach_the_world():
    env = llf_teacher.make("llf-poem-SyllableConstrainedPoem-v0")
    env.reset(seed=0, options={"syllable": 3})
    assert env.session.world.truth.pattern == (3,)
    with pytest.raises(ValueError, match="must be an integer from 1 to 40, got 0"):
        env.reset(options={"syllable": 0})
