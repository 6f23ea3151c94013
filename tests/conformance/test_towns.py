"""Towns: worlds that share a law, what is said of it, and what a student makes of that in other worlds."""

from functools import partial

import numpy as np
import pytest
from design import sampled
from towns import TOWNS

from llf_teacher import make
from llf_teacher.episodes.loop import play_turns
from llf_teacher.gym import StudentEnv
from llf_teacher.registry import family
from llf_teacher.students.parsing import parse_student
from pz_envs.family import all_families
from pz_envs.testing import check_seats
from teachers import rules
from teachers.atoms import Label, Moment, Scope
from teachers.testing import (
    Pupil,
    check_claims,
    check_clues,
    check_contradictions,
    check_honesty,
    check_scope,
)
from worlds.bandits import FEATURES, Bandit
from worlds.batches.gridworld import GridworldBatch
from worlds.gridworld import Gridworld, kind_of
from worlds.posteriors import seen
from worlds.testing import check_world
from worlds.world import WorldTurn

pytestmark = pytest.mark.filterwarnings("ignore")
HOUSE, ARMS = "llf-gridworld-v0", "llf-bandits-BanditTenArmedRandomFixed-v0"
of_each_family = sampled(lambda entry: {entry.family.name})
FRESH = int(np.random.SeedSequence().generate_state(1)[0])  # another town each time


def made(entry, **options):
    return partial(entry.family.make_world, **entry.options | dict(entry.family.posterior_needs) | options)


def opened(world, seed):
    world.reset(seed=seed)
    return world.truth


def law_of(truth):
    """The law in a truth, wherever the family has it."""
    return getattr(truth, "layout", getattr(truth, "game", truth)).law


def towns_for(entry, count):
    """Fresh towns; one where many houses take long to draw."""
    return range(FRESH, FRESH + (1 if entry.family.name == "alfworld" else count))


def rules_in(entry, towns):
    """Rules that an oracle says, with the moment and the oracle."""
    for town in towns:
        world = made(entry, town=town)()
        moment = Moment.opening(opened(world, town))
        oracle = entry.family.make_teacher(world).oracle
        oracle.start(moment.after)
        for clue in oracle.clues(moment.after):
            if clue.scope is Scope.FAMILY:
                yield clue, moment, oracle


@of_each_family
@pytest.mark.parametrize("entry", TOWNS)
def test_worlds_of_a_town_share_a_law(entry):
    towns = [made(entry, town=town)() for town in range(6)]
    laws = [law_of(opened(world, 0)) for world in towns]
    assert len(set(laws)) > 1
    again = made(entry, town=3)()
    for seed in range(4):
        truth = opened(towns[3], seed)
        assert truth == opened(again, seed)
        assert law_of(truth) == laws[3]
    assert not law_of(opened(made(entry)(), 0))


@sampled(lambda entry, town: {entry.family.name, town})
@pytest.mark.parametrize("entry", TOWNS)
@pytest.mark.parametrize("town", [-1, True, 1.5, "3"])
def test_what_is_no_town_is_refused(entry, town):
    with pytest.raises(ValueError, match=f"town must be None or an integer of at least 0, got {town!r}"):
        made(entry, town=town)()


@of_each_family
@pytest.mark.parametrize("entry", TOWNS)
def test_a_town_is_a_world(entry):
    check_world(made(entry, town=FRESH))


@of_each_family
@pytest.mark.parametrize("entry", TOWNS)
def test_without_its_law_a_world_looks_the_same(entry):
    world = made(entry, town=FRESH)()
    truth = opened(world, 0)
    other = lawless(truth)
    assert law_of(truth) != law_of(other)
    assert seen(world.scratch(), truth) == seen(world.scratch(), other)
    oracle = entry.family.make_teacher(world).oracle
    briefs = []
    for each in (truth, other):
        oracle.start(each)
        briefs.append(oracle.brief(each, "b"))
    assert briefs[0] == briefs[1]


