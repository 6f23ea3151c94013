"""Thousands of lessons at once: rows of arrays are the scalar environments, whatever is played."""

import copy
import pickle

import gymnasium
import numpy as np
import pytest
from design import sampled
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

import llf_teacher
from llf_teacher.registry import PREFIX, entries
from pz_envs.family import all_families
from pz_envs.teacher_view import SUBSET_BITS
from teachers.atoms import FN, FP, KINDS, ActionClaim
from teachers.personalities.early import Advising, Early
from teachers.personality import PERSONALITIES, parse_personality, stages_of
from teachers.seeds import streams_beside
from worlds.batches.gridworld import GridworldBatch, _pool_of
from worlds.batches.streams import Stream, Streams
from worlds.gridworld import Gridworld
from worlds.testing import plain

BATCHED = [family for family in all_families() if family.world_batch]
IDS = [PREFIX + name for family in BATCHED for name in family.showcase]
FIRST = [(PREFIX + family.showcase[0], family) for family in BATCHED]
EVERY = [id for id, entry in entries().items() if entry.family.world_batch]
GRID, GAUSSIAN = "llf-gridworld-v0", "llf-bandits-BanditTenArmedGaussian-v0"
SMALL = {GRID: {"pool": 8}}  # a pool takes a while to make


def batch_of(id, rows, **options):
    return gymnasium.make_vec(
        id, num_envs=rows, vectorization_mode="vector_entry_point", **{**SMALL.get(id, {}), **options}
    )


def row_of(observed, row):
    return {name: row_of(part, row) for name, part in observed.items()} if isinstance(observed, dict) else observed[row]


def actions_of(batch, rng):
    """Random actions of the world, and in every second row what is advised."""
    world = batch.worlds.world
    return np.array([world.sample_action(rng) for _ in range(batch.num_envs)])


def close(one, other):
    """Equal but for what functions of NumPy and of `math` round differently."""
    np.testing.assert_allclose(np.asarray(one, float), np.asarray(other, float), rtol=1e-9, atol=1e-12)


def check_said(batch, seen, observation, atoms):
    """A row's numbers say what a scalar environment observes and what its atoms claim."""
    np.testing.assert_equal(type(seen["observation"]) is dict, type(observation["observation"]) is dict)
    pairs = [(seen["observation"], observation["observation"])]
    if isinstance(seen["observation"], dict):
        pairs = [(seen["observation"][name], part) for name, part in observation["observation"].items()]
    for one, other in pairs:
        close(one, other)
    said = [atom for atom in atoms if atom.kind is not None]
    assert seen["said"].tolist() == [int(any(atom.kind is kind for atom in said)) for kind in KINDS]
    told = [atom.claim.reward for atom in said if atom.kind == "r"]
    close(seen["told"], told[0] if told else 0.0)
    for name, kind in (("advised", FP), ("warned", FN)):
        about = [atom.claim.action for atom in said if atom.kind is kind and isinstance(atom.claim, ActionClaim)]
        close(seen[name], about[0] if about else batch._nothing)


def check_lessons(id, rows, seed, turns, own_options, mode, **settings):
    """Play rows, and lessons that begin at any of their turns, by the same actions; how many episodes were compared."""
    rng = np.random.default_rng(seed)
    entry = entries()[id]
    options = {} if own_options else entry.family.make_world(**entry.options).draw_options(rng)
    batch = batch_of(id, rows, **options, max_turns=turns, autoreset_mode=mode, **settings)
    seen, _ = batch.reset(seed=seed)
    lessons, episodes = {}, 0
    for turn in range(2 * turns + 3):
        for row in range(rows):
            if row not in lessons and not batch._done[row] and (turn < 2 or rng.random() < 0.5):
                lessons[row] = lesson = batch.lesson(row)
                now = {"observation": lesson.student_view.state()}
                check_said(batch, row_of(seen, row), now, lesson.session.atoms)
        actions = actions_of(batch, rng)
        follows = rng.random(rows) < 0.5
        for row in np.flatnonzero(follows & (seen["said"][:, 3] == 1)).tolist():
            actions[row] = seen["advised"][row]
        seen, rewards, terminated, truncated, infos = batch.step(actions)
        for row, lesson in list(lessons.items()):
            observation, reward, *ends, info = lesson.step(actions[row].tolist())
            close(rewards[row], reward)
            over = bool(terminated[row]), bool(truncated[row])
            assert over == tuple(ends)
            final = any(ends) and mode is AutoresetMode.SAME_STEP
            last = infos["final_obs"][row] if final else row_of(seen, row)
            success = infos["final_info"] if final else infos
            check_said(batch, last, observation, info["atoms"])
            assert success["success"][row] == info["success"]
            if any(ends):
                del lessons[row]
                episodes += 1
    return episodes


