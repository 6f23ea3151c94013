"""Oracles: values, plans and claims agree with each other and with the world, ties included."""

import sys
from importlib import import_module
from itertools import combinations, islice
from pkgutil import iter_modules
from types import ModuleType

import numpy as np
import pytest
from design import amount
from gymnasium import spaces
from moments import opening
from sampling import fewer

from pz_envs.family import all_families
from pz_envs.text.actions import parse_action
from teachers import common
from teachers.atoms import FN, FP, HN, HP, KINDS, ActionClaim, Claim, Moment, ParseFailure, PlanClaim, R, is_decorated
from teachers.common import Syntax
from teachers.oracle import RefusalError, claims_of
from teachers.testing import Pupil

ENVIRONMENTS = {
    name: (family, dict(options)) for family in all_families() for name, options in family.environments.items()
}
on_every_environment = pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in (family.sampled or (name,)) else pytest.mark.full)
        for name, (family, _) in ENVIRONMENTS.items()
    ],
)
SUBSETS = [frozenset(chosen) for size in range(6) for chosen in combinations(KINDS, size)]


def pupil(name, turns=100):
    family, options = ENVIRONMENTS[name]
    turns = fewer(family, turns)
    return Pupil(lambda: family.make_world(**options), family.make_teacher, max_turns=family.max_turns, turns=turns)


@on_every_environment
def test_values_importance_and_regret_agree(name):
    for oracle, moment in pupil(name).judged():
        values = oracle.values(moment.after)
        assert 0 <= oracle.importance(moment.after) <= oracle.max_importance
        if values is None:
            continue
        assert len(values) == oracle.lab.action_space.n
        assert oracle.importance(moment.after) == pytest.approx(max(values) - min(values))
        if moment.before is not None:
            before = oracle.values(moment.before)
            assert oracle.regret(moment) == pytest.approx(max(before) - before[moment.action])


@on_every_environment
def test_regret_is_zero_exactly_if_the_action_was_good(name):
    """Of continuous actions a good one is better than before, not yet the best."""
    seen = set()
    best = not isinstance(pupil(name).make_world().action_space, spaces.Box)
    for oracle, moment in pupil(name, turns=300).judged():
        if moment.before is None:
            continue
        regret = oracle.regret(moment)
        kinds = {claim.kind for claim in oracle.judge(moment, frozenset((HP, HN)))}
        if HN in kinds:
            assert regret > 0
        elif HP in kinds and best:
            assert regret == pytest.approx(0)
        seen |= kinds
    assert HN in seen


@on_every_environment
def test_a_turn_without_an_action_loses_what_is_lost_where_nothing_moves(name):
    world = pupil(name).make_world()
    world.reset(seed=0)
    oracle = ENVIRONMENTS[name][0].make_teacher(world).oracle
    oracle.start(world.truth)
    failure = Moment(None, ParseFailure("?", ""), world.failure_reward, world.truth, False, 1, False)
    try:
        lost, idle = oracle.regret(failure), oracle.idle(world.truth)
    except RefusalError:
        return  # an oracle need not tell values
    assert lost == idle > 0
    best = world.legal(oracle.plan(world.truth, 1)[0])
    before = world.truth
    _, reward, _, _, info = world.advance(best)
    played = Moment(before, best, reward, world.truth, info["success"], 1, False)
    assert oracle.regret(played) < lost


@on_every_environment
def test_plans_are_optimal_and_solve_the_task(name):
    world = pupil(name).make_world()
    oracle = ENVIRONMENTS[name][0].make_teacher(world).oracle
    for seed in range(fewer(ENVIRONMENTS[name][0], 10)):
        world.reset(seed=seed)
        oracle.start(world.truth)
        plan = oracle.plan(world.truth, 100)
        assert oracle.plan(world.truth, 0) == ()
        assert oracle.plan(world.truth, 1) == plan[:1]
        info = {}
        for number, action in enumerate(plan[: ENVIRONMENTS[name][0].max_turns], 1):
            before, values = world.truth, oracle.values(world.truth)
            assert values is None or values[action] == max(values)
            _, reward, _, _, info = world.step(action)
            moment = Moment(before, world.legal(action), reward, world.truth, info["success"], number, False)
            assert oracle.regret(moment) == pytest.approx(0)
        assert info["success"]


@on_every_environment
def test_advice_is_good_and_warnings_are_of_what_is_not(name):
    for oracle, moment in pupil(name).judged():
        values = oracle.values(moment.after)
        for claim in oracle.judge(moment, frozenset((FP, FN))):
            if values is None:
                continue
            assert (values[claim.action] == max(values)) == (claim.kind == FP)


@on_every_environment
def test_every_subset_of_kinds_is_the_filtered_judgement(name):
    assert len(SUBSETS) == 32
    for oracle, moment in islice(pupil(name).judged(), 80):
        claims = oracle.judge(moment)
        for kinds in SUBSETS:
            assert oracle.judge(moment, kinds) == tuple(claim for claim in claims if claim.kind in kinds)


