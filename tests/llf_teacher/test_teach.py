"""Any Gymnasium environment can be taught."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from lake import PHRASES, WORDS, Head, LakeOracle
from walks import Walk

import llf_teacher
from llf_teacher.episodes.loop import play_turns
from llf_teacher.students.parsing import parse_student
from pz_envs import testing as seat_kit
from teachers import testing as teacher_kit
from teachers.atoms import FP, Claim, ParseFailure, claim
from teachers.oracle import Oracle, RefusalError
from teachers.reward_oracle import RewardOracle
from worlds import testing as world_kit
from worlds.testing import plain
from worlds.wrapped.gym_world import GymWorld

pytestmark = [  # what Gymnasium has to say of its own environments
    pytest.mark.filterwarnings("ignore:.*Box observation space m.* value is -?infinity"),
    pytest.mark.filterwarnings("ignore:.*recommend using a symmetric and normalized space"),
]


LAKE = "FrozenLake-v1"
CART = "CartPole-v1"
SNAPSHOTS = ("copy", "replay")


def lake_options(slippery=False, **options):
    def look(env):
        return int(env.unwrapped.s)

    return {
        "env": lambda: gymnasium.make(LAKE, is_slippery=slippery),
        "oracle": LakeOracle,
        "phrases": PHRASES,
        "look": look,
        "action_words": WORDS,
        **options,
    }


def teach_lake(slippery=False, snapshot="auto", **settings):
    return llf_teacher.teach(**lake_options(slippery, snapshot=snapshot), **settings)


def lake_pupil(slippery=False, turns=150, **options):
    lesson = llf_teacher.Lesson(**lake_options(slippery, **options))
    return teacher_kit.Pupil(lesson.make_world, lesson.make_teacher, max_turns=lesson.max_turns, turns=turns)


def play(env, student, seed=0):
    policy = parse_student(student).seat(env.family, env.session.world)
    for _ in play_turns(env, policy, seed):
        pass
    return env.session.moment.success, env.session.moment.turn


# --- rewards alone


def test_without_an_oracle_the_instruction_is_to_maximize_rewards_and_the_feedback_is_the_reward():
    env = llf_teacher.teach(gymnasium.make(CART))
    observation, info = env.reset(seed=0)
    assert {type(atom.claim).__name__ for atom in info["atoms"]} == {"Maximize", "Syntax"}
    assert "an integer from 0 to 1" in observation["instruction"]
    assert observation["feedback"] == ""
    observation, reward, _, _, info = env.step(1)
    assert [atom.kind for atom in info["atoms"]] == ["r"]
    assert reward == info["atoms"][0].claim.reward == 1.0
    assert env.teacher.oracle.feedback_types == ("r",)
    assert isinstance(env, llf_teacher.StudentEnv)


def test_the_trace_is_the_environments_own():
    taught, bare = llf_teacher.teach(gymnasium.make(CART)), gymnasium.make(CART)
    taught.reset(seed=0)
    bare.reset(seed=taught.session.world.truth.seed)
    for action in [0, 1, 1, 0, 1]:
        observation, reward, *_ = taught.step(action)
        expected = bare.step(action)
        assert plain(observation["observation"]) == plain(expected[0])
        assert reward == expected[1]


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        ({"instruction_type": "p"}, "instruction type 'p' is not supported; allowed: b$"),
        ({"instruction_type": "c"}, "instruction type 'c' is not supported; allowed: b$"),
        ({"feedback_type": "r+fp"}, "feedback type 'r\\+fp' is not supported; allowed: a, n, m, and of r$"),
        ({"snapshot": "maybe"}, "snapshot 'maybe' is unknown; allowed: auto, copy, replay"),
        ({"num_rooms": 3}, "does not take these options: unknown option 'num_rooms'"),
        ({"max_turns": 0}, "must be an integer of at least 1"),
        ({"reward_range": (0, float("inf"))}, "reward_range must be two finite numbers"),
        ({"teacher": "orakle"}, "unknown personality"),
        ({"phrases": {"Nothing": ["a", "b", "c", "d"]}}, "Nothing: there is no claim of this name"),
        ({"phrases": "none.toml"}, "cannot read phrases from none.toml"),
        (
            {"action_words": {"left": 7}},
            "action_words must name actions of the action space, got 'left': .*; allowed: an integer from 0 to 1",
        ),
    ],
)
def test_what_is_not_supported_is_a_value_error(settings, match):
    with pytest.raises(ValueError, match=match):
        llf_teacher.teach(gymnasium.make(CART), **settings)


@pytest.mark.parametrize(
    "teacher", ["retry_only", "placebo", "misaligned", "mix", "mistake(eps=1)", "delayed", "silent"]
)
@pytest.mark.parametrize("feedback_type", ["a", "m", "n", "r"])
def test_rewards_alone_with_every_personality(teacher, feedback_type):
    env = llf_teacher.teach(gymnasium.make(CART), teacher=teacher, feedback_type=feedback_type)
    env.reset(seed=0)
    said = [env.step(i % 2)[0]["feedback"] for i in range(5)]
    assert any(said) == (teacher != "silent" and feedback_type != "n" and (teacher, feedback_type) not in SILENT)


SILENT = {("retry_only", "r"), ("retry_only", "m")}  # what it says is of another kind


def test_rewards_alone_pass_the_kit():
    for snapshot in SNAPSHOTS:
        lesson = llf_teacher.Lesson(lambda: gymnasium.make(CART), snapshot=snapshot)
        teacher_kit.check_oracle(teacher_kit.Pupil(lesson.make_world, lesson.make_teacher, turns=60))


def test_rewards_alone_refuse_to_tell_regrets():
    env = llf_teacher.teach(gymnasium.make(CART), privileged_info=True)
    env.reset(seed=0)
    with pytest.raises(RefusalError, match="gives no values"):
        RewardOracle(env.session.world.scratch).regret(env.step(0)[4]["moment"])


@pytest.mark.parametrize("id", [CART, LAKE, "Pendulum-v1", "Blackjack-v1", "Taxi-v4"])
@pytest.mark.parametrize("text", [False, True])
def test_gymnasiums_check(id, text):
    check_env(llf_teacher.teach(gymnasium.make(id), text=text), skip_render_check=True)


@pytest.mark.parametrize("check", seat_kit.CHECKS, ids=lambda check: check.__name__)
def test_seats_of_rewards_alone(check):
    lesson = llf_teacher.Lesson(lambda: gymnasium.make("Pendulum-v1"))
    check(lambda max_cycles=12, **settings: lesson.env(max_cycles=max_cycles, **settings))


def test_seats_of_cartpole_pass_pettingzoos_check():
    from pettingzoo.test import api_test, parallel_api_test, seed_test

    lesson = llf_teacher.Lesson(lambda: gymnasium.make(CART))
    for speech in ("kinds", "message"):
        with seat_kit.expected_warnings():
            api_test(lesson.env(speech=speech), num_cycles=100)
            seed_test(lambda speech=speech: lesson.env(speech=speech), num_cycles=50)
            parallel_api_test(lesson.parallel_env(speech=speech), num_cycles=50)
    with seat_kit.expected_warnings():
        api_test(llf_teacher.Lesson(gymnasium.make(CART)).raw_env(), num_cycles=20)


def test_the_teachers_side():
    env = llf_teacher.TeacherEnv(llf_teacher.Lesson(gymnasium.make(CART)), student="random")
    check_env(env, skip_render_check=True)


def test_who_plans_must_tell_regrets():
    class Secretive(RewardOracle):
        def plan(self, truth, n):
            return (0,)

        def regret(self, moment):
            if moment.turn > 1 or moment.action:
                raise RefusalError("a secret")
            return 0.0

    lesson = llf_teacher.Lesson(lambda: gymnasium.make(CART), Secretive)
    pupil = teacher_kit.Pupil(lesson.make_world, lesson.make_teacher)
    with pytest.raises(AssertionError, match="has plans, but no regret"):
        teacher_kit.check_plans(pupil)


# --- an oracle of one's own


@pytest.mark.parametrize("snapshot", SNAPSHOTS)
@pytest.mark.parametrize("slippery", [False, True])
@pytest.mark.parametrize("check", teacher_kit.CHECKS, ids=lambda check: check.__name__)
def test_an_oracle_of_ones_own_passes_the_kit(check, slippery, snapshot):
    check(lake_pupil(slippery, snapshot=snapshot))


def test_students_learn_from_it():
    """A reader of words, too, by the slots that the claims declare; the slot is `{move}`."""
    env, complete = teach_lake(), teach_lake(feedback_type="n", instruction_type="c")
    assert play(env, "oracle") == (True, 6)
    for student in ("text_only", "obedient"):
        assert [play(env, student, seed) for seed in range(20)] == [(True, 6)] * 20
        assert play(complete, student) == (True, 6)
    assert not play(env, "random")[0]


def test_text_mode_with_words_of_ones_own():
    env = teach_lake(text=True)
    observation, _ = env.reset(seed=0)
    assert observation["observation"] == "0"
    assert "one of left, down, right, up, or an integer from 0 to 3" in observation["instruction"]
    observation, *_ = env.step("Thought: hm.\nResponse: Down")
    assert observation["observation"] == "4"
    observation, *_, info = env.step("jump")
    assert type(info["parse_failure"]) is ParseFailure
    assert env.step("2")[0]["observation"] == "5"


def test_phrases_by_class_by_name_and_from_a_file(tmp_path):
    lines = [f"{name} = {[*phrases]!r}" for name, phrases in PHRASES.items()]
    flat, voiced = tmp_path / "flat.toml", tmp_path / "voiced.toml"
    flat.write_text("\n".join(lines), encoding="utf-8-sig")
    voiced.write_text("\n".join(["[plain]", *lines]))
    module = vars(__import__("lake"))
    by_class = {module[name]: phrases for name, phrases in PHRASES.items()}
    openings = set()
    for phrases in (PHRASES, by_class, flat, str(voiced)):
        env = llf_teacher.teach(**lake_options(phrases=phrases))
        openings.add(plain(env.reset(seed=1)[0]))
    assert len(openings) == 1
    with pytest.raises(ValueError, match="Route: has no phrases"):
        llf_teacher.teach(**lake_options(phrases={name: PHRASES[name] for name in list(PHRASES)[:-1]}))
    some = {cls: phrases for cls, phrases in by_class.items() if cls is not Head}
    with pytest.raises(ValueError, match="the claim Head has no phrases"):
        llf_teacher.teach(**lake_options(phrases=some)).reset(seed=0)


def test_a_small_oracle_need_not_implement_more_than_it_uses():
    @claim
    class Up(Claim):
        kind = FP
        action: int

        def holds(self, moment, lab):
            return True

    class Small(Oracle):
        instruction_types = ("b", "p")

        def _basics(self, truth):
            return ()

        def _hindsight(self, claims, moment, kinds):
            pass

        def _advice(self, claims, moment, kinds):
            if FP in kinds:
                claims.append(Up(action=1))

        def values(self, truth):
            return 0.0, 1.0

    env = llf_teacher.teach(gymnasium.make(CART), Small, phrases={Up: [f"{i} {{action}}" for i in range(4)]})
    env.reset(seed=0)
    assert env.step(0)[4]["atoms"][-1].claim == Up(action=1)
    oracle = env.teacher.oracle
    assert (oracle.plan(None, 3), oracle.plan(None, 0), oracle.importance(None)) == ((1,), (), 1.0)
    env.teacher.instruction_type = "p"
    with pytest.raises(RefusalError, match="but does not implement _practice"):
        env.reset()
    with pytest.raises(RefusalError, match="but does not implement _solution"):
        oracle._solution(None)


# --- the wrapped world


@pytest.mark.parametrize("snapshot", SNAPSHOTS)
@pytest.mark.parametrize("check", world_kit.CHECKS, ids=lambda check: check.__name__)
@pytest.mark.parametrize("id", [LAKE, "Pendulum-v1", "Acrobot-v1"])
@pytest.mark.filterwarnings("ignore:.*Casting input x to numpy array")
def test_wrapped_worlds_pass_the_kit(id, check, snapshot):
    check(lambda: GymWorld(gymnasium.make(id), snapshot=snapshot))


@pytest.mark.parametrize(
    ("info", "options", "success"),
    [
        ({}, {}, False),
        ({"success": 1.0}, {}, True),
        ({"is_success": np.True_}, {}, True),
        ({"is_success": True}, {"success": lambda *_: False}, False),
        ({}, {"success": lambda observation, reward, terminated, truncated, info: reward == 0.5}, True),
    ],
)
def test_success(info, options, success):
    walk = Walk()
    walk.info = info
    world = GymWorld(walk, **options)
    assert world.reset(seed=0)[1]["success"] is False
    assert world.step(0)[4]["success"] is success
    world.restore(world.truth)
    world.env.unwrapped.at = 30
    if not info and not options:
        assert world.step(0)[4]["success"] is True


@pytest.mark.parametrize("cast", [int, np.int64, np.int8, np.array])
def test_an_integer_of_any_type_is_the_action(cast):
    world = GymWorld(gymnasium.make(CART))
    assert [type(world.legal(cast(action))) for action in (0, 1)] == [int, int]
    for action in (-1, 2):
        with pytest.raises(ValueError, match="an integer from 0 to 1"):
            world.legal(cast(action))


def test_reward_range():
    assert GymWorld(Walk()).reward_range == (-1.0, 1.0)
    assert GymWorld(gymnasium.make(CART)).reward_range == (-1e6, 1e6)
    assert GymWorld(Walk(), reward_range=(0, 2)).reward_range == (0.0, 2.0)


def test_describe():
    world = GymWorld(Walk(), describe=lambda observation: f"at {observation[0]:.0f}")
    assert world.describe(world.reset(seed=0)[0]) == "at 0"


def test_the_first_seats_are_over_the_given_environment():
    env = gymnasium.make(CART)
    lesson = llf_teacher.Lesson(env)
    first, second = lesson.raw_env(), lesson.raw_env()
    assert first.session.world.env is env
    second.reset(seed=0)
    assert second.session.world.env is not env
    first.reset(seed=0)
    first.close()
