"""Teachers that weigh what they say by what a student can know, and teachers that know only a part themselves."""

import copy
import math
import pickle

import numpy as np
import pytest
from scipy.stats import binomtest

import llf_teacher
from llf_teacher.registry import family
from llf_teacher.studies import Study
from pz_envs.subject import Subject
from teachers.atoms import FP, KINDS, HedgedClaim, confidence, unhedged
from teachers.information import DrawnWorld
from teachers.oracles.bandits import Avoid, Pull
from teachers.partial import PartialOracle
from teachers.teacher import Teacher
from worlds.posteriors import NoWorldError
from worlds.posteriors.gridworld import GridworldPosterior

GAUSSIAN = "llf-bandits-BanditTenArmedGaussian-v0"
GRID = "llf-gridworld-v0"
MOVIES = "llf-reco-movie-v0"
ALPHA = 1e-4
OPTIONS = {GRID: {"map": True}}


def lesson(id, teacher, **options):
    return llf_teacher.make(id, teacher=teacher, **OPTIONS.get(id, {}), **options)


def feedback(env):
    return [atom for atom in env.session.atoms if atom.kind is not None]


def play(env, seed, turns, rng=None):
    """Random play; yields at the opening and after each turn."""
    rng = rng or np.random.default_rng(seed)
    env.reset(seed=seed)
    yield env.session.moment
    for _ in range(turns):
        _, _, terminated, truncated, _ = env.step(env.session.world.sample_action(rng))
        yield env.session.moment
        if terminated or truncated:
            return


@pytest.mark.parametrize("bits", [0.2, 1.0, 3.0])
def test_informative_says_the_claim_nearest_to_so_many_bits(bits):
    """By what an audit measures with other draws of the same posterior."""
    env = lesson(GAUSSIAN, f"informative(bits={bits})")
    off = []
    for seed in range(2):
        information = env.family.make_information(env.session.world, seed)
        for moment in play(env, seed, 3):
            information.see(moment)
            oracle = env.teacher.oracle
            instruction = [atom for atom in env.session.atoms if atom.kind is None]
            information.hear(instruction)
            (said,) = feedback(env)
            others = [*oracle.judge(moment, KINDS), *oracle.clues(moment.after)]
            assert said.claim in others
            mine = information.weigh(said).bits
            nearest = min(
                (information.weigh(said._replace(claim=each)).bits for each in others), key=lambda b: abs(b - bits)
            )
            off.append(abs(mine - bits) - abs(nearest - bits))
            information.hear([said])
    assert np.mean(off) < 0.1  # the bits of 256 worlds vary
    assert np.median(off) < 0.02


def test_efficient_says_what_saves_most_per_word():
    env = lesson(GAUSSIAN, "efficient")
    env.reset(seed=0)
    (said,) = feedback(env)
    words = env.teacher.voice.words
    information = env.family.make_information(env.session.world, 0, 2000)
    information.see(env.session.moment)
    oracle, moment = env.teacher.oracle, env.session.moment
    worth = {
        claim: information.weigh(said._replace(claim=claim)).saved / words(claim)
        for claim in (*oracle.judge(moment), *oracle.clues(moment.after))
    }
    assert worth[said.claim] > 0.8 * max(worth.values()) > 0
    assert type(said.claim) is Pull


@pytest.mark.parametrize("teacher", ["informative", "efficient"])
def test_nothing_is_said_that_the_student_knows(teacher):
    env = lesson("llf-bandits-BanditTwoArmedDeterministicFixed-v0", f"only(kinds='fp') | {teacher}")
    moments = play(env, 3, 6)
    next(moments)
    said = feedback(env)
    assert len(said) <= 1
    for _ in moments:
        said += feedback(env)
    assert len(said) == 1  # of two arms, that one is the best says all


def test_it_knows_what_the_student_hears_from_others():
    """Of two teachers, the second knows what the first has said, and what is false it cannot know."""
    raw = family("bandits").raw_env(
        seating="panel", teachers=("only(kinds='fp')", "informative"), speech="message", problem="TenArmedGaussian"
    )
    raw.reset(seed=0)
    for _ in raw.agent_iter():
        _, _, over, cut, info = raw.last()
        raw.step(None if over or cut else info.get("suggestion", 0))
        if raw.session.moment.turn == 1 and raw.session.heard:
            break
    first, second = (raw.session.teacher_turns[i].said.atoms for i in (0, 1))
    assert [atom.kind for atom in first] == [FP]
    claims = [atom.claim for atom in second if atom.kind is not None]
    assert not [claim for claim in claims if isinstance(claim, Avoid | Pull)]  # these the student can conclude


