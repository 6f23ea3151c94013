"""Numbers: every field says what the state is and what was said, for PettingZoo's seats and for Gymnasium's."""

import copy
import pickle
import warnings
from functools import partial

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AsyncVectorEnv
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test, seed_test
from pettingzoo.utils.conversions import parallel_to_aec
from playing import Fixed
from shelf import FAMILIES

import llf_teacher
from llf_teacher.registry import PREFIX
from pz_envs.parallel_seats import ParallelSeats
from pz_envs.scripted import SayAll
from pz_envs.seats import TEACHER
from teachers.atoms import FP, HN, HP, KINDS, action_of
from worlds.actions import native

GRID, ARMS = "llf-gridworld-v0", "llf-bandits-BanditTenArmedRandomFixed-v0"


def of_numbers(family):
    """Whether its states and its actions are numbers."""
    world = family.make_world(**family.environments[family.showcase[0]])
    found = [world.observation_space, world.action_space]
    for space in found:
        found += space.spaces.values() if isinstance(space, spaces.Dict) else ()
    return not any(isinstance(space, spaces.Text) for space in found)


NUMERIC = [family for family in FAMILIES.values() if of_numbers(family)]
WORDY = [family for family in FAMILIES.values() if not of_numbers(family)]
numeric = pytest.mark.parametrize("family", NUMERIC, ids=lambda family: family.name)
unbounded = pytest.mark.filterwarnings("ignore:.*A Box observation space m..imum value is -?infinity")


def letters(text):
    """How often each of some letters stands in a text."""
    return [text.count(letter) for letter in "aeiou"]


def first_id(family):
    return PREFIX + family.showcase[0]


def by_name(env, observation):
    return {field.name: observation[field.place] for field in env.unwrapped.fields}


def played(env, turns, seed=0):
    """The observations of some turns and what was said, half of them as advised."""
    rng = np.random.default_rng(seed)
    session = env.unwrapped.session
    observation, info = env.reset(seed=seed)
    for _ in range(turns):
        assert "atoms" not in info
        yield observation, session.atoms
        advised = [atom.claim.action for atom in session.atoms if atom.kind is FP and hasattr(atom.claim, "action")]
        world = session.world
        action = world.sample_action(rng)
        if advised and rng.random() < 0.5:
            action = native(world.action_space, advised[0])
        observation, _, terminated, truncated, info = env.step(action)
        if terminated or truncated:
            yield observation, session.atoms
            observation, info = env.reset()


def test_there_are_families_of_both_sorts():
    assert len(NUMERIC) >= 5
    assert WORDY


@numeric
@unbounded
@pytest.mark.filterwarnings("ignore:.*For Box action spaces, we recommend")
def test_gymnasiums_check_passes(family):
    env = llf_teacher.make(first_id(family), numbers=True)
    assert env.observation_space.dtype == np.float32
    check_env(env.unwrapped, skip_render_check=True)


@numeric
@unbounded
def test_pettingzoos_checks_pass(family):
    """Of the student's seat, with a policy in the teacher's: `api_test` asks each observation for its shape, and the
    teacher's Dict has none.
    """
    options = {"numbers": True, "speech": "kinds", "max_cycles": 4, **family.environments[family.showcase[0]]}

    def students_seat():
        return ParallelSeats(family.raw_env(**options), {TEACHER: SayAll()})

    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Agent's m..imum observation space value is -?infinity")
        warnings.filterwarnings("ignore", message="Action space for each agent probably should be .*box or .*discrete")
        api_test(parallel_to_aec(students_seat()), num_cycles=30)
        parallel_api_test(students_seat(), num_cycles=30)
        parallel_seed_test(students_seat, num_cycles=10)
        seed_test(partial(family.env, **options), num_cycles=10)


@numeric
def test_the_fields_lie_side_by_side(family):
    env = llf_teacher.make(first_id(family), numbers=True).unwrapped
    (length,) = env.observation_space.shape
    at = 0
    for field in env.fields:
        assert field.place.start == at < field.place.stop
        assert field.meaning
        at = field.place.stop
    assert at == length
    assert len({field.name for field in env.fields}) == len(env.fields)


