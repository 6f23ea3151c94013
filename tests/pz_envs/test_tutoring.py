"""The seats: turn order, rewards, budgets, openings, arguments."""

import inspect
import warnings

import pettingzoo
import pytest

import llf_teacher
from llf_teacher.registry import entry
from pz_envs.assembly import assemble
from pz_envs.family import all_families
from pz_envs.seats import STUDENT, TEACHER
from pz_envs.settings import Settings
from teachers.atoms import KINDS, Utterance

GRID, BANDIT = entry("llf-gridworld-v0").family, entry("llf-bandits-BanditTenArmedGaussian-v0").family


def test_modules_and_registry_lead_to_the_same_seats():
    from pz_envs.families import gridworld

    made = [gridworld.env(), gridworld.raw_env(), pettingzoo.make("aec", "llf/gridworld-v0")]
    for env in made:
        env.reset(seed=3)
    assert len({env.unwrapped.session.world.truth for env in made}) == 1
    assert gridworld.parallel_env().possible_agents == [TEACHER, STUDENT]
    assert pettingzoo.make("parallel", "llf/gridworld-v0").possible_agents == [TEACHER, STUDENT]
    assert made[0].metadata["name"] == "gridworld_v0"
    assert made[0].metadata["is_parallelizable"] is False


def test_every_environment_is_registered_once():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for id in llf_teacher.ids():
            name = id.replace("llf-", "llf/")
            assert name in pettingzoo.aec_registry
            assert name in pettingzoo.parallel_registry


@pytest.mark.parametrize(("speech", "action"), [("message", 3), ("kinds", 32), ("claims", "1")])
def test_what_the_teacher_cannot_say_leaves_the_turn_to_it(speech, action):
    env = GRID.raw_env(speech=speech)
    env.reset(seed=0)
    with pytest.raises(ValueError, match="the teacher"):
        env.step(action)
    assert env.agent_selection == TEACHER


def test_kinds_bit_i_says_kind_i():
    for bit, kind in enumerate(KINDS):
        env = BANDIT.raw_env(speech="kinds")
        env.reset(seed=0)
        env.step(0)
        env.step(0)
        available = env.observe(TEACHER)["available"]
        env.step(1 << bit)
        said = {atom.kind for atom in env.observe(STUDENT)["feedback"].atoms}
        assert said == ({kind} if available[bit] else set())


def test_kinds_features():
    env = GRID.raw_env(speech="kinds", budget=8, max_cycles=4)
    env.reset(seed=0)
    turn, reward, importance, left, over = env.observe(TEACHER)["features"].tolist()
    assert (turn, reward, left, over) == (0, 0, 1, 0)
    assert 0 < importance <= 2
    for _ in range(4):
        env.step(31)
        env.step(0)
    turn, _, _, left, over = env.observe(TEACHER)["features"].tolist()
    assert (turn, left, over) == (1, 0, 1)
    assert env.observe(TEACHER) in env.observation_space(TEACHER)


def test_both_seats_get_the_worlds_reward_and_the_teachers_can_be_replaced():
    env = BANDIT.raw_env(speech="kinds", teacher_reward=lambda moment, oracle: 10.0 * moment.success)
    env.reset(seed=0)
    best = env.session.world.truth.best[0]
    env.step(31)
    env.step(best)
    assert env.rewards[TEACHER] == 10.0
    assert env.rewards[STUDENT] == env.session.moment.reward
    env = BANDIT.raw_env(speech="kinds", cost=0.0)
    env.reset(seed=0)
    env.step(31)
    env.step(best)
    assert env.rewards[TEACHER] == env.rewards[STUDENT] != 0


@pytest.mark.parametrize("family", all_families(), ids=lambda family: family.name)
def test_a_text_that_is_no_action_keeps_success_where_it_is_the_episodes(family):
    session, _, _ = assemble(family, Settings(text=True, options=family.environments[family.showcase[0]]))
    session.open(0)
    oracle = family.oracle_class()(session.world.scratch)
    oracle.start(session.moment.after)
    for action in oracle.plan(session.moment.after, session.max_turns - 1):
        session.say("")
        session.act(action if isinstance(action, str) else f"{action}")
        if session.moment.success:
            break
    assert session.moment.success
    session.say("")
    session.terminated = False  # where success ends the episode
    session.act("\x00")
    assert session.moment.success is not family.repeated


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        ({"speech": "song"}, "speech 'song' is unknown; allowed: message, kinds"),
        ({"max_cycles": 0}, "must be an integer of at least 1, got 0"),
        ({"max_cycles": 1.5}, "must be an integer of at least 1, got 1.5"),
        ({"cost": -1}, "cost must be a finite number of at least 0, got -1"),
        ({"cost": "x"}, "cost must be a finite number of at least 0, got 'x'"),
        ({"cost": float("inf")}, "cost must be a finite number of at least 0, got inf"),
        ({"cost": float("nan")}, "cost must be a finite number of at least 0, got nan"),
        ({"ask_cost": True}, "ask_cost must be a finite number of at least 0, got True"),
        ({"budget": 0}, "budget must be None or an integer of at least 1, got 0"),
        ({"budget": 2.5}, r"budget must be None or an integer of at least 1, got 2\.5"),
        ({"budget": True}, "budget must be None or an integer of at least 1, got True"),
        ({"render_mode": "x"}, "render_mode 'x' is unknown"),
        ({"student": "ucb"}, r"unknown option 'student'; allowed: .*; a student is for TeacherEnv\(stu"),
        ({"student": "ucb"}, r"for PettingZoo's seats a partner in pz_envs.parallel_seats.ParallelSeats\(env, {"),
        ({"student": 3, "seating": "classroom"}, "unknown option 'student'; did you mean students"),
        *(
            ({name: True}, f"unknown option '{name}'; allowed: .*; '{name}' is an argument of TeacherEnv$")
            for name in ("actions", "announce", "same_world", "vary")
        ),
    ],
)
def test_bad_arguments(arguments, match):
    with pytest.raises(ValueError, match=match):
        GRID.raw_env(**arguments)