@pytest.mark.parametrize("teacher", ["informative(worlds=16)", "partial", "partial(sees='walk') | timid"])
def test_a_lesson_can_be_copied_in_the_middle(teacher):
    env = lesson(GAUSSIAN, teacher, ask_cost=0.1)
    for _ in play(env, 0, 3):
        pass
    twins = [copy.deepcopy(env), pickle.loads(pickle.dumps(env))]
    said = []
    for each in (env, *twins):
        each.step(3)
        said.append(each.session.atoms)
        each.step(4)
        said[-1] += each.session.atoms
    assert said[0] == said[1] == said[2]


@pytest.mark.parametrize(
    ("id", "sees"),
    [
        *((id, sees) for id in (GRID, MOVIES) for sees in ("student", "rewards", "walk")),
        (GAUSSIAN, "student"),
        (GAUSSIAN, "rewards"),
    ],
)
def test_a_partial_teacher_says_the_same_in_any_world_that_agrees_with_its_evidence(id, sees):
    turns = 3
    env = lesson(id, f"partial(sees={sees!r}, steps=1, worlds=8)")
    session, changed = env.session, 0
    for seed in range(2):
        moments = list(play(env, seed, turns))
        session.open(seed)
        said = _watched(session, moments)
        known = session.teacher._stage._stages[0]._witness.information
        for draw, _ in known.possible()[:8]:
            changed += draw[0].truth != moments[0].after
            other = DrawnWorld(draw, moments)
            session.open(seed)
            assert _watched(session, [other.moment(turn) for turn in range(len(moments))]) == said
    assert changed


def _watched(session, moments):
    """What is said of these moments."""
    said = []
    for moment in moments:
        session.follow(moment)
        session.speak()
        said.append(session.atoms)
    return said


def hedges(teacher, id, lessons, rng, turns=3):
    """One hedge of each lesson: its probability, and whether it holds."""
    env = lesson(id, teacher)
    found = []
    for seed in rng.integers(2**31, size=lessons).tolist():
        said = [(moment, atom.claim) for moment in play(env, seed, turns, rng) for atom in feedback(env)]
        said = [(moment, claim) for moment, claim in said if isinstance(claim, HedgedClaim)]
        if said:
            moment, claim = said[rng.integers(len(said))]
            found.append((claim.p, claim.holds(moment, env.session.world.scratch())))
    return found


def calibration(found):
    """Least p-value, by a binomial test, of as many hedges that hold among those of similar probability."""
    ps = []
    for low in (0.5, 0.6, 0.7, 0.8, 0.9):
        some = [(p, held) for p, held in found if low <= p < low + 0.1]
        if some:
            ps.append(binomtest(sum(held for _, held in some), len(some), np.mean([p for p, _ in some])).pvalue)
    return min(ps)


@pytest.mark.parametrize(
    ("id", "sees", "lessons"),
    [
        (GRID, "student", 200),
        (GRID, "walk", 200),
        pytest.param(GAUSSIAN, "rewards", 80, marks=pytest.mark.full),
        pytest.param(GAUSSIAN, "walk", 60, marks=pytest.mark.full),
    ],
)
def test_its_hedges_are_calibrated(id, sees, lessons, rng):
    found = hedges(f"partial(sees={sees!r}, worlds=64)", id, lessons, rng)
    assert len(found) > lessons / 3
    assert calibration(found) > ALPHA


def test_bent_hedges_are_not_calibrated(rng):
    """The same hedges, said with more or less confidence."""
    for bend in ("overconfident", "timid"):
        assert calibration(hedges(f"partial | {bend}(by=20)", GRID, 1000, rng, turns=0)) < ALPHA


def test_what_it_says_flatly_is_true_where_worlds_are_listed():
    env = lesson(GRID, "partial(sees='walk')")
    lab, flat = env.session.world.scratch(), 0
    for seed in range(50):
        for moment in play(env, seed, 5):
            for atom in feedback(env):
                if confidence(atom.claim) == 1:
                    assert atom.claim.holds(moment, lab)
                    flat += 1
    assert flat > 500