@on_every_environment
@pytest.mark.parametrize("instruction_type", ["b", "p", "c"])
def test_instructions_hold(name, instruction_type):
    family, _ = ENVIRONMENTS[name]
    world = pupil(name).make_world()
    lab = world.scratch()
    if instruction_type not in family.oracle_class().instruction_types:
        with pytest.raises(ValueError, match=f"instruction type '{instruction_type}' is not supported"):
            family.make_teacher(world, instruction_type=instruction_type)
        return
    for seed in range(fewer(family, amount(6, full=15))):
        world.reset(seed=seed)
        oracle = family.make_teacher(world).oracle
        oracle.start(world.truth)
        claims = oracle.brief(world.truth, instruction_type, np.random.default_rng(seed))
        assert len(set(claims)) == len(claims)
        assert [claim for claim in claims if not claim.holds(opening(world.truth), lab)] == []


@on_every_environment
def test_what_phrases_tell_of_actions_can_be_read_as_these(name):
    """Where a claim names the slot in which they stand."""
    world = pupil(name).make_world()
    told = []
    for oracle, moment in islice(pupil(name).judged(), 40):
        claims = oracle.judge(moment)
        if moment.turn == 0:
            for type_ in oracle.instruction_types:
                claims += oracle.brief(moment.after, type_, np.random.default_rng(0))
        world.restore(moment.after)
        for claim in claims:
            if isinstance(claim, ActionClaim) and claim.action_slot:
                told.append((claim.action, parse_action(f"{getattr(claim, claim.action_slot)}", world)))
            if isinstance(claim, PlanClaim) and claim.plan_slot:
                words = getattr(claim, claim.plan_slot).split(claim.separator)
                told += zip(claim.actions, (parse_action(word, world) for word in words), strict=True)
    assert told
    assert [(action, read) for action, read in told if action != read] == []


@on_every_environment
def test_judging_again_says_the_same(name):
    for oracle, moment in islice(pupil(name).judged(), 40):
        assert oracle.judge(moment) == oracle.judge(moment)
        assert oracle.values(moment.after) == oracle.values(moment.after)


@on_every_environment
def test_false_counterparts_are_of_the_same_turn_and_false(name):
    rng = np.random.default_rng(0)
    lab = pupil(name).make_world()
    count = 0
    for oracle, moment in islice(pupil(name).judged(), 80):
        for claim in oracle.judge(moment):
            false = oracle.distort(claim, moment, rng)
            if false is not None:
                assert false != claim
                assert not false.holds(moment, lab)
                count += 1
    assert count > fewer(ENVIRONMENTS[name][0], 100)


@on_every_environment
def test_oracles_define_their_claims(name):
    cls = ENVIRONMENTS[name][0].oracle_class()
    assert all(claim.__module__ in (cls.__module__, f"{cls.__module__}.claims") for claim in cls.claims())
    assert {each.kind for each in cls.claims()} >= {None, *cls.feedback_types} - {R}


def test_a_package_has_claims_of_its_own_and_of_its_module_of_claims(monkeypatch):
    names = ("maze", "maze.claims", "maze.checks")
    package, inner, other = modules = [ModuleType(name) for name in names]
    for name, module in zip(names, modules, strict=True):
        monkeypatch.setitem(sys.modules, name, module)
        module.Said = type("Said", (Claim,), {"__module__": name})
    package.Imported, package.Foreign = inner.Said, other.Said
    assert claims_of("maze") == (package.Said, inner.Said)
    assert claims_of("maze.claims") == (inner.Said,)
    assert claims_of("maze.checks") == (other.Said,)
    package.CLAIMS = other.Said, package.Said
    assert claims_of("maze") == (other.Said, package.Said)


def test_the_claims_of_all_families_are_listed_once():
    modules = (import_module(each.name) for each in iter_modules(common.__path__, f"{common.__name__}."))
    defined = [cls for module in modules for cls in claims_of(module.__name__) if is_decorated(cls)]
    assert len(defined) == len(set(defined)) == len(common.CLAIMS)
    assert set(defined) == set(common.CLAIMS)


@on_every_environment
def test_the_syntax_of_an_instruction_is_true_of_a_world_that_reads_it(name, monkeypatch):
    family, options = ENVIRONMENTS[name]
    world = family.make_world(**options)
    world.reset(seed=3)
    lab, moment = world.scratch(), Moment.opening(world.truth, 0)
    assert Syntax(expected=world.action_syntax).holds(moment, lab)
    assert not Syntax(expected="a song").holds(moment, lab)
    monkeypatch.setattr(lab, "legal", lambda action: action)  # what is none is taken
    assert not Syntax(expected=world.action_syntax).holds(moment, lab)
