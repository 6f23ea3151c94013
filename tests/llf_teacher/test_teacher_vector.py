"""Thousands of lifetimes at once: rows of teachers' seats are the scalar environments, with the students' tables."""

import copy
import pickle
from collections import Counter
from types import SimpleNamespace

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode
from hypothesis import given, settings
from hypothesis import strategies as st

import llf_teacher
from llf_teacher import ids
from llf_teacher.gym.vector.spoken import WITHIN
from llf_teacher.gym.vector.teacher import REWARDS
from llf_teacher.registry import PREFIX
from llf_teacher.students.builtin.tamer import Tamer
from llf_teacher.students.parsing import STUDENTS as PLAYERS
from llf_teacher.students.parsing import TRAITS, parse_student
from llf_teacher.students.student import frozen
from llf_teacher.students.trait import traits_of
from llf_teacher.students.traits.stubborn import Stubborn
from pz_envs.family import all_families
from pz_envs.rewards import TEACHER_REWARDS
from teachers.atoms import KINDS
from teachers.budget import within
from teachers.feedback import SUBSETS
from worlds.testing import plain

TABULAR = [
    PREFIX + name
    for family in all_families()
    if family.world_batch
    for name in family.showcase
    if hasattr(family.make_world(**family.environments[name]).action_space, "n")
]
POINTS = [id for id in ids() if id.startswith(PREFIX + "optimization")]
GRID = "llf-gridworld-v0"
LEARNER = "q_learning(forget=False, trust=1.0, optimism=0.0, epsilon=0.1)"


def batch_of(id, rows, **changes):
    small = {"pool": 4} if id == GRID else {}
    given = {"student": LEARNER, "episodes": 3, "max_turns": 6, **small, **changes}
    return llf_teacher.TeacherVectorEnv(id, rows, **given)


def check_seen(seen, row, observation):
    assert seen.keys() == observation.keys()
    for name, part in observation.items():
        np.testing.assert_allclose(seen[name][row], part, rtol=1e-6, atol=1e-9, err_msg=name)


def known(student, states):
    """What a scalar student has learned, by state; of states that it has not seen it knows nothing."""
    student = getattr(student, "inner", student)
    match student.spec.name:
        case "q_learning":
            unseen = [student.spec.optimism] * student.action_count
            return [student._values.get(state, unseen) for state in states]
        case "tamer":
            return [student._human((state,)) for state in states]
        case "obedient":
            return [[*student._right.get(state, {})] for state in states]
        case "ucb":
            return [student._count, student._sum, [student._untried.index(arm) for arm in sorted(student._untried)]]


def check_known(batch, row, lesson):
    """What the scalar student has learned is what the row's student has learned."""
    states = [frozen(batch.worlds.seen(row, place)) for place in range(batch.lives.visits.shape[1])]
    mine, other = known(batch.lesson(row).student, states), known(lesson.student, states)
    for one, another in zip(mine, other, strict=True):
        np.testing.assert_allclose(one, another, rtol=1e-12, atol=1e-12)


def check_lifetimes(id, rows, seed, mode, **options):
    """Play rows, and lessons that begin at any of their turns, alike; how many lifetimes and successes were seen."""
    rng = np.random.default_rng(seed)
    near = {"num_rooms": 6, "min_goal_dist": 1} if id == GRID else {}  # so that students succeed
    batch = batch_of(id, rows, autoreset_mode=mode, **near, **options)
    seen, infos = batch.reset(seed=seed)
    lessons, compared = {}, Counter()
    for turn in range(2 * batch.episodes * (batch.max_turns + 1)):
        for row in range(rows):
            if row not in lessons and not batch._done[row] and (turn < 1 or rng.random() < 0.2):
                lessons[row] = lesson = batch.lesson(row)
                check_seen(seen, row, lesson._observe()[0])
        actions = rng.integers(batch.single_action_space.n, size=rows)
        seen, rewards, terminated, truncated, infos = batch.step(actions)
        for row, lesson in list(lessons.items()):
            observation, reward, *ends, info = lesson.step(int(actions[row]))
            assert rewards[row] == pytest.approx(reward, abs=1e-9)
            assert [terminated[row], truncated[row]] == ends
            if any(ends):
                last = (
                    seen
                    if mode is AutoresetMode.NEXT_STEP
                    else {name: {row: part} for name, part in infos["final_obs"][row].items()}
                )
                check_seen(last, row, observation)
                del lessons[row]
                compared["lifetimes"] += 1
                continue
            check_seen(seen, row, observation)
            intention = int(infos["intention"][row])
            assert (None if intention < 0 else intention) == info.get("intention")
            assert infos["trimmed"][row] == info["trimmed"]
            assert str(batch.students.student(row)) == info["student"]
            compared["successes"] += batch.moments.over[row] and batch.moments.success[row]
            if turn % 5 == 0 and row < 4:  # a lesson takes a while to make
                check_known(batch, row, lesson)
    return compared