def test_a_walk_shows_more_than_the_student_has_seen():
    def probabilities(sees):
        env = lesson(GRID, f"partial(sees={sees!r}, steps=30)", feedback_type="fp")
        return [
            max((confidence(atom.claim) for atom in feedback(env)), default=0.0)
            for seed in range(60)
            for _ in play(env, seed, 0)
        ]

    assert np.mean(probabilities("walk")) > np.mean(probabilities("student")) + 0.02


def test_listed_worlds_have_the_probabilities_with_which_they_are_drawn():
    for name, options in (("gridworld", {"map": True}), ("movies", {})):
        world = family(name).make_world(**options)
        world.reset(seed=1)
        env = lesson(GRID if name == "gridworld" else MOVIES, "partial")
        moment = next(play(env, 1, 0))
        context = env.teacher.posterior_context
        oracle = PartialOracle(context, np.random.default_rng(0))
        oracle.see(moment)
        listed = {draw[0].truth: share for draw, share in oracle.possible()}
        assert math.fsum(listed.values()) == pytest.approx(1)
        assert moment.after in listed
        drawn = context.posterior.take(oracle._turns, np.random.default_rng(0), 2000)
        truth, share = max(listed.items(), key=lambda each: each[1])
        assert binomtest(sum(each[0].truth == truth for each in drawn), 2000, share).pvalue > ALPHA


def test_posteriors_draw_worlds_that_agree_with_two_histories():
    env = lesson(GRID, "partial")
    env.reset(seed=4)
    posterior = env.teacher.posterior_context.posterior
    one, other = (
        PartialOracle(env.teacher.posterior_context, np.random.default_rng(i), sees="walk", steps=12) for i in (0, 1)
    )
    moment = env.session.moment
    one.see(moment)
    other.see(moment)
    mine, theirs = one._walk, other._walk
    been = {turn.truth.room for turn in (*mine, *theirs)}
    drawn = posterior.take(mine, np.random.default_rng(0), 500, theirs)
    treasure = moment.after.layout.treasure
    assert all((each[0].truth.layout.treasure in been) == (treasure in been) for each in drawn)
    assert {each[0].truth for each in drawn} == {each[0].truth for each, _ in posterior.every(mine, theirs)}


def test_where_no_world_can_be_found_it_is_silent(monkeypatch):
    env = lesson(GAUSSIAN, "partial")

    def none(*_):
        raise NoWorldError("none")
        yield

    monkeypatch.setattr(env.teacher.posterior_context.posterior, "openings", none)
    env.reset(seed=0)
    assert not feedback(env)


def test_a_family_or_a_world_without_a_posterior_refuses(monkeypatch):
    with pytest.raises(ValueError, match=r"informative needs a posterior: .*option map=True; elsewhere use another"):
        llf_teacher.make(GRID, teacher="informative")
    with pytest.raises(ValueError, match="families with one: bandits, gridworld, movies"):
        llf_teacher.make("llf-poem-Haiku-v0", teacher="partial | vague")
    with monkeypatch.context() as patched:
        patched.setattr(GridworldPosterior, "exact", False)
        with pytest.raises(ValueError, match="needs exact posterior of the oracle, which GridworldOracle"):
            lesson(GRID, "partial(sees='walk')")
    plain = llf_teacher.make(GAUSSIAN).teacher
    with pytest.raises(ValueError, match="needs posterior of the oracle, which BanditOracle does not give"):
        Teacher(plain.oracle, plain.voice, "informative")
    with pytest.raises(ValueError, match=r"unknown evidence 'everything'; .*allowed: student, rewards, walk"):
        llf_teacher.make(GAUSSIAN, teacher="partial(sees='everything')")
    with pytest.raises(ValueError, match="unknown evidence 'all'"):
        PartialOracle(lesson(GAUSSIAN, "partial").teacher.posterior_context, np.random.default_rng(0), sees="all")
    assert Subject.posterior_abilities == frozenset()


def test_a_study_says_which_options_are_missing():
    given = {"teachers": ["informative"], "students": ["random"], "seeds": 1}
    with pytest.raises(
        ValueError, match=r"cannot have 'informative'(?s:.*)\[options.\"llf-gridworld-v0\"\]\nmap = true"
    ):
        Study(ids=[GRID], **given)
    assert Study(ids=[GRID], options={GRID: {"map": True}}, **given).teachers == ("informative",)


def test_the_hedge_hides_no_claim():
    env = lesson(GRID, "partial")
    env.reset(seed=2)
    assert all(unhedged(atom.claim).kind is atom.kind for atom in feedback(env))