@numeric
@pytest.mark.parametrize("teacher", ["oracle", "mistake(eps=0.5) | delayed(turns=1)"])
def test_every_field_is_what_was_said(family, teacher):
    env = llf_teacher.make(first_id(family), teacher=teacher, numbers=True, max_turns=6).unwrapped
    world = env.session.world
    low, high = env.observation_space.low, env.observation_space.high
    named = set()
    for observation, said in played(env, 12 if family.slow else 40):
        assert env.observation_space.contains(observation)
        assert np.isfinite(observation).all()
        assert ((low <= observation) & (observation <= high)).all()
        seen = by_name(env, observation)
        assert seen["turn"][0] == pytest.approx(env.session.moment.turn / 6)
        state = np.concatenate([part for name, part in seen.items() if name.startswith("state")])
        expected = spaces.flatten(world.observation_space, world.observe())
        np.testing.assert_allclose(state, expected, rtol=1e-6, atol=1e-9)
        for kind in KINDS:
            atoms = [atom for atom in said if atom.kind is kind]
            assert seen[f"{kind}.said"][0] == bool(atoms)
            assert seen[f"{kind}.number"][0] == len(atoms)
            about = [atom for atom in atoms if action_of(atom.claim) is not None]
            turn = (about or atoms)[0].about_turn if atoms else 0
            assert seen[f"{kind}.turn"][0] == pytest.approx(turn / 6)
            if kind == "r":
                assert seen["r.told"][0] == pytest.approx(atoms[0].claim.reward if atoms else 0.0)
                continue
            good = kind in (HP, FP)
            assert seen[f"{kind}.verdict"][0] == ((1 if good else -1) if about else 0)
            parts = [part for name, part in seen.items() if name.startswith(f"{kind}.action")]
            action = np.concatenate(parts)
            if about:
                named.add(kind)
                flat = spaces.flatten(world.action_space, native(world.action_space, action_of(about[0].claim)))
                np.testing.assert_allclose(action, flat, rtol=1e-6)
            else:
                assert not action.any()
    assert FP in named
    assert named & {HP, HN}


@pytest.mark.parametrize("id", [GRID, ARMS])
def test_arrays_say_the_same(id):
    batch = gymnasium.make_vec(
        id, num_envs=4, vectorization_mode="vector_entry_point", **{GRID: {"pool": 4}}.get(id, {})
    )
    env = llf_teacher.make(id, numbers=True).unwrapped
    rows, _ = batch.reset(seed=3)
    observation, _ = env.reset(seed=3)
    for action in (0, 1, 0, 1):
        seen = by_name(env, observation)
        assert [seen[f"{kind}.said"][0] for kind in KINDS] == rows["said"][0].tolist()
        for name, kind in (("advised", "fp"), ("warned", "fn")):
            choice = seen[f"{kind}.action"]
            assert (int(choice.argmax()) if choice.any() else -1) == rows[name][0]
        observation, *_ = env.step(action)
        rows, *_ = batch.step(np.full(4, action))


def test_late_advice_says_of_which_turn_it_is():
    env = llf_teacher.make(ARMS, teacher="only(kinds='fp') | delayed(turns=2)", numbers=True, max_turns=10)
    turns = [by_name(env, observation)["fp.turn"][0] for observation, _ in played(env, 6)]
    np.testing.assert_allclose(turns, [0, 0, 0, 0.1, 0.2, 0.3], rtol=1e-6)


@unbounded
@pytest.mark.parametrize("family", WORDY, ids=lambda family: family.name)
def test_texts_need_to_be_embedded(family):
    with pytest.raises(ValueError, match=r"needs states and actions without texts, got .*; give embed=, a function"):
        llf_teacher.make(first_id(family), numbers=True)
    env = llf_teacher.make(first_id(family), numbers=True, embed=letters).unwrapped
    found = dict.fromkeys(("instruction", "feedback"), 0)
    for observation, _ in played(env, 8):
        assert env.observation_space.contains(observation)
        for name in found:
            words = getattr(env.session, name)
            np.testing.assert_array_equal(by_name(env, observation)[name], letters(words))
            found[name] += bool(words)
    assert min(found.values()) >= 4
    check_env(env, skip_render_check=True)


def test_a_text_that_is_advised_is_embedded():
    env = llf_teacher.make(first_id(FAMILIES["poem"]), numbers=True, embed=letters, feedback_type="fp")
    advised = []
    for observation, said in played(env, 10):
        named = [action_of(atom.claim) for atom in said if action_of(atom.claim) is not None]
        seen = by_name(env, observation)["fp.action"].tolist()
        assert seen == (letters(named[0]) if named else letters(""))
        advised += named
    assert advised


def test_words_of_a_person_are_heard_when_they_are_embedded():
    env = llf_teacher.make(ARMS, teacher=Fixed("Try it once more."), numbers=True, embed=letters)
    env.reset(seed=0)
    seen = by_name(env, env.step(0)[0])
    assert seen["feedback"].tolist() == letters("Try it once more.")
    assert not any(seen[f"{kind}.said"][0] for kind in KINDS)


