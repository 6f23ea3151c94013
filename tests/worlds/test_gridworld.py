"""Gridworld: how houses are built, and how one walks through them."""

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from worlds.gridworld import DIRECTIONS, NO_DOOR, OBJECTS, ROOM_TYPES, Direction, Gridworld, Layout, Truth

NORTH, EAST, WEST, SOUTH = DIRECTIONS
OPPOSITE = {NORTH: SOUTH, SOUTH: NORTH, EAST: WEST, WEST: EAST}
OFFSET = {NORTH: (0, 1), EAST: (1, 0), WEST: (-1, 0), SOUTH: (0, -1)}

# Four rooms in a square; 0 is in the south-west, the treasure in the north-east: two shortest paths.
SQUARE = Layout(
    doors=((2, 1, NO_DOOR, NO_DOOR), (3, NO_DOOR, 0, NO_DOOR), (NO_DOOR, 3, NO_DOOR, 0), (NO_DOOR, NO_DOOR, 2, 1)),
    names=("hall-1", "attic-1", "attic-2", "cellar-1"),
    objects=((), ("clock", "vase"), (), ("lamp",)),
    treasure=3,
)


def square(room=0, found=False):
    world = Gridworld(num_rooms=4, min_goal_dist=1)
    world.restore(Truth(room, found, SQUARE))
    return world


def reset(seed=0, **options):
    world = Gridworld(**options)
    world.reset(seed=seed)
    return world


def walk(world, *directions):
    return [world.step(direction) for direction in directions]


def graph(layout):
    house = nx.Graph()
    house.add_nodes_from(range(len(layout.doors)))
    house.add_edges_from((room, behind) for room, row in enumerate(layout.doors) for behind in row if behind != NO_DOOR)
    return house


def cells(layout):
    """Where each room lies on a grid if the first lies at the origin and every door leads one cell on."""
    found, queue = {0: (0, 0)}, [0]
    for room in queue:
        for direction, behind in zip(DIRECTIONS, layout.doors[room], strict=True):
            if behind == NO_DOOR:
                continue
            cell = tuple(np.add(found[room], OFFSET[direction]).tolist())
            assert found.setdefault(behind, cell) == cell
            if behind not in queue:
                queue.append(behind)
    return found


def walls(layout):
    """Pairs of rooms that lie side by side without a door between them."""
    at = {cell: room for room, cell in cells(layout).items()}
    sides = [(room, at.get((x + dx, y + dy))) for (x, y), room in at.items() for dx, dy in ((0, 1), (1, 0))]
    return [(room, beside) for room, beside in sides if beside is not None and beside not in layout.doors[room]]


def plain(observation):
    return observation["room"], observation["doors"].tolist(), observation["objects"].tolist()


@st.composite
def options(draw):
    rooms = draw(st.integers(2, 30))
    least = draw(st.integers(1, min(rooms - 1, 6)))
    return {"num_rooms": rooms, "num_objects": draw(st.integers(0, 40)), "min_goal_dist": least}


@given(options=options(), seed=st.integers(0, 2**32))
@settings(deadline=None)
def test_houses_are_planar_connected_and_furnished_as_asked(options, seed):
    world = reset(seed, **options)
    room, found, layout = world.truth
    rooms = options["num_rooms"]
    assert len(layout.doors) == len(layout.names) == len(layout.objects) == rooms
    assert not found
    for here, row in enumerate(layout.doors):
        assert len(row) == 4
        for direction, behind in zip(DIRECTIONS, row, strict=True):
            assert behind == NO_DOOR or layout.doors[behind][OPPOSITE[direction]] == here
    places = cells(layout)
    assert len(places) == len(set(places.values())) == rooms  # every room is reached, and no two share a cell
    assert len(set(layout.names)) == rooms
    assert {name.rpartition("-")[0] for name in layout.names} <= set(ROOM_TYPES)
    assert sum(map(len, layout.objects)) <= options["num_objects"]
    assert all(set(things) <= set(OBJECTS) and len(things) == len(set(things)) for things in layout.objects)
    assert nx.shortest_path_length(graph(layout), room, layout.treasure) >= options["min_goal_dist"]


@given(rooms=st.integers(3, 9), seed=st.integers(0, 2**32))
@settings(deadline=None)
def test_houses_have_a_cycle_wherever_two_rooms_allow_it(rooms, seed):
    layout = reset(seed, num_rooms=rooms, min_goal_dist=1).truth.layout
    assert nx.cycle_basis(graph(layout)) or not walls(layout)


def test_about_half_of_the_walls_are_open():
    layouts = [reset(seed).truth.layout for seed in range(60)]
    closed = sum(len(walls(layout)) for layout in layouts)
    opened = sum(graph(layout).number_of_edges() - 19 for layout in layouts)
    assert 0.4 < opened / (opened + closed) < 0.6