TEACHERS = (
    "oracle",
    "silent | early",
    "early(budget=2)",
    "only(kinds='hp+fp') | early(budget=3)",
    "importance(budget=9, threshold=0.3)",
    "delayed(turns=1)",
    "delayed(turns=1) | early(budget=2) | delayed(turns=2)",
    "oracle | delayed(turns=30)",
    "skip(eps=0.6)",
    "skip(eps=0.9) | delayed(turns=1)",
)
"""Personalities with a form in arrays."""


def teachers_of(family):
    """Those that the oracle of a family serves."""
    able = family.oracle_class().abilities()
    return [spec for spec in TEACHERS if parse_personality(spec).needs <= able]


PLAYS = {
    "seed": st.integers(0, 2**31),
    "turns": st.integers(1, 8),
    "own_options": st.booleans(),
    "mode": st.sampled_from([AutoresetMode.SAME_STEP, AutoresetMode.NEXT_STEP]),
    "until_success": st.booleans(),
    "feedback_type": st.sampled_from(["a", "a", "n", "hp+hn", "r+fp", "fn"]),
}


def plays(family):
    """The arguments of `check_lessons`."""
    return st.fixed_dictionaries({**PLAYS, "teacher": st.sampled_from(teachers_of(family))})


@pytest.mark.parametrize("id", IDS)
@settings(max_examples=3, deadline=None, derandomize=True)
@given(play=st.fixed_dictionaries(PLAYS))
def test_lessons_go_on_as_their_rows(id, play):
    """What is observed, paid and said, and when it ends; from any turn on, after seeds and after autoresets."""
    check_lessons(id, 6, **play)


@sampled(lambda id, teacher: {id, teacher})
@pytest.mark.parametrize(("id", "teacher"), [(id, spec) for id, family in FIRST for spec in teachers_of(family)])
def test_lessons_of_every_personality_go_on_as_their_rows(id, teacher):
    modes = [AutoresetMode.SAME_STEP, AutoresetMode.NEXT_STEP]
    for seed, mode in enumerate(modes):
        assert check_lessons(id, 6, seed, 7, True, mode, teacher=teacher, until_success=mode is modes[0]) > 0


@pytest.mark.parametrize("id", IDS)
def test_numbers_of_late_claims_are_those_of_the_scalar_game(id):
    batch, rng = batch_of(id, 4, numbers=True, max_turns=5, teacher="delayed(turns=2)"), np.random.default_rng(0)
    batch.reset(seed=0)
    for _ in range(14):
        seen, *_ = batch.step(actions_of(batch, rng))
        np.testing.assert_allclose(seen, [batch.lesson(row).observe() for row in range(4)], rtol=1e-6)


def test_every_personality_that_arrays_have_is_tested():
    named = {stage.name for spec in TEACHERS for stage in stages_of(parse_personality(spec))}
    assert named == {name for name in PERSONALITIES.names if PERSONALITIES[name].in_arrays()}
    assert named == {"delayed", "early", "importance", "only", "oracle", "silent", "skip"}


def test_a_personality_that_speaks_otherwise_has_not_the_arrays_of_its_base():
    class Late(Early):
        stage = type("Stage", (Advising,), {"wants": lambda self, view: view.turn > 3})

    assert Early.in_arrays()
    with pytest.raises(ValueError, match=r"the personality Late cannot play in arrays; allowed: delayed, early"):
        batch_of(GRID, 2, teacher=Late())


@pytest.mark.full
@pytest.mark.parametrize("id", EVERY)
def test_thousands_of_lessons_go_on_as_their_rows(id):
    episodes = 0

    @settings(max_examples=40, deadline=None)
    @given(play=plays(entries()[id].family))
    def check(play):
        nonlocal episodes
        episodes += check_lessons(id, 40, **play)

    check()
    assert episodes > 2000


