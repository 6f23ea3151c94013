"""Oracles: values, plans and claims agree with each other and with the world, ties included."""

import sys
from itertools import combinations, islice
from types import ModuleType

import networkx as nx
import numpy as np
import pytest
from gymnasium import spaces
from hypothesis import given, settings
from hypothesis import strategies as st
from sampling import fewer

from pz_envs.family import all_families
from pz_envs.text_mode import parse_action
from teachers.atoms import FN, FP, HN, HP, KINDS, ActionClaim, Claim, Moment, ParseFailure, PlanClaim, R
from teachers.oracle import RefusalError, claims_of
from teachers.oracles import bandits, gridworld
from teachers.oracles.poem import PoemOracle
from teachers.oracles.poem.claims import AllRight, Empty, LinesRight, WrongLine, WrongNumber
from teachers.testing import Pupil, check_oracle
from worlds.bandits import Bandit
from worlds.bandits import Truth as Arms
from worlds.gridworld import DIRECTIONS, NO_DOOR, Gridworld, Layout
from worlds.gridworld import Truth as Place
from worlds.poem import Poem
from worlds.poem import Truth as Form

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
NORTH, EAST, WEST, SOUTH = DIRECTIONS
SUBSETS = [frozenset(chosen) for size in range(6) for chosen in combinations(KINDS, size)]

# Four rooms in a square; 0 is in the south-west, the treasure in the north-east: two shortest paths.
SQUARE = Layout(
    doors=((2, 1, NO_DOOR, NO_DOOR), (3, NO_DOOR, 0, NO_DOOR), (NO_DOOR, 3, NO_DOOR, 0), (NO_DOOR, NO_DOOR, 2, 1)),
    names=("hall-1", "attic-1", "attic-2", "cellar-1"),
    objects=((), (), (), ()),
    treasure=3,
)


def pupil(name, turns=150):
    family, options = ENVIRONMENTS[name]
    turns = fewer(family, turns)
    return Pupil(lambda: family.make_world(**options), family.make_teacher, max_turns=family.max_turns, turns=turns)


def started(oracle_class, world, truth):
    """An oracle that looks at a hand-made truth."""
    world.restore(truth)
    oracle = oracle_class(world.scratch)
    oracle.start(truth)
    return oracle


def opening(truth):
    return Moment.opening(truth)


def turn(world, truth, action, number=1):
    world.restore(truth)
    _, reward, _, _, info = world.step(action)
    return Moment(truth, world.legal(action), reward, world.truth, info["success"], number, False)


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
    for oracle, moment in pupil(name, turns=600).judged():
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
        lost = oracle.regret(failure)
    except RefusalError:
        return  # an oracle need not tell regrets
    assert lost == oracle.idle(world.truth) > 0
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
    for seed in range(fewer(family, 15)):
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


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_every_tied_shortest_path_is_right(direction):
    lab = Gridworld(num_rooms=4, min_goal_dist=1)
    oracle = started(gridworld.GridworldOracle, lab.scratch(), Place(0, False, SQUARE))
    right = direction in (NORTH, EAST)
    start = opening(Place(0, False, SQUARE))
    assert gridworld.Go(action=direction).holds(start, lab) == right
    assert gridworld.Avoid(action=direction).holds(start, lab) != right
    moment = turn(lab.scratch(), Place(0, False, SQUARE), direction)
    hindsight = oracle.judge(moment, frozenset((HP, HN)))
    verdict = gridworld.Nearer if right else gridworld.NoNearer
    assert hindsight == (verdict(action=direction, room="hall-1"),)
    assert hindsight[0].holds(moment, lab)
    assert oracle.regret(moment) == (0 if right else 1)


def test_no_tied_shortest_path_is_warned_of():
    oracle = started(gridworld.GridworldOracle, Gridworld(num_rooms=4, min_goal_dist=1), Place(0, False, SQUARE))
    warnings = [oracle.judge(opening(Place(0, False, SQUARE))._replace(turn=n), frozenset((FN,))) for n in range(8)]
    assert {claim.action for claims in warnings for claim in claims} == {WEST, SOUTH}


@pytest.mark.parametrize("seed", range(8))
def test_advice_holds_exactly_on_shortest_paths(seed):
    world = Gridworld()
    world.reset(seed=seed)
    layout, lab = world.truth.layout, world.scratch()
    house = nx.Graph((room, behind) for room, row in enumerate(layout.doors) for behind in row if behind != NO_DOOR)
    oracle = started(gridworld.GridworldOracle, world, world.truth)
    for room in range(len(layout.doors)):
        if room == layout.treasure:
            continue
        truth = Place(room, False, layout)
        paths = list(nx.all_shortest_paths(house, room, layout.treasure))
        good = {DIRECTIONS[layout.doors[room].index(path[1])] for path in paths}
        assert {d for d in DIRECTIONS if gridworld.Go(action=d).holds(opening(truth), lab)} == good
        assert {d for d, value in enumerate(oracle.values(truth)) if value == max(oracle.values(truth))} == good
        assert len(oracle.plan(truth, 100)) == len(paths[0]) - 1


def test_a_treasure_of_another_name_is_named():
    options = {"room_types": ["cave"], "object_types": ["torch", "rope"], "treasure": "golden crown"}
    family = next(each for each in all_families() if each.name == "gridworld")
    check_oracle(Pupil(lambda: family.make_world(**options), family.make_teacher, max_turns=10))
    world = family.make_world(**options)
    world.reset(seed=0)
    moment = Moment.opening(world.truth)
    told = family.make_teacher(world).oracle.brief(world.truth, "b")
    assert gridworld.Treasure(name="golden crown") in told
    assert gridworld.Treasure(name="golden crown").holds(moment, world.scratch())
    for name in ("torch", "rope", "treasure"):
        assert not gridworld.Treasure(name=name).holds(moment, world.scratch())
    plain = Gridworld()
    plain.reset(seed=0)
    assert gridworld.Treasure not in {
        type(claim) for claim in family.make_teacher(plain).oracle.brief(plain.truth, "b")
    }