@pytest.mark.parametrize("seed", range(40))
def test_houses_of_the_usual_size_have_cycles(seed):
    layout = reset(seed).truth.layout
    assert len(layout.doors) == 20
    assert nx.cycle_basis(graph(layout))


def test_some_treasures_are_reached_by_several_shortest_paths():
    truths = [reset(seed).truth for seed in range(40)]
    paths = [len(list(nx.all_shortest_paths(graph(t.layout), t.room, t.layout.treasure))) for t in truths]
    assert min(paths) == 1
    assert max(paths) > 1


@pytest.mark.parametrize("rooms", [2, 3, 12, 40])
@pytest.mark.parametrize("seed", range(3))
def test_the_treasure_can_be_as_far_away_as_the_rooms_allow(rooms, seed):
    truth = reset(seed, num_rooms=rooms, min_goal_dist=rooms - 1).truth
    assert nx.shortest_path_length(graph(truth.layout), truth.room, truth.layout.treasure) == rooms - 1
    assert len(cells(truth.layout)) == rooms


@pytest.mark.parametrize(("count", "strewn"), [(0, 0), (1, 1), (5000, 20 * len(OBJECTS))])
def test_objects_are_strewn(count, strewn):
    assert sum(map(len, reset(num_objects=count).truth.layout.objects)) == strewn


def test_the_largest_parameters_work():
    world = reset(num_rooms=1000, num_objects=3000, min_goal_dist=25)
    truth = world.truth
    assert nx.shortest_path_length(graph(truth.layout), truth.room, truth.layout.treasure) >= 25
    assert world.reset()[0] in world.observation_space


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"num_rooms": 1}, "num_rooms must be an integer from 2 to 10000, got 1"),
        ({"num_rooms": 10_001}, "num_rooms must be"),
        ({"num_rooms": 20.0}, r"num_rooms must be an integer .* got 20\.0"),
        ({"num_rooms": float("nan")}, "num_rooms must be"),
        ({"num_rooms": "20"}, "num_rooms must be"),
        ({"num_rooms": None}, "num_rooms must be"),
        ({"num_objects": -1}, "num_objects must be an integer from 0 to 100000, got -1"),
        ({"num_objects": "many"}, "num_objects must be"),
        ({"min_goal_dist": 0}, "with num_rooms=20 min_goal_dist must be an integer from 1 to 19, got 0"),
        ({"min_goal_dist": 20}, "min_goal_dist must be an integer from 1 to 19, got 20"),
        ({"num_rooms": 2}, "with num_rooms=2 min_goal_dist must be an integer from 1 to 1, got 4"),
        ({"render_mode": "human"}, "render_mode 'human' is unknown; allowed: None, ansi"),
    ],
)
def test_bad_parameters_are_named(options, message):
    with pytest.raises(ValueError, match=message):
        Gridworld(**options)


def test_doors_lead_where_the_layout_says():
    world = square()
    rooms = [observation["room"] for observation, *_ in walk(world, NORTH, SOUTH, EAST, WEST, EAST, NORTH)]
    assert rooms == [2, 0, 1, 0, 1, 3]


@pytest.mark.parametrize("direction", [WEST, SOUTH])
def test_without_a_door_one_stays(direction):
    world = square()
    before = world.truth
    observation, reward, _, _, info = world.step(direction)
    assert world.truth == before
    assert (observation["room"], reward, info) == (0, 0.0, {"success": False})


@given(st.lists(st.sampled_from(DIRECTIONS), max_size=30))
def test_any_walk_agrees_with_the_layout(directions):
    world, room = square(), 0
    found = False
    for direction in directions:
        behind = SQUARE.doors[room][direction]
        room = room if behind == NO_DOOR else behind
        observation, reward, terminated, truncated, info = world.step(direction)
        assert observation["room"] == room
        assert reward == float(room == 3 and not found)
        found = found or room == 3
        assert info == {"success": found}
        assert (terminated, truncated) == (False, False)


def test_the_treasure_pays_once_and_success_stays():
    steps = walk(square(), EAST, NORTH, NORTH, SOUTH, NORTH)
    assert [reward for _, reward, *_ in steps] == [0, 1, 0, 0, 0]
    assert [info["success"] for *_, info in steps] == [False, True, True, True, True]


def test_observations_show_doors_and_objects_of_the_room():
    world = square()
    observation = world.step(EAST)[0]
    assert plain(observation) == (1, [1, 0, 1, 0], [1, 0, 0, 0, 1, 0])
    assert observation in world.observation_space
    assert plain(world.step(NORTH)[0]) == (3, [0, 0, 1, 1], [0, 1, 0, 0, 0, 1])


