"""What the checks against the `alfworld` package need, and what other processes play.

Tests hand the latter to them, so it has to be in a module that they can import. Run as a program, it writes the floor
plans that ship here, as the installed package has them.
"""

import json
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import worlds.alfworld
from worlds.alfworld.facts import Room, Task, Things
from worlds.alfworld.shipped import installed, package
from worlds.alfworld.stock import StockEngine

STOCK = pytest.mark.skipif(
    not installed(),
    reason="needs TextWorld's engine; run: pip install 'llf-teacher[alfworld]'",
)
"""The mark of tests that compare with the `alfworld` package."""
ROOMS = Path(worlds.alfworld.__file__).parent / "data" / "rooms.json"
"""The floor plans that ship here."""


def play_in_textworld(seed):
    """The answers to a few commands."""
    world = worlds.alfworld.Alfworld(engine="textworld", games="generated")
    world.reset(seed=seed)
    return [world.step(command)[0] for command in ("look", world.commands()[0], "inventory")]


def plan_by_downward(played, queue):
    """Put the length of Fast Downward's plan for a game into a queue."""
    env = StockEngine(played)._env
    queue.put(len(env._pddl_state.replan(env._entity_infos)))


def stock_things():
    """What the package says of types of things; of slices games make no use."""
    package()
    constants = import_module("alfworld.gen.constants")

    def whole(types):
        return sorted(each for each in types if not each.endswith("Sliced"))

    held = constants.VAL_RECEPTACLE_OBJECTS
    holders = sorted((constants.RECEPTACLES - constants.MOVABLE_RECEPTACLES_SET) & held.keys())
    return Things(
        {holder: tuple(whole(held[holder])) for holder in holders},
        {predicate: frozenset(whole(types)) for predicate, types in constants.VAL_ACTION_OBJECTS.items()},
        frozenset(constants.OPENABLE_CLASS_SET),
        frozenset(constants.MOVABLE_RECEPTACLES_SET),
    )


def stock_tasks():
    """The types of tasks that the package gives rooms for."""
    package()
    valid = import_module("alfworld.gen.constants").GOALS_VALID
    known = import_module("alfworld.gen.goal_library").gdict
    return {
        name: Task(frozenset(valid[name]), tuple(known[name]["templates"]), known[name]["pddl"])
        for name in worlds.alfworld.TASKS
    }


def stock_rooms():
    """The floor plans of the package."""
    layouts = package() / "gen" / "layouts"
    constants = import_module("alfworld.gen.constants")

    def room(number):
        types, poses = (
            json.loads((layouts / f"FloorPlan{number}-{part}.json").read_text()) for part in ("objects", "openable")
        )
        points = np.load(layouts / f"FloorPlan{number}-layout.npy").tolist()
        return Room(
            tuple(sorted(types)),
            {id: tuple(pose) for id, pose in poses.items()},
            tuple(tuple(point) for point in points),
            number in constants.TEST_SCENE_NUMBERS,
        )

    return {number: room(number) for number in sorted(constants.SCENE_NUMBERS)}


def written(rooms):
    """Floor plans as the text of a file, with a map of each."""
    return "{\n" + ",\n".join(f'"{number}": {_written(room)}' for number, room in rooms.items()) + "\n}\n"


def _written(room):
    xs, zs = zip(*room.points, strict=True)
    width, depth = (round((max(each) - min(each)) * 4) + 1 for each in (xs, zs))
    cells = [["#"] * width for _ in range(depth)]
    for x, z in room.points:
        cells[round((z - min(zs)) * 4)][round((x - min(xs)) * 4)] = "."
    poses = ",\n  ".join(f"{json.dumps(id)}: {json.dumps(pose)}" for id, pose in room.poses.items())
    rows = ",\n  ".join(json.dumps("".join(row)) for row in cells)
    return (
        f'{{\n "types": {json.dumps(room.types)},\n "unseen": {json.dumps(room.unseen)},\n "poses": {{\n  {poses}\n }},'
        f'\n "corner": {json.dumps((min(xs), min(zs)))},\n "map": [\n  {rows}\n ]\n}}'
    )


if __name__ == "__main__":
    ROOMS.write_text(written(stock_rooms()), encoding="utf-8")