VARIED = [{}, {"alpha": (0.1, 0.9), "epsilon": (0.0, 0.5)}, {"trust": (0, 1), "optimism": (0.0, 1.0)}]
LIVES = {
    "seed": st.integers(0, 2**31),
    "mode": st.sampled_from([AutoresetMode.SAME_STEP, AutoresetMode.NEXT_STEP]),
    "episodes": st.integers(1, 4),
    "max_turns": st.integers(1, 7),
    "actions": st.sampled_from(["all", "compact"]),
    "announce": st.booleans(),
    "budget": st.sampled_from([None, 1, 3, 12]),
    "cost": st.sampled_from([0.0, 0.05]),
    "feedback_type": st.sampled_from(["a", "a", "fp", "fn", "r+hn"]),
    "teacher_reward": st.sampled_from(sorted(TEACHER_REWARDS)),
    "until_success": st.booleans(),
    "vary": st.sampled_from(VARIED),
    "trust": st.sampled_from([0.0, 0.5, 1.0]),
    "forget": st.booleans(),
}


def lived(life):
    """The arguments of `check_lifetimes`."""
    life = dict(life)
    forget = life.pop("forget") or life["episodes"] == 1
    student = f"q_learning(forget={forget}, trust={life.pop('trust')}, optimism=0.1, epsilon=0.2)"
    return {**life, "student": student}


@pytest.mark.parametrize("id", TABULAR)
@settings(max_examples=6, deadline=None, derandomize=True)
@given(life=st.fixed_dictionaries(LIVES))
def test_lessons_live_on_as_their_rows(id, life):
    """What the teacher observes and is paid, what is announced, what the student learns, and when a lifetime ends."""
    check_lifetimes(id, 3, **lived(life))


STUDENTS = (
    "tamer(forget=False, alpha=0.5)",
    "ucb(forget=False, trust=0.6)",
    "ucb(trust=1.0, scale=0.2)",
    "tamer | stubborn(p=0.4)",
    "ucb(trust=1.0) | skims(kinds='a', p=0.5) | stubborn(p=0.3) | mishears(p=0.3)",
    "q_learning(forget=False, trust=0.5, optimism=0.1) | mishears(p=0.7) | skims(kinds='fp+hp', p=0.5)",
    "tamer(forget=False) | mishears(p=0.5) | forgetful(half_life=2)",
    "ucb(forget=False, trust=0.5) | forgetful(half_life=2)",
)
"""Students and traits with a form in arrays."""
TEACHERS = ("oracle", "early(budget=3)", "delayed(turns=1)", "only(kinds='hp+hn+fp') | delayed(turns=2)")
LIVES_OF_OTHERS = {
    **LIVES,
    "student": st.sampled_from(STUDENTS),
    "teacher": st.sampled_from(TEACHERS),
    "feedback_type": st.sampled_from(["a", "a", "hp+hn", "fp+fn"]),
    "vary": st.just({}),
}
for name in ("trust", "forget"):
    del LIVES_OF_OTHERS[name]


def lived_by_others(life):
    """The arguments of `check_lifetimes`; what is remembered needs several episodes, and only learners announce."""
    announces = life["announce"] and life["student"].startswith(("q_learning", "ucb"))
    episodes = max(life["episodes"], 1 + ("forget=False" in life["student"]))
    return {**life, "announce": announces, "episodes": episodes}


