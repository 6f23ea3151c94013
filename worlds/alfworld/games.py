"""Games: a house, what lies where in it, and a task; read from ALFWorld's files or made anew by seed.

Both ways end in a problem in PDDL, of which `parse` makes a `Game`. Everything that is drawn comes from what the
`alfworld` package ships: 120 floor plans of AI2-THOR with the receptacles' positions, the lists of what may lie where,
and the goals in PDDL and English.
"""

import json
import os
import re
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple, TypeVar

import numpy as np

Fact = tuple[str, ...]
"""A predicate and its arguments, in lower case, as in `("opened", "fridge_bar_...")`."""
_T = TypeVar("_T")

SPLITS = ("all", "train", "valid_seen", "valid_unseen")
TASKS = (
    "pick_and_place_simple",
    "look_at_obj_in_light",
    "pick_clean_then_place_in_recep",
    "pick_heat_then_place_in_recep",
    "pick_cool_then_place_in_recep",
    "pick_two_obj_and_place",
)
"""The six types of tasks, named as in ALFRED."""
CHANGING = frozenset(
    {"atlocation", "objectatlocation", "inreceptacle", "opened", "checked", "holds", "holdsany"}
    | {"isclean", "ishot", "iscool", "ison", "istoggled", "issliced"}
)
"""The predicates that actions change."""
APPLIANCES = {
    "pick_clean_then_place_in_recep": ("SinkBasin", "Cleanable"),
    "pick_heat_then_place_in_recep": ("Microwave", "Heatable"),
    "pick_cool_then_place_in_recep": ("Fridge", "Coolable"),
}
"""Per task with an appliance its type, and the list of the objects that it is for."""
_BASINS = {"Sink": "SinkBasin", "Bathtub": "BathtubBasin"}
_BASE = {basin: base for base, basin in _BASINS.items()}
_SEVERAL = {"StoveBurner": 4, "HandTowelHolder": 2}  # fixtures that come in sets
_LAMPS = ("Desk", "SideTable", "Dresser", "DiningTable", "CoffeeTable", "Shelf", "CounterTop")  # what lamps stand on
_PREDICATES = ("Cleanable", "Heatable", "Coolable", "Toggleable", "Sliceable")
_ROOMS = {0: "Kitchen", 2: "LivingRoom", 3: "Bedroom", 4: "Bathroom"}
_DRAWS = 2000  # more than the fullest house needs
_COPIES = (1, 1, 2, 3)  # of an object, drawn uniformly


class Game(NamedTuple):
    """The fixed part of an episode; shared by reference between snapshots."""

    task: str
    """One of `TASKS`."""
    target: str
    """Type of the object to deal with, in lower case as all types here."""
    destination: str
    """Type of the receptacle to put it in; empty when it is to be looked at."""
    lamp: str
    """Type of the lamp to look at it under; else empty."""
    goal: str
    """The task in English."""
    kinds: tuple[tuple[str, str], ...]
    """All objects of the problem with their PDDL types, such as `receptacle`."""
    static: frozenset[Fact]
    """Facts that no action changes."""
    start: frozenset[Fact]
    """Facts at the start that actions may change."""
    problem: str
    """The problem in PDDL."""


class Receptacle(NamedTuple):
    """A place for objects in a floor plan."""

    id: str
    type: str
    location: str
    """Where one stands to use it."""


class Plan(NamedTuple):
    """A floor plan."""

    number: int
    receptacles: tuple[Receptacle, ...]
    types: tuple[str, ...]
    """Types of all that is in the room."""
    points: tuple[tuple[float, float], ...]
    """Where one can stand: x and z in metres."""


@cache
def package() -> Path:
    """The folder of the `alfworld` package, and its modules importable.

    Importing it writes an environment variable and a folder into the user's home; here it does neither.
    """
    before = os.environ.get("ALFWORLD_DATA")
    os.environ["ALFWORLD_DATA"] = str(Path(__file__).parent)
    try:
        import alfworld
    finally:
        if before is None:
            del os.environ["ALFWORLD_DATA"]
        else:
            os.environ["ALFWORLD_DATA"] = before
    return Path(alfworld.__file__).parent


@cache
def rules() -> tuple[str, str]:
    """The domain in PDDL and the grammar that the package ships."""
    data = package() / "data"
    return (data / "alfred.pddl").read_text(encoding="utf-8"), (data / "alfred.twl2").read_text(encoding="utf-8")


def _constants() -> ModuleType:
    package()
    from alfworld.gen import constants

    return constants


def _goals() -> dict[str, dict[str, Any]]:
    package()
    from alfworld.gen.goal_library import gdict

    return gdict