@of_each_family
@pytest.mark.parametrize("entry", [each for each in TOWNS if each.values[0].family.posterior])
def test_the_law_is_not_seen(entry):
    """A drawn world has other laws, and the same observation and instruction."""
    laws = set()
    for town in range(3):
        world = made(entry, town=town)()
        truth = opened(world, town)
        draws = entry.family.make_posterior(world).take([WorldTurn(None, 0.0, truth)], np.random.default_rng(0), 8)
        oracle = entry.family.make_teacher(world).oracle
        for draw in draws:
            other = draw[0].truth
            laws.add(law_of(other))
            assert seen(world.scratch(), truth) == seen(world.scratch(), other)
            oracle.start(other)
            assert oracle.brief(other, "b") == oracle.brief(truth, "b")
    assert len(laws) > 2


@of_each_family
@pytest.mark.parametrize("entry", TOWNS)
def test_what_is_said_in_a_town_is_true(entry):
    few = 15 if entry.family.name in ("alfworld", "movies") else 40
    pupil = Pupil(made(entry, town=FRESH), entry.family.make_teacher, entry.family.max_turns, turns=few)
    for check in (check_honesty, check_clues, check_scope, check_contradictions, check_claims):
        check(pupil)


@of_each_family
@pytest.mark.parametrize("entry", TOWNS)
def test_a_rule_means_what_worlds_of_its_town_show(entry):
    """So does the contrary, but for what these worlds happen to be silent about."""
    said = list(rules_in(entry, towns_for(entry, 8)))
    assert {each.kind for each, *_ in said} <= {"fp", "fn"}
    for rule, moment, oracle in said:
        assert rule.holds(moment, oracle.lab)
        assert rule.means(moment, oracle)
        assert not rule.holds(moment, made(entry)().scratch())  # without a town
        others = rule.counterparts(moment, oracle.lab)
        differ = sum(other.holds(moment, oracle.lab) != other.means(moment, oracle) for other in others)
        assert differ <= (1 if entry.family.name == "alfworld" else 0)
        for other in others:
            assert not (other.excludes(rule) and other.means(moment, oracle))


@of_each_family
@pytest.mark.parametrize("entry", TOWNS)
def test_the_law_is_never_looked_up_to_check_a_rule(entry):
    """A rule holds or not whatever the truth says of the law."""
    for rule, moment, oracle in rules_in(entry, towns_for(entry, 3)):
        for other in (rule, *rule.counterparts(moment, oracle.lab)[:2]):
            shown = [other.fits(truth) for truth in rules._openings(rules._town_of(oracle.lab))[:20]]
            assert shown == [other.fits(lawless(t)) for t in rules._openings(rules._town_of(oracle.lab))[:20]]


def lawless(truth):
    """A truth without its law."""
    for name in ("layout", "game"):
        if hasattr(truth, name):
            return truth._replace(**{name: getattr(truth, name)._replace(law=())})
    return truth._replace(law=())


def lesson(id, teacher, policy, seed, **options):
    """The regret of an episode, and the labels of the rules that were said."""
    env = StudentEnv(id, teacher=teacher, **options)
    policy = policy(env) if callable(policy) else policy
    oracle, lab, regret, labels, moments = env.family.make_teacher(env.session.world).oracle, None, 0.0, [], []
    for turn in play_turns(env, policy, seed):
        lab = lab or env.session.world.scratch()
        moments.append(turn.moment)
        if turn.moment.turn:
            regret += oracle.regret(turn.moment)
        else:
            oracle.start(turn.moment.after)
        labels += [atom.label(moments, lab) for atom in turn.atoms if atom.claim.scope is Scope.FAMILY]
    return regret, labels


@pytest.mark.parametrize("id", [HOUSE, ARMS])
def test_a_teacher_that_errs_gives_false_rules(id):
    for teacher, label in (("ruler", Label.TRUTHFUL), ("ruler | mistake(eps=1)", Label.DISTORTED)):
        student = lambda env: parse_student("random").seat(env.family, env.session.world)  # noqa: E731
        labels = [each for town in range(3) for each in lesson(id, teacher, student, town, town=town, max_turns=5)[1]]
        assert set(labels) == {label}