@pytest.mark.parametrize("student", STUDENTS)
@settings(max_examples=4, deadline=None, derandomize=True)
@given(id=st.sampled_from(TABULAR), life=st.fixed_dictionaries(LIVES_OF_OTHERS))
def test_other_students_live_on_as_their_rows(student, id, life):
    check_lifetimes(id, 3, **lived_by_others({**life, "student": student}))


def test_success_is_misheard_alike():
    """The last praise of an episode, from which the student learns for the next one."""
    options = {"feedback_type": "hp", "episodes": 5, "max_turns": 2, "until_success": True}
    compared = check_lifetimes(
        GRID, 20, 3, AutoresetMode.NEXT_STEP, student="tamer(forget=False) | mishears(p=0.5)", **options
    )
    assert compared["successes"] > 10


def test_every_student_and_trait_that_arrays_have_is_tested():
    parts = [traits_of(parse_student(spec)) for spec in (LEARNER, "obedient", *STUDENTS)]
    assert {student.name for student, _ in parts} == {name for name in PLAYERS.names if PLAYERS[name].batch}
    assert {trait.name for _, traits in parts for trait in traits} == {
        name for name in TRAITS.names if TRAITS[name].in_arrays()
    }


def test_a_student_that_acts_otherwise_has_not_the_arrays_of_its_base():
    class Calm(Stubborn):
        def act(self, action, scene):
            return action

    class Slow(Tamer):
        policy = type("Policy", (Tamer.policy,), {})

    for student, what in ((Tamer() | Calm(), "trait .*Calm"), (Slow(), "student Slow")):
        with pytest.raises(ValueError, match=f"the {what} cannot play in arrays; allowed: "):
            batch_of(GRID, 2, student=student, episodes=1)


LIVES_AMONG_POINTS = {**LIVES, "shift": st.booleans()}


def proposed(life):
    """The arguments of `check_lifetimes` with points as actions; the student announces none and has no parameters."""
    forget = life["forget"] or life["episodes"] == 1
    own = {name: value for name, value in life.items() if name not in ("forget", "trust", "announce", "vary")}
    return {**own, "student": f"obedient(forget={forget})"}


@pytest.mark.parametrize("id", POINTS)
@settings(max_examples=2, deadline=None, derandomize=True)
@given(life=st.fixed_dictionaries(LIVES_AMONG_POINTS))
def test_lessons_with_points_live_on_as_their_rows(id, life):
    check_lifetimes(id, 3, **proposed(life))


@pytest.mark.parametrize("forget", [True, False])
def test_long_lives_among_points_go_on_as_their_rows(forget):
    """Numbers of points that do not come again are used again, and more are added where many may come again."""
    life = {"student": f"obedient(forget={forget})", "episodes": 11, "max_turns": 3}
    check_lifetimes(POINTS[0], 2, 1, AutoresetMode.NEXT_STEP, **life)
    batch = batch_of(POINTS[0], 40, **life)
    rng, bounds = np.random.default_rng(0), []
    for speaks in (0.0, 0.4):
        batch.reset(seed=0)
        for _ in range(11 * 4 - 1):
            batch.step(np.where(rng.random(40) < speaks, 0b01000, 0))
        bounds.append(batch.lives.visits.shape[1])
    assert bounds[0] == 2 * (3 + 1) < bounds[1]


SWEEPS = [
    *((id, LIVES, lived, 60, 1000) for id in TABULAR),
    *((id, LIVES_OF_OTHERS, lived_by_others, 60, 1000) for id in TABULAR),
    *((id, LIVES_AMONG_POINTS, proposed, 40, 400) for id in POINTS),
]
"""Ids, what is drawn of lives, the arguments of `check_lifetimes`, and how many are drawn and at least compared."""


@pytest.mark.full
@pytest.mark.parametrize(("id", "lives", "arguments", "examples", "least"), SWEEPS)
def test_thousands_of_lessons_live_on_as_their_rows(id, lives, arguments, examples, least):
    lifetimes = 0

    @settings(max_examples=examples, deadline=None, derandomize=True)
    @given(life=st.fixed_dictionaries(lives))
    def check(life):
        nonlocal lifetimes
        lifetimes += check_lifetimes(id, 20, **arguments(life))["lifetimes"]

    check()
    assert lifetimes > least