@pytest.mark.parametrize("id", EVERY)
def test_seeded_starts_are_the_scalar_ones(id):
    batch = batch_of(id, 8)
    seen, _ = batch.reset(seed=5)
    assert batch.observation_space.contains(seen)
    for row in range(8):
        env = llf_teacher.make(id)
        observation, info = env.reset(seed=5 + row)
        check_said(batch, row_of(seen, row), observation, info["atoms"])
        assert batch.moment(row).after == env.session.moment.after


@pytest.mark.parametrize("seed", [True, False])
def test_truth_values_are_the_seeds_that_they_are_in_the_scalar_game(seed):
    """Gymnasium takes a bool for an integer."""
    batch, env = batch_of(GRID, 1), llf_teacher.make(GRID)
    batch.reset(seed=seed)
    for again in (seed, int(seed)):
        env.reset(seed=again)
        assert env.moment == batch.moment(0)


@pytest.mark.parametrize("id", IDS)
def test_a_seed_repeats_everything(id):
    def play(seed):
        batch, rng = batch_of(id, 6, max_turns=3), np.random.default_rng(0)
        found = [batch.reset(seed=seed)]
        found += [batch.step(actions_of(batch, rng)) for _ in range(10)]
        return plain(found)

    assert play([4, 5, 6, 7, 8, 9]) == play(4) != play(5)


@pytest.mark.parametrize("id", IDS)
@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_what_follows_an_end_is_as_in_gymnasium(id, mode):
    ours = batch_of(id, 3, max_turns=2, autoreset_mode=mode)
    theirs = gymnasium.make_vec(
        id, num_envs=3, vectorization_mode="sync", vector_kwargs={"autoreset_mode": mode}, max_turns=2
    )
    assert ours.metadata["autoreset_mode"] is theirs.metadata["autoreset_mode"] is mode
    ours.reset(seed=0)
    theirs.reset(seed=0)
    rng = np.random.default_rng(0)
    for _ in range(7):
        actions = actions_of(ours, rng)
        mine, other = ours.step(actions), theirs.step(actions)
        assert plain(mine[2:4]) == plain(other[2:4])
        final = [name for name in other[4] if "final" in name]
        assert sorted(final) == sorted(name for name in mine[4] if "final" in name)
        if final:
            assert plain(mine[4]["_final_obs"]) == plain(other[4]["_final_obs"])
            assert type(mine[4]["final_obs"]) is type(other[4]["final_obs"])
        opened = mine[0]["said"][:, 0] == 0  # nothing has been paid yet
        assert opened.tolist() == [text != "" for text in other[0]["instruction"]]
        if mode is AutoresetMode.NEXT_STEP:
            assert not mine[1][opened].any()


def test_rows_are_reset_by_hand():
    batch = batch_of(GRID, 4, max_turns=2, autoreset_mode=AutoresetMode.DISABLED)
    with pytest.raises(ResetNeeded, match="no episode has begun; call reset"):
        batch.step(np.zeros(4, int))
    with pytest.raises(ResetNeeded, match="the first reset must be of all rows; call reset"):
        batch.reset(options={"reset_mask": np.array([True, False, False, False])})
    batch.reset(seed=0)
    batch.step(np.zeros(4, int))
    before = [batch.moment(row) for row in range(4)]
    batch.reset(seed=9, options={"reset_mask": np.array([False, True, False, True])})
    after = [batch.moment(row) for row in range(4)]
    assert after[0] == before[0]
    assert after[2] == before[2]
    env = llf_teacher.make(GRID)
    for row in (1, 3):
        env.reset(seed=9 + row)
        assert after[row].after == env.session.moment.after
    batch.step(np.zeros(4, int))
    with pytest.raises(ResetNeeded, match="row 0 has ended"):
        batch.step(np.zeros(4, int))
    with pytest.raises(ValueError, match="reset_mask must be a bool array"):
        batch.reset(options={"reset_mask": [True]})