@pytest.mark.parametrize(
    ("room", "text"),
    [
        (0, "Room: hall-1\nObjects: none\nDoors: north: attic-2, east: attic-1"),
        (1, "Room: attic-1\nObjects: clock, vase\nDoors: north: cellar-1, west: hall-1"),
        (3, "Room: cellar-1\nObjects: lamp, treasure\nDoors: west: attic-2, south: attic-1"),
    ],
)
def test_descriptions_name_room_objects_and_doors(room, text):
    world = square(room)
    world.render_mode = "ansi"
    assert world.render() == text
    assert world.describe(world.observe()) == text


def test_rendering_is_off_by_default():
    assert square().render() is None


@pytest.mark.parametrize("action", [-1, 4, 10**9, 10**30, 0.0, float("nan"), "north", None, [0], np.array([0, 1])])
def test_what_is_no_direction_is_refused_and_changes_nothing(action):
    world = reset()
    before = world.save()
    with pytest.raises(ValueError, match=r"not in the action space; allowed: 0 north, .* 3 south; .* unchanged"):
        world.step(action)
    assert world.save() == before


@pytest.mark.parametrize("action", [2, WEST, np.int64(2), np.uint8(2), np.array(2)])
def test_a_direction_may_be_any_integer(action):
    assert square().legal(action) is WEST


def test_directions_are_written_as_words():
    assert [str(d) for d in DIRECTIONS] == [f"{d}" for d in Direction] == ["north", "east", "west", "south"]
    assert dict(Gridworld.action_words) == {"north": 0, "east": 1, "west": 2, "south": 3}


actions = st.lists(st.sampled_from(DIRECTIONS), max_size=15)


@given(seed=st.integers(0, 2**32), before=actions, after=actions)
@settings(deadline=None)
def test_restore_brings_back_everything(seed, before, after):
    world = reset(seed)
    walk(world, *before)
    saved = world.save()
    first = [(plain(step[0]), *step[1:]) for step in walk(world, *after)], world.truth
    drawn = world.np_random.random()
    world.reset()
    world.restore(saved)
    assert world.save() == saved
    assert ([(plain(step[0]), *step[1:]) for step in walk(world, *after)], world.truth) == first
    assert world.np_random.random() == drawn


def test_a_restored_truth_may_be_of_another_house():
    world, other = reset(1), reset(2)
    luck = world.save().random_state
    world.restore(other.truth)
    assert world.truth == other.truth
    assert [plain(s[0]) for s in walk(world, *DIRECTIONS)] == [plain(s[0]) for s in walk(other, *DIRECTIONS)]
    assert world.save().random_state == luck


def test_seeds_decide_the_house():
    assert reset(3).truth == reset(3).truth
    assert reset(3).truth.layout != reset(4).truth.layout
    world, twin = reset(3), reset(3)
    walk(world, NORTH, EAST)
    world.reset()
    twin.reset()
    assert world.truth == twin.truth != reset(3).truth


OWN = {"room_types": ["cave", "smith's hut"], "object_types": ["torch"], "treasure": "golden-crown"}


@given(st.integers(0, 2**32))
@settings(max_examples=30)
def test_names_of_ones_own(seed):
    world = reset(seed, **OWN)
    layout = world.truth.layout
    assert {name.rpartition("-")[0] for name in layout.names} <= set(OWN["room_types"])
    assert len(set(layout.names)) == 20
    assert {thing for things in layout.objects for thing in things} == {"torch"}
    world.restore(Truth(layout.treasure, False, layout))
    torch = ["torch"] * bool(layout.objects[layout.treasure])
    assert f"Objects: {', '.join([*torch, 'golden-crown'])}\n" in world.describe(world.observe())
    assert world.observation_space.contains(world.observe())


def test_names_alone_change_no_house():
    plain, named = (
        reset(3).truth,
        reset(3, room_types=tuple("ABCDEFG"), object_types=tuple("abcde"), treasure="x").truth,
    )
    assert named.layout.doors == plain.layout.doors
    assert (named.room, named.layout.treasure) == (plain.room, plain.layout.treasure)
    assert [len(things) for things in named.layout.objects] == [len(things) for things in plain.layout.objects]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"room_types": []}, r"room_types must be a list of different names, at least one, .* got \[\]"),
        ({"room_types": "cave"}, "room_types must be a list of different names"),
        ({"room_types": ["cave", "cave"]}, "room_types must be a list of different names"),
        ({"object_types": ["lamp, oil"]}, "each of letters, spaces, hyphens and apostrophes, got"),
        ({"object_types": ["lamp", 3]}, "object_types must be a list"),
        ({"object_types": None}, "object_types must be a list"),
        ({"treasure": ""}, "treasure must be of letters, spaces, hyphens and apostrophes, .* got ''"),
        ({"treasure": " gem"}, "treasure must be"),
        ({"treasure": "vase"}, "and not in object_types, got 'vase'"),
        ({"treasure": None}, "treasure must be"),
    ],
)
def test_names_are_checked(options, message):
    with pytest.raises(ValueError, match=message):
        Gridworld(**options)