@pytest.mark.parametrize(("id", "options"), [(HOUSE, {"map": True}), (ARMS, {"max_turns": 5})])
def test_rules_that_were_heard_once_help_in_new_worlds(id, options):
    """A pair of students in each town: one keeps what it heard in one world of it, the other forgets it."""
    less = []
    for town in range(8):
        regrets = []
        for forget in (False, True):
            env = StudentEnv(id, town=town, **options)
            policy = parse_student(f"reasoner(worlds=16, forget={forget})").seat(env.family, env.session.world)
            lesson(id, "ruler", policy, 1000 + town, town=town, **options)
            regrets.append(lesson(id, "silent", policy, 2000 + town, town=town, **options)[0])
        less.append(regrets[1] - regrets[0])
    assert np.mean(less) > 1.96 * np.std(less, ddof=1) / len(less) ** 0.5


def test_forget_is_true_or_false():
    with pytest.raises(ValueError, match="forget must be True or False, got 1"):
        parse_student("reasoner(forget=1)")
    assert parse_student("reasoner(forget=False)").remembers
    assert not parse_student("reasoner").remembers


def test_other_families_refuse_a_town():
    able = "families with the option 'town': alfworld, bandits, gridworld, movies"
    for each in all_families():
        if each.name not in ("alfworld", "bandits", "gridworld", "movies"):
            with pytest.raises(ValueError, match=able):
                each.make_world(town=1)
    with pytest.raises(ValueError, match=f"llf-poem-Haiku-v0 does not take these options.*{able}"):
        make("llf-poem-Haiku-v0", town=1)


def test_arms_that_are_given_have_no_looks():
    with pytest.raises(ValueError, match="'TwoArmedHighLowFixed' has no towns, as its arms are given; allowed: Ten"):
        Bandit("TwoArmedHighLowFixed", town=1)


def test_looks_are_shown_in_words():
    world = Bandit(arms=3, town=1)
    observation, _ = world.reset(seed=0)
    assert world.observation_space.contains(observation)
    words = [" ".join(FEATURES[i][word] for i, word in enumerate(row)) for row in world.truth.looks]
    assert world.describe(observation) == "Arms: " + ", ".join(f"{arm} {each}" for arm, each in enumerate(words))


@pytest.mark.parametrize("problem", ["TenArmedGaussian", "TenArmedRandomRandom"])
def test_all_arms_of_many_towns_pay_as_without_one(problem):
    """Towns only move pay between arms of different looks."""
    drawn = [opened(Bandit(problem, town=town), seed).payouts for town in range(40) for seed in range(5)]
    plain = [opened(Bandit(problem), seed).payouts for seed in range(200)]
    for share in (0.25, 0.5, 0.75):
        assert np.quantile(drawn, share) == pytest.approx(np.quantile(plain, share), abs=0.1)


def test_official_games_have_no_towns(monkeypatch):
    monkeypatch.setattr("worlds.alfworld.world.files", lambda *_: ("game.tw-pddl",))
    monkeypatch.setenv("ALFWORLD_DATA", "somewhere")
    with pytest.raises(ValueError, match="town must be None for official games, got 1; towns need games='generated'"):
        family("alfworld").make_world(town=1)
    world = family("alfworld").make_world(games="generated", town=1)
    with pytest.raises(ValueError, match="'game' must be None in a town"):
        world.reset(options={"game": "game.tw-pddl"})


def test_houses_of_a_town_come_in_arrays():
    world = Gridworld(town=3)
    batch = GridworldBatch(world, 4, pool=20)
    batch.draw(np.arange(4), np.random.default_rng(0))
    for row in range(4):
        layout = batch.truth(batch.state, row).layout
        assert kind_of(layout.names[layout.treasure]) == layout.law == world.law


def test_arms_with_looks_have_no_arrays():
    with pytest.raises(ValueError, match=r"arms with looks.*have no arrays; set vectorization_mode='sync'"):
        family("bandits").make_batch(4, town=1)


@pytest.mark.full
@of_each_family
@pytest.mark.parametrize("entry", TOWNS)
def test_seats_in_towns(entry):
    check_seats(partial(entry.family.env, **entry.options | dict(entry.family.posterior_needs), town=1))