@pytest.mark.parametrize(
    ("seed", "mask", "what"),
    [
        ([0, -1, 0], [True, True, False], "the seed of row 1 must be None or an integer of at least 0, got -1"),
        ([0, 1, 2.5], [True, True, False], r"the seed of row 2 must be .*, got 2\.5"),
        (-2, [True] * 3, "the seed of row 0 must be .*, got -2"),
        ([1, 2], [True] * 3, "seed must be None, an integer or a list of 3 of these"),
        (1.5, [True] * 3, "seed must be None, an integer or a list of 3 of these"),
        ([5, 6, 7], [False] * 3, "reset_mask must be a bool array"),
        ([5, 6, 7], [True] * 2, "reset_mask must be a bool array"),
    ],
)
@pytest.mark.parametrize("id", IDS)
@pytest.mark.parametrize("seat", ["student", "teacher"])
def test_a_reset_that_is_refused_changes_nothing(seat, id, seed, mask, what):
    learner = {"student": "obedient"} if "optimization" in id else {}
    if seat == "student":
        batch = batch_of(id, 3)
    else:
        batch = llf_teacher.TeacherVectorEnv(id, 3, **SMALL.get(id, {}), **learner)
    space = batch.action_space
    space.seed(0)
    batch.reset(seed=0)
    twin = copy.deepcopy(batch)
    with pytest.raises(ValueError, match=what):
        batch.reset(seed=seed, options={"reset_mask": np.array(mask)})
    for _ in range(3):
        actions = space.sample()
        assert plain(batch.step(actions)) == plain(twin.step(actions))
    assert plain(batch.reset()) == plain(twin.reset())


def test_a_first_reset_of_some_rows_changes_nothing():
    batch, twin = batch_of(GAUSSIAN, 3), batch_of(GAUSSIAN, 3)
    with pytest.raises(ResetNeeded, match="the first reset must be of all rows"):
        batch.reset(seed=1, options={"reset_mask": np.array([True, False, False])})
    with pytest.raises(ResetNeeded, match="no episode has begun"):
        batch.step(np.zeros(3, int))
    assert plain(batch.reset(seed=2)) == plain(twin.reset(seed=2))


def test_seeds_may_be_an_array():
    one, other = batch_of(GAUSSIAN, 3), batch_of(GAUSSIAN, 3)
    assert plain(one.reset(seed=np.array([4, 5, 6]))) == plain(other.reset(seed=4))
    actions = np.zeros(3, int)
    assert plain(one.step(actions)) == plain(other.step(actions))


@pytest.mark.parametrize("id", IDS)
def test_words_are_those_of_the_lesson(id):
    batch, rng = batch_of(id, 5, paraphrase=0), np.random.default_rng(1)
    batch.reset(seed=3)
    for turn in range(4):
        words = batch.words([4, 1])
        for row, said in zip((4, 1), words, strict=True):
            lesson = batch.lesson(row)
            atoms = lesson.session.atoms
            assert [atom.text for atom in said.atoms] == [atom.text for atom in atoms]
            assert any(atom.kind is None for atom in atoms) == (turn == 0)
        batch.step(actions_of(batch, rng))


def starts(id, batch, rows):
    """Numbers that tell much of a start: a distance, or what the best action is worth, per row."""
    return [batch.oracle.oracle.importance(truth) for truth in started(batch, rows)]


def started(batch, rows):
    for row in range(rows):
        truth = batch.moment(row).after
        batch.oracle.oracle.start(truth)
        yield truth


@pytest.mark.parametrize("id", IDS)
@pytest.mark.parametrize("options", [{}, {"pool": 0}], ids=str)
def test_autoresets_draw_as_resets_do(id, options):
    """Two samples of starts, one of seeds and one of autoresets, are of one distribution."""
    if options and "pool" not in entries()[id].family.batch_options():
        options = {}
    rows = 600
    batch = batch_of(id, rows, max_turns=1, **{"pool": 2000, **options} if id == GRID else {})
    batch.reset(seed=0)
    seeded = starts(id, batch, rows)
    tabular = batch.worlds.states is not None
    before = batch.oracle.plan_length(batch.worlds.state, 20) if tabular else None
    rng = np.random.default_rng(0)
    batch.step(actions_of(batch, rng))
    batch.step(actions_of(batch, rng))
    assert not batch.moments.turn.any()
    assert stats.ks_2samp(seeded, starts(id, batch, rows), method="asymp").pvalue > 0.001
    if tabular:
        ways = batch.oracle.plan_length(batch.worlds.state, 20)
        assert stats.ks_2samp(before, ways, method="asymp").pvalue > 0.001