def test_what_only_the_teachers_environment_takes_is_taken_there():
    own = inspect.signature(llf_teacher.TeacherEnv).parameters.keys() - inspect.signature(llf_teacher.make).parameters
    assert {name for name in own if GRID.elsewhere(name)} == {"student", "actions", "announce", "same_world", "vary"}


def test_dead_steps_take_none_only():
    env = pettingzoo.make("aec", "llf/gridworld-v0", max_cycles=1)
    env.reset(seed=0)
    env.step("Go.")
    env.step(0)
    env.step("Over.")
    assert env.last()[0]["feedback"] == "Over."
    with pytest.raises(ValueError, match="when an agent is dead, the only valid action is None"):
        env.step(0)
    env.step(None)
    env.step(None)
    assert env.agents == []


def test_observations_that_were_handed_out_can_be_changed():
    env = GRID.raw_env()
    env.reset(seed=0)
    env.step(Utterance("Go."))
    room = env.observe(STUDENT)["state"]["room"]
    env.observe(STUDENT)["state"]["room"] = -5
    assert env.observe(STUDENT)["state"]["room"] == room


def test_what_cannot_be_said_is_told():
    """The kinds of a subset of which nothing was said: there was nothing to say, or the budget was spent."""
    env = GRID.raw_env(speech="kinds", budget=2, max_cycles=4)
    env.reset(seed=0)
    trimmed = [env.infos["teacher_0"]["trimmed"]]
    for said in (0b01000, 0b00001, 0b11000, 0b01111):
        env.step(said)
        trimmed.append(env.infos["teacher_0"]["trimmed"])
        env.step(0)
        assert env.infos["teacher_0"]["trimmed"] == trimmed[-1]
    assert trimmed == [0, 0, 0, 0b11000, 0b01111]
    env.reset(seed=0)
    assert env.infos["teacher_0"]["trimmed"] == 0
    env.step(0b11111)
    assert env.infos["teacher_0"]["trimmed"] == 0b00111, "there is no hindsight at the opening"


@pytest.mark.parametrize("seating", ["classroom", "panel"])
def test_what_cannot_be_said_is_told_in_every_seating(seating):
    env = GRID.raw_env(seating=seating, speech="kinds")
    env.reset(seed=0)
    teacher = env.agent_selection
    env.step(env.address(1, 0b11011) if seating == "classroom" else 0b11011)
    assert env.infos[teacher]["trimmed"] == 0b00011


def test_what_is_paid_adds_up_between_an_agents_turns_and_is_no_negative_zero():
    env = GRID.raw_env(speech="kinds", cost=0.5, teacher_reward=lambda moment, oracle: 3.0)
    env.reset(seed=0)
    env.step(0)
    assert str(env._cumulative_rewards) == str({TEACHER: 0.0, STUDENT: 0.0})
    env.step(0)
    assert env.last()[1] == 3.0
    env.step(0b00001)
    env.step(0)
    assert env.last()[1] == 3.0 - 0.5


@pytest.mark.parametrize("personality", ["oracle", "mistake(eps=0.5)"])
@pytest.mark.parametrize("options", [{}, {"budget": 9}, {"ask_cost": 0.1}, {"teacher_reward": "student_progress"}])
@pytest.mark.parametrize("family", [GRID, BANDIT], ids=lambda family: family.name)
def test_suggestions_that_are_taken_in_the_seat_are_what_the_session_says_by_itself(family, options, personality):
    one, other = (family.raw_env(teacher=personality, text=True, max_cycles=6, **options) for _ in range(2))
    one.reset(seed=5)
    other.session.open(5)
    for action in ("2", "\x00", "0", "1", "1", "0", None):
        one.step(one.infos[TEACHER]["suggestion"])
        other.session.speak()
        assert repr(one.session.turn) == repr(other.session.turn)
        if action is not None:
            one.step(action)
            other.session.act(action)
    assert one.truncations[STUDENT]
    assert other.session.truncated
