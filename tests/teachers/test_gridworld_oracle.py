"""The gridworld's oracle: every tied shortest path is right."""

import networkx as nx
import pytest
from moments import opening, started, turn

from pz_envs.family import all_families
from teachers.atoms import FN, HN, HP, Moment
from teachers.oracles.gridworld import GridworldOracle
from teachers.oracles.gridworld.claims import Avoid, Found, Go, Nearer, NoNearer, Treasure
from teachers.testing import Pupil, check_oracle
from worlds.gridworld import DIRECTIONS, NO_DOOR, Gridworld, Layout
from worlds.gridworld import Truth as Place

NORTH, EAST, WEST, SOUTH = DIRECTIONS

# Four rooms in a square; 0 is in the south-west, the treasure in the north-east: two shortest paths.
SQUARE = Layout(
    doors=((2, 1, NO_DOOR, NO_DOOR), (3, NO_DOOR, 0, NO_DOOR), (NO_DOOR, 3, NO_DOOR, 0), (NO_DOOR, NO_DOOR, 2, 1)),
    names=("hall-1", "attic-1", "attic-2", "cellar-1"),
    objects=((), (), (), ()),
    treasure=3,
)


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_every_tied_shortest_path_is_right(direction):
    lab = Gridworld(num_rooms=4, min_goal_dist=1)
    oracle = started(GridworldOracle, lab.scratch(), Place(0, False, SQUARE))
    right = direction in (NORTH, EAST)
    start = opening(Place(0, False, SQUARE))
    assert Go(action=direction).holds(start, lab) == right
    assert Avoid(action=direction).holds(start, lab) != right
    moment = turn(lab.scratch(), Place(0, False, SQUARE), direction)
    hindsight = oracle.judge(moment, frozenset((HP, HN)))
    verdict = Nearer if right else NoNearer
    assert hindsight == (verdict(action=direction, room="hall-1"),)
    assert hindsight[0].holds(moment, lab)
    assert oracle.regret(moment) == (0 if right else 1)


def test_no_tied_shortest_path_is_warned_of():
    oracle = started(GridworldOracle, Gridworld(num_rooms=4, min_goal_dist=1), Place(0, False, SQUARE))
    warnings = [oracle.judge(opening(Place(0, False, SQUARE))._replace(turn=n), frozenset((FN,))) for n in range(8)]
    assert {claim.action for claims in warnings for claim in claims} == {WEST, SOUTH}


@pytest.mark.parametrize("seed", range(8))
def test_advice_holds_exactly_on_shortest_paths(seed):
    world = Gridworld()
    world.reset(seed=seed)
    layout, lab = world.truth.layout, world.scratch()
    house = nx.Graph((room, behind) for room, row in enumerate(layout.doors) for behind in row if behind != NO_DOOR)
    oracle = started(GridworldOracle, world, world.truth)
    for room in range(len(layout.doors)):
        if room == layout.treasure:
            continue
        truth = Place(room, False, layout)
        paths = list(nx.all_shortest_paths(house, room, layout.treasure))
        good = {DIRECTIONS[layout.doors[room].index(path[1])] for path in paths}
        assert {d for d in DIRECTIONS if Go(action=d).holds(opening(truth), lab)} == good
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
    assert Treasure(name="golden crown") in told
    assert Treasure(name="golden crown").holds(moment, world.scratch())
    for name in ("torch", "rope", "treasure"):
        assert not Treasure(name=name).holds(moment, world.scratch())
    plain = Gridworld()
    plain.reset(seed=0)
    assert Treasure not in {type(claim) for claim in family.make_teacher(plain).oracle.brief(plain.truth, "b")}


def test_after_the_treasure_nothing_but_the_reward_is_told():
    world = Gridworld(num_rooms=4, min_goal_dist=1)
    oracle = started(GridworldOracle, world, Place(1, False, SQUARE))
    entering = turn(world, Place(1, False, SQUARE), NORTH)
    assert [type(claim) for claim in oracle.judge(entering)][1:] == [Found]
    for direction in DIRECTIONS:
        later = turn(world, entering.after, direction)
        assert [claim.kind for claim in oracle.judge(later)] == ["r"]
        assert oracle.regret(later) == oracle.importance(later.after) == 0
        assert oracle.plan(later.after, 5) == ()
        assert not Go(action=direction).holds(later, world.scratch())
        assert not Avoid(action=direction).holds(later, world.scratch())