def test_after_the_treasure_nothing_but_the_reward_is_told():
    world = Gridworld(num_rooms=4, min_goal_dist=1)
    oracle = started(gridworld.GridworldOracle, world, Place(1, False, SQUARE))
    entering = turn(world, Place(1, False, SQUARE), NORTH)
    assert [type(claim) for claim in oracle.judge(entering)][1:] == [gridworld.Found]
    for direction in DIRECTIONS:
        later = turn(world, entering.after, direction)
        assert [claim.kind for claim in oracle.judge(later)] == ["r"]
        assert oracle.regret(later) == oracle.importance(later.after) == 0
        assert oracle.plan(later.after, 5) == ()
        assert not gridworld.Go(action=direction).holds(later, world.scratch())
        assert not gridworld.Avoid(action=direction).holds(later, world.scratch())


@pytest.mark.parametrize(("means", "best"), [((0.5, 0.5), {0, 1}), ((0.0, 0.0), {0, 1}), ((0.5, 0.25), {0})])
def test_tied_arms_are_all_right(means, best):
    truth = Arms(means, (1.0, 1.0), 0.0, means)
    world = Bandit("TwoArmedHighLowFixed")
    oracle, lab = started(bandits.BanditOracle, world, truth), world.scratch()
    for arm in range(2):
        moment = turn(world, truth, arm)
        (verdict,) = oracle.judge(moment, frozenset((HP, HN)))
        assert type(verdict) is (bandits.PulledBest if arm in best else bandits.PulledPoor)
        assert verdict.holds(moment, lab)
        assert bandits.Pull(action=arm).holds(moment, lab) == (arm in best)
        assert bandits.Avoid(action=arm).holds(moment, lab) == (arm not in best)
        assert (oracle.regret(moment) == 0) == (arm in best)
    warned = {claim.action for n in range(4) for claim in oracle.judge(moment._replace(turn=n), frozenset((FN,)))}
    assert warned == {0, 1} - best
    assert all(
        claim.holds(opening(truth), lab)
        for each in "bpc"
        for claim in oracle.brief(truth, each, np.random.default_rng(0))
    )


def test_warnings_go_through_all_poor_arms():
    world = Bandit("TenArmedRandomFixed")
    means = (0.1, 0.9, 0.2, 0.9, *[0.3] * 6)
    oracle = started(bandits.BanditOracle, world, Arms(means, (1.0,) * 10, 0.0, means))
    moments = [opening(world.truth)._replace(turn=n) for n in range(8)]
    assert {oracle.judge(moment)[-1].action for moment in moments} == set(range(10)) - {1, 3}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", [Empty]),
        ("snow", [WrongNumber]),
        ("snow\nrain\nash\nmoss", [WrongNumber]),
        ("snow\ncold rain", [AllRight]),
        ("snow\nrain", [LinesRight, WrongLine]),
        ("cold rain\nrain", [WrongLine, WrongLine]),
        ("fire\nfire", [AllRight]),
    ],
)
def test_poems_are_judged_line_by_line(text, said):
    world = Poem("LineSyllableConstrainedPoem")
    truth = Form((1, 2), False, "")
    oracle, lab = started(PoemOracle, world, truth), world.scratch()
    moment = turn(world, truth, text)
    claims = oracle.judge(moment)
    assert [type(claim) for claim in claims if claim.kind in (HP, HN)] == said
    assert [claim for claim in claims if not claim.holds(moment, lab)] == []
    advice = next(claim for claim in claims if claim.kind == FP)
    assert turn(world, moment.after, advice.action).reward > moment.reward or moment.success


PIECES = [
    "fire",
    "snow",
    "every",
    "glimmerfoam",
    "19",
    " ",
    " ",
    "-",
    "'",
    "\n",
    "\n",
    "\u2028",
    "\t",
    "%s {0}",
    "\u0301",
    "...",
]
patterns = st.builds(
    Form, st.lists(st.integers(1, 40), min_size=1, max_size=40).map(tuple), st.just(False), st.just("")
)
free = st.builds(Form, st.tuples(st.integers(1, 40)), st.just(True), st.just(""))


@given(
    pieces=st.lists(st.sampled_from(PIECES), max_size=40),
    times=st.sampled_from([1, 1, 1, 5, 400]),
    truth=patterns | free,
    number=st.integers(1, 50),
)
@settings(deadline=None)
def test_what_is_said_of_any_poem_holds_and_its_advice_helps(pieces, times, truth, number):
    world = Poem("SyllableConstrainedPoem" if truth.free else "LineSyllableConstrainedPoem")
    oracle, lab = started(PoemOracle, world, truth), world.scratch()
    moment = turn(world, truth, ("".join(pieces) * times)[: world.action_space.max_length], number)
    claims = oracle.judge(moment)
    assert [claim for claim in claims if not claim.holds(moment, lab)] == []
    (advice,) = (claim for claim in claims if claim.kind == FP)
    assert turn(world, moment.after, advice.action).reward > moment.reward or moment.success


def test_following_the_advice_leads_to_a_right_poem():
    world = Poem("LineSyllableConstrainedPoem")
    truth = Form((5, 7, 5, 17, 40), False, "")
    oracle = started(PoemOracle, world, truth)
    moment = turn(world, truth, "snow")
    for _ in range(6):
        (advice,) = oracle.judge(moment, frozenset((FP,)))
        moment = turn(world, moment.after, advice.action)
    assert moment.success


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