def test_rows_draw_by_themselves():
    """A row's numbers are its own, uniform, and those of its stream alone; whoever else draws."""
    all_rows = Streams(np.arange(4, dtype=np.uint64))
    alone = [all_rows.stream(row) for row in range(4)]
    some, counts = np.array([1, 3]), np.array([5, 7])
    drawn = [all_rows.random().tolist(), all_rows.random(some).tolist(), all_rows.standard_normal(some).tolist()]
    drawn.append(all_rows.integers(counts, some).tolist())
    assert drawn[0] == [stream.random() for stream in alone]
    assert drawn[1] == [alone[row].random() for row in some]
    assert drawn[2] == pytest.approx([alone[row].standard_normal() for row in some])
    assert drawn[3] == [alone[row].integers(count) for row, count in zip(some, counts, strict=True)]
    assert all_rows.permutations(5, some).tolist() == [alone[row].permutation(5).tolist() for row in some]
    beside = [Streams(all_rows.beside(number)).random().tolist() for number in range(2)]
    assert np.transpose(beside).tolist() == [[other.random() for other in streams_beside(one, 2)] for one in alone]
    many = Streams(np.arange(20_000, dtype=np.uint64))
    drawn = [Streams(many.beside(number)).random() for number in range(2)] + [Streams(many.states).random()]
    assert np.abs(np.corrcoef(drawn) - np.eye(3)).max() < 0.03
    assert stats.chisquare(np.unique(many.permutations(3) @ [9, 3, 1], return_counts=True)[1]).pvalue > 0.001
    many.random()
    assert stats.kstest(many.random(), "uniform").pvalue > 0.001
    assert stats.kstest(many.standard_normal(), "norm").pvalue > 0.001


@pytest.mark.parametrize("again", [copy.deepcopy, lambda stream: pickle.loads(pickle.dumps(stream))])
def test_a_stream_can_be_copied(again):
    stream = Stream(np.array([7], np.uint64))
    stream.random()
    twin = again(stream)
    assert [stream.random(), stream.random(2).tolist()] == [twin.random(), twin.random(2).tolist()]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"teacher": "early | mistake(eps=1)"},
            r"the personality mistake\(eps=1\) cannot play in arrays; allowed: delayed, early, importance, only, "
            r"oracle, silent, skip; others: vectorization_mode='sync'",
        ),
        ({"teacher": "early(turns=3)"}, "unknown parameter 'turns'; .*allowed: budget"),
        ({"teacher": object()}, "in arrays teacher must be a spec string or a Personality, got <object"),
        ({"feedback_type": "m"}, "feedback_type 'm' is not supported in arrays"),
        (
            {"text": True},
            r"in arrays .*'sync' takes more.* does not use text from this seat; leave it out",
        ),
        ({"pool": -1}, "pool must be an integer from 0"),
        ({"autoreset_mode": "next"}, "unknown autoreset_mode 'next'; .*NextStep"),
        ({"max_turns": 0}, r"max_turns \(or max_cycles\) must be an integer of at least 1, got 0"),
        ({"until_success": 1}, "until_success must be True or False"),
        ({"num_rooms": 1}, "num_rooms must be an integer from 2"),
    ],
)
def test_what_arrays_cannot_do_is_refused(change, message):
    with pytest.raises(ValueError, match=message):
        batch_of(GRID, 2, **change)


def test_other_families_are_refused():
    other = next(id for id, entry in entries().items() if not entry.family.world_batch)
    with pytest.raises(gymnasium.error.Error, match="doesn't have a vector entry point"):
        batch_of(other, 2)
    with pytest.raises(ValueError, match=r"cannot be played in arrays; allowed: bandits, gridworld, optimization"):
        llf_teacher.gym.vector.StudentVectorEnv(other, 2)


@pytest.mark.parametrize(
    ("actions", "message"),
    [
        ([0, 1], r"actions must be integers of shape \(3,\), got int64 of shape \(2,\)"),
        ([0.0, 1.0, 2.0], "got float64"),
        ([0, 4, 0], r"action 4 of row 1 is not in Discrete\(4\); nothing has changed"),
    ],
)
def test_bad_actions_change_nothing(actions, message):
    batch = batch_of(GRID, 3)
    batch.reset(seed=0)
    with pytest.raises(ValueError, match=message):
        batch.step(np.array(actions))
    assert batch.moments.turn.tolist() == [0, 0, 0]
    with pytest.raises(ValueError, match="a row must be an integer from 0 to 2, got 3"):
        batch.lesson(3)
    with pytest.raises(ValueError, match="reset option 'nonsense' is unknown"):
        batch.reset(options={"nonsense": 3})
    for seed in ([1, 2], [0, -1, 2], [0, 1.5, 2], "abc", 1.5, -1):
        with pytest.raises(ValueError, match=r"seed(?: of row [012])? must be None(?:,| or) an integer .*, got"):
            batch.reset(seed=seed)


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_gymnasiums_wrappers_take_it(mode):
    batch = gymnasium.wrappers.vector.RecordEpisodeStatistics(batch_of(GRID, 4, max_turns=3, autoreset_mode=mode))
    batch.reset(seed=0)
    for turn in range(1, 4):
        *_, infos = batch.step(np.zeros(4, int))
        assert ("episode" in infos) == (turn == 3)
    assert infos["episode"]["l"].tolist() == [3] * 4