@pytest.mark.parametrize("id", TABULAR)
def test_seeded_starts_are_the_scalar_ones(id):
    options = {"vary": {"alpha": (0.1, 0.9), "trust": (0, 1)}, "budget": 4}
    batch = batch_of(id, 6, **options)
    seen, _ = batch.reset(seed=5)
    assert batch.observation_space.contains(seen)
    assert (batch.action_masks() == seen["action_mask"]).all()
    for row in range(6):
        env = llf_teacher.TeacherEnv(id, student=LEARNER, episodes=3, max_turns=6, **options)
        observation, info = env.reset(seed=5 + row)
        check_seen(seen, row, observation)
        assert str(batch.students.student(row)) == info["student"]
        assert batch.moment(row).after == env.session.moment.after


@pytest.mark.parametrize("id", TABULAR)
def test_rows_with_the_same_seed_share_the_world_and_not_the_students_draws(id):
    """And equal lists of seeds give equal lifetimes."""

    def lifetimes(seeds):
        batch = batch_of(id, len(seeds), vary={"alpha": (0.1, 0.9)})
        batch.reset(seed=seeds)
        starts = [batch.moment(row).after for row in range(len(seeds))]
        students = [str(batch.students.student(row)) for row in range(len(seeds))]
        actions = []
        for _ in range(18):
            batch.step(np.zeros(len(seeds), int))
            actions.append(batch.moments.action)
        return starts, students, np.array(actions)

    starts, students, played = lifetimes([7, 8] * 4)
    assert starts == starts[:2] * 4
    assert students == students[:2] * 4
    assert starts[0] != starts[1]
    assert not (played[:, 2:] == played[:, :-2]).all()
    again = lifetimes([7, 8] * 4)
    assert (again[0], again[1]) == (starts, students)
    np.testing.assert_array_equal(again[2], played)
    fewer = lifetimes([7, 8])
    assert (fewer[0], fewer[1]) == (starts[:2], students[:2])


def test_autoresets_enrol_new_students():
    batch = batch_of(GRID, 300, episodes=1, max_turns=1, student="q_learning", vary={"alpha": (0.2, 0.4)})
    batch.reset(seed=0)
    first = batch.students.parameter("alpha", slice(None)).copy()
    for _ in range(3):  # the student's turn, the last word, the next lifetime
        batch.step(np.zeros(300, int))
    second = batch.students.parameter("alpha", slice(None))
    assert (first != second).all()
    assert 0.2 <= second.min() < 0.22
    assert 0.38 < second.max() <= 0.4


@pytest.mark.parametrize("again", [copy.deepcopy, lambda batch: pickle.loads(pickle.dumps(batch))])
def test_a_copy_goes_on_alike_and_by_itself(again):
    batch = batch_of(GRID, 5, announce=True, student="q_learning(forget=False, epsilon=0.1)", episodes=50)
    batch.reset(seed=0)
    batch.step(np.zeros(5, int))
    twin = again(batch)
    for _ in range(60):
        mine, other = batch.step(np.zeros(5, int)), twin.step(np.zeros(5, int))
        assert plain(mine) == plain(other)
    assert (batch.students.table == twin.students.table).all()
    twin.step(np.zeros(5, int))
    assert (batch.students.table != twin.students.table).any()


def test_what_a_budget_leaves_of_a_subset():
    for subset in range(SUBSETS):
        atoms = [SimpleNamespace(kind=kind) for i, kind in enumerate(KINDS) if subset >> i & 1]
        for left in range(6):
            kept = within(left, atoms)
            assert WITHIN[subset, left] == sum(1 << KINDS.index(atom.kind) for atom in kept)