def test_a_class_of_learners_sees_numbers():
    env = FAMILIES["gridworld"].parallel_env(seating="classroom", students=3, attention=3, numbers=True)
    observations, _ = env.reset(seed=0)
    assert {observation.dtype for observation in observations.values()} == {np.dtype(np.float32)}
    assert all(env.observation_space(agent).contains(each) for agent, each in observations.items())


def test_a_learner_of_numbers_is_a_student_of_the_teachers_seat():
    class Reader:
        def reset(self, rng):
            self.seen = []

        def act(self, observation, info):
            self.seen.append(observation)
            (advice,) = (field for field in env.student_view.fields if field.name == "fp.action")
            return int(observation[advice.place].argmax())

    reader = Reader()
    env = llf_teacher.TeacherEnv(GRID, student=reader, numbers=True, until_success=True)
    env.reset(seed=0)
    terminated = False
    while not terminated:
        *_, terminated, truncated, _ = env.step(0b01000)
        assert not truncated
    assert all(env.student_view.observation_space.contains(each) for each in reader.seen)


def test_numbers_are_copied_and_go_through_processes():
    env = llf_teacher.make(GRID, numbers=True)
    env.reset(seed=0)
    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        np.testing.assert_array_equal(other.step(0)[0], copy.deepcopy(env).step(0)[0])
    vector = AsyncVectorEnv([partial(llf_teacher.make, GRID, numbers=True)] * 2)
    observations, _ = vector.reset(seed=0)
    assert observations.shape == (2, *env.observation_space.shape)
    np.testing.assert_array_equal(observations[0], env.reset(seed=0)[0])
    vector.close()


def test_a_lesson_of_ones_own_is_numbers_too():
    env = llf_teacher.teach(gymnasium.make("CartPole-v1"), numbers=True)
    observation, _ = env.reset(seed=0)
    assert env.observation_space.contains(observation)
    assert by_name(env, observation)["state"].shape == (4,)
    assert by_name(env, env.step(1)[0])["r.told"].tolist() == [1.0]


def test_what_is_too_great_stays_within_the_space():
    class Great(gymnasium.Env):
        observation_space = spaces.Box(-np.inf, np.inf, (2,), np.float64)
        action_space = spaces.Discrete(2)

        def reset(self, *, seed=None, options=None):
            super().reset(seed=seed)
            return np.array([1e300, -1e300]), {}

        def step(self, action):
            return np.array([1e300, 1.5]), 0.0, False, False, {}

    env = llf_teacher.teach(Great(), numbers=True, max_turns=2)
    observation, _ = env.reset(seed=0)
    assert np.isfinite(observation).all()
    assert env.step(0)[0][1] == 1.5


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        ({"numbers": True, "text": True}, "text=True and numbers=True exclude each other"),
        ({"numbers": 3}, "numbers must be True or False, got 3"),
        ({"embed": letters}, "embed= needs numbers=True"),
        ({"numbers": True, "embed": lambda text: [[1.0]]}, "embed must give a vector of finite numbers, got"),
        ({"numbers": True, "embed": lambda text: [float("nan")]}, "embed must give a vector of finite numbers, got"),
        ({"numbers": True, "embed": lambda text: "abc"}, "embed must give a vector of finite numbers, got"),
        (
            {"numbers": True, "embed": lambda text: [1.0] * (1 + len(text))},
            "embed must give vectors of one length, got 1",
        ),
    ],
)
def test_bad_arguments(settings, match):
    with pytest.raises(ValueError, match=match):
        llf_teacher.make(GRID, **settings).reset(seed=0)


def test_what_has_no_fixed_number_of_numbers_is_refused():
    class Growing(gymnasium.Env):
        observation_space = spaces.Sequence(spaces.Discrete(2))
        action_space = spaces.Discrete(2)

        def reset(self, *, seed=None, options=None):
            """Never called."""

        step = reset

    with pytest.raises(
        ValueError, match=r"states and actions of a fixed number of numbers, got Sequence.*allowed: Box"
    ):
        llf_teacher.teach(Growing(), numbers=True)


def test_who_reads_no_numbers_is_not_given_any():
    with pytest.raises(ValueError, match="the student obedient, which reads no numbers; give a policy"):
        llf_teacher.TeacherEnv(GRID, student="obedient", numbers=True)
    with pytest.raises(ValueError, match="numbers=True is not supported in a panel, whose student hears each"):
        FAMILIES["gridworld"].raw_env(seating="panel", numbers=True)