def test_a_loss_of_ones_own_has_no_arrays():
    with pytest.raises(ValueError, match="loss in arrays must be a named one, got a function"):
        batch_of("llf-optimization-Booth-v0", 2, loss=lambda x1, x2: x1**2 + x2**2, domain=(-1.0, 1.0))


def test_what_is_seen_stays_as_it_was():
    batch = batch_of(GRID, 50)
    batch.reset(seed=0)
    seen = batch.step(np.zeros(50, int))[0]
    kept = plain(seen)
    batch.step(np.ones(50, int))
    assert plain(seen) == kept
    assert SUBSET_BITS[0].sum() == 0  # nothing is written into shared tables


def test_equal_options_share_a_pool():
    """It is drawn once for them, whatever the seed and the number of rows."""

    def houses(rows, **options):
        batch = GridworldBatch(Gridworld(**options), rows, pool=5)
        batch.draw(np.arange(rows), np.random.default_rng(rows))
        return plain(tuple(table[rows * batch.states :] for table in batch.houses))

    _pool_of.cache_clear()
    assert houses(2) == houses(3)
    assert houses(2) != houses(2, num_rooms=19) != houses(2, num_rooms=19, town=1)
    assert _pool_of.cache_info().misses == 3


@pytest.mark.parametrize("id", IDS)
@settings(max_examples=3, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**31), feedback_type=st.sampled_from(["a", "r+hn", "fp", "hp+fn"]), turns=st.integers(1, 7))
def test_numbers_are_those_of_the_scalar_environment(id, seed, feedback_type, turns):
    """To the last bit, from a reset on and from any row on."""
    common = {"numbers": True, "feedback_type": feedback_type, "max_turns": turns}
    batch, rows = batch_of(id, 8, **common), range(8)
    scalars = [llf_teacher.make(id, **common) for _ in rows]
    assert batch.fields == scalars[0].fields
    assert batch.single_observation_space == scalars[0].observation_space
    seen, _ = batch.reset(seed=seed)
    np.testing.assert_array_equal(seen, [env.reset(seed=seed + row)[0] for row, env in enumerate(scalars)])
    lessons, rng = [batch.lesson(row) for row in rows], np.random.default_rng(seed)
    for _ in range(turns):
        actions = actions_of(batch, rng)
        seen, *_ = batch.step(actions)
        expected = [lesson.step(action.tolist())[0] for lesson, action in zip(lessons, actions, strict=True)]
        np.testing.assert_array_equal(seen, expected)
        assert batch.single_observation_space.contains(seen[0])


@pytest.mark.parametrize("mode", ["sync", "vector_entry_point"])
@pytest.mark.parametrize("id", [GRID, "teacher/gridworld-v0"])
def test_every_mode_renders_as_gymnasiums_vectors_do(id, mode):
    options = {"pool": 4} if mode != "sync" else {}
    for render_mode, kind in (("ansi", str), ("rgb_array", np.ndarray)):
        envs = gymnasium.make_vec(id, num_envs=2, vectorization_mode=mode, render_mode=render_mode, **options)
        envs.reset(seed=0)
        frames = envs.render()
        assert (len(frames), envs.render_mode) == (2, render_mode)
        assert all(isinstance(frame, kind) for frame in frames)
        assert render_mode in envs.metadata["render_modes"]
        envs.close()


def test_arrays_open_no_windows():
    with pytest.raises(ValueError, match="render_mode 'human' is not supported in arrays; allowed: None, ansi, rgb_"):
        gymnasium.make_vec(GRID, num_envs=2, render_mode="human")
    assert gymnasium.make_vec(GRID, num_envs=2, pool=4).render() is None