@cache
def holders() -> dict[str, tuple[str, ...]]:
    """Per type of receptacle the types of objects that may lie in it."""
    constants = _constants()
    static = constants.RECEPTACLES - constants.MOVABLE_RECEPTACLES_SET
    held = constants.VAL_RECEPTACLE_OBJECTS
    return {
        holder: tuple(sorted(each for each in held[holder] if not each.endswith("Sliced")))
        for holder in sorted(static & held.keys())
    }


@cache
def _portable() -> frozenset[str]:
    return frozenset(each for inside in holders().values() for each in inside)


@cache
def plan(number: int) -> Plan:
    """A floor plan; fixtures that the package lists without a position get one on a point where one can stand."""
    layouts = package() / "gen" / "layouts"
    types = sorted(json.loads((layouts / f"FloorPlan{number}-objects.json").read_text(encoding="utf-8")))
    placed = json.loads((layouts / f"FloorPlan{number}-openable.json").read_text(encoding="utf-8"))
    points = [(float(x), float(z)) for x, z in np.load(layouts / f"FloorPlan{number}-layout.npy")]
    static = _constants().RECEPTACLES - _constants().MOVABLE_RECEPTACLES_SET
    found = []
    for id, pose in placed.items():
        base = id.split("|")[0]
        kind = _BASINS.get(base, base)
        if kind in static:
            found.append(Receptacle(id if kind == base else f"{id}|{kind}", kind, _location(*pose)))
    known = {each.type for each in found}
    rng = np.random.default_rng(number)
    for kind in types:
        if kind in static and kind not in known:
            for copy in range(_SEVERAL.get(kind, 1)):
                x, z = points[rng.integers(len(points))]
                id = f"{_BASE.get(kind, kind)}|{_metres(x)}|+00.90|{_metres(z + copy / 100)}"
                turn = 90 * int(rng.integers(4))
                found.append(Receptacle(f"{id}|{kind}" if kind in _BASE else id, kind, _location(x, z, turn, 30)))
    return Plan(number, tuple(sorted(found)), tuple(types), tuple(points))


def _metres(value: float) -> str:
    return f"{value:+06.2f}"


def _location(x: float, z: float, turn: float, tilt: float) -> str:
    """The name of a place to stand, as in ALFRED: steps of 25 cm, quarter turns, degrees of looking down."""
    return f"loc|{round(x / 0.25)}|{round(z / 0.25)}|{round(turn / 90)}|{round(tilt)}"