def test_the_named_rewards_are_those_of_the_seats():
    assert set(REWARDS) == set(TEACHER_REWARDS)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"student": "text_only"}, "text_only cannot play in arrays; allowed: obedient, q_learning, tamer, ucb;"),
        ({"student": "obedient"}, r"in arrays the student obedient needs actions in a box, got Discrete\(4\)"),
        (
            {"student": f"{LEARNER} | stubborn | partial_plan"},
            "the trait partial_plan cannot play in arrays; allowed: forgetful, mishears, skims, stubborn; TeacherEnv",
        ),
        ({"student": "tamer | stubborn", "vary": {"alpha": (0, 1)}}, "vary needs a student without traits"),
        ({"student": "tamer | stubborn", "announce": True}, "has no intend"),
        ({"student": "tamer(tiles=4)"}, "tiles are for states in a bounded box"),
        ({"student": "tamer", "vary": {"tiles": (0, 4)}}, "tiles are for states in a bounded box"),
        ({"teacher": "noisy"}, "the personality noisy cannot play in arrays; .*; others: TeacherEnv"),
        ({"nonsense": 3}, "nonsense"),
        ({"episodes": 0}, "episodes must be an integer of at least 1, got 0"),
        ({"episodes": 1}, "forget=False is for lifetimes"),
        ({"budget": 0}, "budget must be None or an integer of at least 1, got 0"),
        ({"cost": -1}, "cost must be a finite number"),
        ({"teacher_reward": "nonsense"}, "unknown teacher_reward 'nonsense'"),
        ({"feedback_type": "m"}, "feedback_type 'm' is not supported in arrays"),
        ({"vary": {"beta": (0, 1)}}, "beta"),
        ({"speech": "message"}, "does not use speech from this seat; leave it out"),
        ({"announce": 2}, "announce must be True or False"),
    ],
)
def test_what_arrays_cannot_do_is_refused(change, message):
    with pytest.raises(ValueError, match=message):
        batch_of(GRID, 2, **change)


@pytest.mark.parametrize(
    ("actions", "message"),
    [
        ([0, 1], r"actions must be integers of shape \(3,\), got int64 of shape \(2,\)"),
        ([0, 1, 32], r"action 32 of row 2 is not in Discrete\(32\); nothing has changed"),
        ([0, -1, 1], "action -1 of row 1"),
    ],
)
def test_a_wrong_batch_names_the_row(actions, message):
    batch = batch_of(GRID, 3)
    batch.reset(seed=0)
    with pytest.raises(ValueError, match=message):
        batch.step(np.array(actions))
    assert batch.moments.turn.tolist() == [0, 0, 0]


def test_a_row_that_has_ended_is_named():
    batch = batch_of(GRID, 3, episodes=1, max_turns=1, student="tamer", autoreset_mode=AutoresetMode.DISABLED)
    batch.reset(seed=0)
    for _ in range(2):
        batch.step(np.zeros(3, int))
    batch.reset(options={"reset_mask": np.array([True, False, True])})
    with pytest.raises(ResetNeeded, match="row 1 has ended; call reset"):
        batch.step(np.zeros(3, int))


def test_students_with_a_table_propose_no_points():
    with pytest.raises(ValueError, match=r"in arrays the student q_learning.* needs discrete actions, got Box"):
        batch_of(POINTS[0], 2)


def test_who_believes_about_points_needs_words_in_time():
    with pytest.raises(ValueError, match="obedient needs a teacher that is never late"):
        batch_of(POINTS[0], 2, student="obedient", episodes=1, teacher="delayed")


def test_a_teachers_numbers_are_those_of_the_scalar_environment():
    common = {"student": LEARNER, "episodes": 3, "max_turns": 8, "budget": 4, "announce": True, "teacher_numbers": True}
    batch = gymnasium.make_vec("teacher/gridworld-v0", num_envs=6, pool=4, **common)
    scalar = gymnasium.make("teacher/gridworld-v0", **common)
    seen, infos = batch.reset(seed=1)
    assert (batch.fields, batch.single_observation_space) == (scalar.unwrapped.fields, scalar.observation_space)
    assert [field.name for field in batch.fields] == ["available", "features", "lifetime"]
    lessons, rng = [batch.lesson(row) for row in range(6)], np.random.default_rng(0)
    for _ in range(12):
        actions = rng.integers(batch.single_action_space.n, size=6)
        seen, _, _, _, infos = batch.step(actions)
        steps = [lesson.step(int(action)) for lesson, action in zip(lessons, actions, strict=True)]
        np.testing.assert_array_equal(seen, [observation for observation, *_ in steps])
        np.testing.assert_array_equal(infos["action_mask"], [info["action_mask"] for *_, info in steps])
        np.testing.assert_array_equal(batch.action_masks(), infos["action_mask"].astype(bool))