@cache
def _errands(number: int, task: str) -> tuple[tuple[str, str, str], ...]:
    """The types of object, destination and lamp of all tasks of a type that a floor plan allows."""
    here = plan(number)
    if _ROOMS[number // 100] not in _constants().GOALS_VALID[task]:
        return ()
    kinds = sorted({each.type for each in here.receptacles})
    # An object must have somewhere to lie that is not its destination.
    objects = [
        each
        for each in here.types
        if each in _portable() and sum(each in holders().get(kind, ()) for kind in kinds) >= 2
    ]
    if task == "look_at_obj_in_light":
        lit = "DeskLamp" in here.types and not set(kinds).isdisjoint(_LAMPS)
        return tuple((each, "", "DeskLamp") for each in objects) if lit else ()
    appliance, able = APPLIANCES.get(task, ("", ""))
    if appliance:
        objects = [each for each in objects if each in _constants().VAL_ACTION_OBJECTS[able]] * (appliance in kinds)
    return tuple(
        (each, kind, "")
        for each in objects
        for kind in kinds
        if each in holders().get(kind, ())
        and kind != appliance
        and any(each in holders().get(other, ()) for other in kinds if other not in (kind, appliance))
    )


@cache
def plans_for(task: str, split: str) -> tuple[int, ...]:
    """The floor plans that allow tasks of a type; those of `valid_unseen` are in no other split."""
    constants = _constants()
    numbers = {
        "all": constants.SCENE_NUMBERS,
        "valid_unseen": constants.TEST_SCENE_NUMBERS,
    }.get(split, constants.TRAIN_SCENE_NUMBERS)
    return tuple(number for number in sorted(numbers) if _errands(number, task))


def make(rng: np.random.Generator, task: str, split: str) -> Game:
    """A new game.

    Args:
        rng: what to draw from.
        task: the task's type; empty for any.
        split: the floor plans to draw from.
    """
    draws = iter(rng.random(_DRAWS).tolist())

    def pick(options: Sequence[_T]) -> _T:
        return options[int(next(draws) * len(options))]

    task = task or pick(TASKS)
    here = plan(pick(plans_for(task, split)))
    target, destination, lamp = pick(_errands(here.number, task))
    lying = _strew(here, task, target, destination, pick)
    x, z = pick(here.points)
    taken = {each.location for each in here.receptacles}
    start = _location(x, z, 90 * pick(range(4)), 30)
    while start in taken:
        x, z = pick(here.points)
        start = _location(x, z, 90 * pick(range(4)), 30)
    words = {"obj": target, "recep": destination, "toggle": lamp, "mrecep": ""}
    goal = pick(_goals()[task]["templates"]).format(**{key: each.lower() for key, each in words.items()})
    problem = _write(here, lying, start, target, _goal_pddl(task, words))
    return parse(problem, task, words, goal)


def _goal_pddl(task: str, words: dict[str, str]) -> str:
    return _goals()[task]["pddl"].format(**words).replace("#", "-")


class _Lying(NamedTuple):
    """An object and where it lies."""

    id: str
    type: str
    holder: Receptacle


def _strew(here: Plan, task: str, target: str, destination: str, pick: Callable[[Any], Any]) -> tuple[_Lying, ...]:
    """Put one to three objects of each type into receptacles that may hold them; the goal is not reached by it."""
    barred = {destination, APPLIANCES.get(task, ("",))[0]}
    least = 2 if task == "pick_two_obj_and_place" else 1
    lying: dict[str, _Lying] = {}
    for kind in here.types:
        if kind == "DeskLamp":
            where = [each for each in here.receptacles if each.type in _LAMPS]
            where = [each for each in where if each.type == "Desk"] or where
            count = 1
        elif kind in _portable():
            bar = barred if kind == target else ()
            where = [each for each in here.receptacles if kind in holders().get(each.type, ()) and each.type not in bar]
            count = max(least if kind == target else 1, pick(_COPIES))
        else:
            continue
        for _ in range(count if where else 0):
            holder = pick(where)
            _, x, y, z, *_ = holder.id.split("|")
            while True:
                spot = (_metres(float(x) + 0.6 * pick(_UNIT) - 0.3), _metres(float(y) + 0.05))
                id = f"{kind}|{spot[0]}|{spot[1]}|{_metres(float(z) + 0.6 * pick(_UNIT) - 0.3)}"
                if id not in lying:
                    break
            lying[id] = _Lying(id, kind, holder)
    return tuple(lying.values())


_UNIT = tuple(step / 1000 for step in range(1000))


def _name(id: str) -> str:
    """An id as a name in PDDL, as ALFRED writes it."""
    for character, word in (("-", "minus"), ("|", "bar"), ("+", "plus"), (".", "dot"), (",", "comma")):
        id = id.replace(character, f"_{word}_")
    return id


def _write(here: Plan, lying: tuple[_Lying, ...], start: str, target: str, goal: str) -> str:
    """A problem in PDDL. Four types of things must be declared since the domain names them."""
    constants = _constants()
    kinds = {each.type for each in lying} | {"Knife", "ButterKnife", target}
    holding = {each.type for each in here.receptacles} | {"SinkBasin", "Microwave", "Fridge"}
    places = sorted({each.location for each in here.receptacles} | {start})
    lines = [f"(define (problem plan_{here.number})", "(:domain alfred)", "(:objects", "agent1 - agent"]
    lines += [f"{each}Type - otype" for each in sorted(kinds)] + [f"{each}Type - rtype" for each in sorted(holding)]
    lines += [f"{_name(each.id)} - object" for each in sorted(lying)]
    lines += [f"{_name(each.id)} - receptacle" for each in here.receptacles]
    lines += [f"{_name(each)} - location" for each in places]
    lines += [")", "(:init", f"(atLocation agent1 {_name(start)})"]
    for each in here.receptacles:
        name = _name(each.id)
        lines += [f"(receptacleType {name} {each.type}Type)", f"(receptacleAtLocation {name} {_name(each.location)})"]
        if each.type in constants.OPENABLE_CLASS_SET:
            lines.append(f"(openable {name})")
    for holder in sorted({each.type for each in here.receptacles}):
        lines += [f"(canContain {holder}Type {each}Type)" for each in holders().get(holder, ()) if each in kinds]
    for each in lying:
        name = _name(each.id)
        lines += [f"(objectType {name} {each.type}Type)", f"(inReceptacle {name} {_name(each.holder.id)})"]
        lines.append(f"(objectAtLocation {name} {_name(each.holder.location)})")
        if each.type in _portable():
            lines.append(f"(pickupable {name})")
        if each.type in constants.MOVABLE_RECEPTACLES_SET:
            lines.append(f"(isReceptacleObject {name})")
        able = constants.VAL_ACTION_OBJECTS
        lines += [f"({predicate.lower()} {name})" for predicate in _PREDICATES if each.type in able[predicate]]
    return "\n".join([*lines, ")", goal])


_COMMENT = re.compile(r";[^\n]*")
_SECTIONS = re.compile(r"\(:objects(?P<objects>[^()]*)\).*?\(:init(?P<init>.*)(?P<goal>\(:goal.*)", re.DOTALL)
_ATOM = re.compile(r"\(([^()=]+)\)")
_NUMBERS = ("distance", "total-cost")


def parse(problem: str, task: str, words: dict[str, str], goal: str) -> Game:
    """The game of a problem in PDDL.

    Args:
        problem: the problem.
        task: the type of its task.
        words: the types `obj`, `recep`, `toggle` and `mrecep` of the task, empty where it has none.
        goal: the task in English.

    Raises:
        ValueError: it is no problem of this task.
    """
    found = _SECTIONS.search(_COMMENT.sub("", problem).lower())
    if found is None:
        raise ValueError("a PDDL problem must have :objects, :init and :goal, in this order")
    wanted = _goal_pddl(task, words).lower()
    if found["goal"].split() != wanted.split():
        raise ValueError(f"the problem's goal is not that of the task {task!r} with {words}")
    kinds = re.findall(r"(\S+)\s+-\s+(\S+)", found["objects"])
    facts = [tuple(atom.split()) for atom in _ATOM.findall(found["init"])]
    facts = [fact for fact in facts if fact[0] not in _NUMBERS]
    return Game(
        task,
        words["obj"].lower(),
        words["recep"].lower(),
        words["toggle"].lower(),
        goal,
        tuple(sorted(kinds)),
        frozenset(fact for fact in facts if fact[0] not in CHANGING),
        frozenset(fact for fact in facts if fact[0] in CHANGING),
        problem,
    )


@cache
def files(folder: str, task: str, split: str) -> tuple[Path, ...]:
    """The official game files below a folder, sorted; their folders' names tell split and task.

    Tasks with movable or sliced objects are left out, as ALFWorld leaves them out.
    """
    splits = SPLITS[1:] if split == "all" else (split,)
    found = [
        path
        for each in splits
        for path in Path(folder).glob(f"json_*/{each}/*/*/game.tw-pddl")
        if _task_of(path) in ((task,) if task else TASKS) and "Sliced" not in path.parts[-3]
    ]
    return tuple(sorted(found))


def _task_of(path: Path) -> str:
    return path.parts[-3].partition("-")[0]


def read(path: Path) -> Game | None:
    """The game in an official file, with `traj_data.json` beside it; None if it is known to be unsolvable.

    Raises:
        ValueError: it is no such file, or its rules are others than those of the installed package.
    """
    try:
        game = json.loads(path.read_text(encoding="utf-8"))
        trial = json.loads((path.parent / "traj_data.json").read_text(encoding="utf-8"))
        if not game.get("solvable", True):
            return None
        params = trial["pddl_params"]
        words = {key: params[f"{long}_target"] for key, long in _WORDS.items()}
        domain, grammar = rules()
        task = re.search(r"Your task is to: (.*?)\.\"", game["grammar"])
        if task is None or _bare(game["grammar"].replace(task[1], "UNKNOWN GOAL")) != _bare(grammar):
            raise ValueError("its grammar is not that of the installed alfworld package")
        if _bare(game["pddl_domain"]) != _bare(domain):
            raise ValueError("its domain is not that of the installed alfworld package")
        return parse(game["pddl_problem"], trial["task_type"], words, task[1])
    except (OSError, KeyError, TypeError, AttributeError, ValueError) as error:
        raise ValueError(
            f"{path} is no game that can be played here: {error!r}; allowed: game.tw-pddl with traj_data.json beside"
            " it, as `alfworld-download` of the installed version fetches them"
        ) from error


_WORDS = {"obj": "object", "recep": "parent", "toggle": "toggle", "mrecep": "mrecep"}


def _bare(code: str) -> list[str]:
    """Code without comments, space and case."""
    return _COMMENT.sub("", code).lower().split()


def drawn(rng: np.random.Generator, paths: tuple[Path, ...]) -> Game:
    """A random game of these files.

    Raises:
        ValueError: none of them can be played.
    """
    for path in _shuffled(rng, paths):
        game = read(path)
        if game is not None:
            return game
    raise ValueError(f"none of the {len(paths)} game files can be solved, the first being {paths[0]}")


def _shuffled(rng: np.random.Generator, paths: tuple[Path, ...]) -> Iterator[Path]:
    yield paths[rng.integers(len(paths))]
    for i in rng.permutation(len(paths)).tolist():
        yield paths[i]
