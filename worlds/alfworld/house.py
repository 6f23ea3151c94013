"""The constant facts about a house, indexed for look-up."""

from collections import Counter
from functools import lru_cache
from itertools import chain

from worlds.alfworld.games import Game

__all__ = ["House", "house_of", "names"]


def names(ids: list[str]) -> dict[str, str]:
    """The names of things, such as `apple 2`, numbered within each type in descending order of ids.

    Ids without a position, such as the agent's, are names with a space appended, as in ALFWorld.
    """
    parts = {id: id.split("_bar_", 1) for id in ids}
    bases = {id: base[0] + ("basin" if "basin" in id else "") if len(base) > 1 else "" for id, base in parts.items()}
    left = Counter(base for base in bases.values() if base)
    called = {}
    for id in sorted(ids):
        base = bases[id]
        if not base:
            called[id] = f"{id} "
            continue
        called[id] = f"{base} {left[base]}"
        left[base] -= 1
    return called


class House:
    """The constant facts about a house, indexed for look-up."""

    def __init__(self, game: Game) -> None:
        self.game = game
        known = {*chain.from_iterable(game.static), *chain.from_iterable(game.start)}  # and names of predicates
        self.name = names([id for id, _ in game.kinds if id in known])
        """The name of each id."""
        of = {"receptacle": {}, "object": {}}  # type: dict[str, dict[str, str]]
        self.type: dict[str, str] = {}
        """The type of each receptacle and object, such as `fridgetype`."""
        self.place: dict[str, str] = {}
        """The location from which each receptacle is used."""
        self.holds: set[tuple[str, str]] = set()
        """Pairs of a type of receptacle and a type of object that it may contain."""
        self.able: dict[str, set[str]] = {}
        """For each predicate of one argument, the ids for which it is true."""
        self.within: dict[str, list[str]] = {}
        """For each object, its constant contents."""
        for fact in game.static:
            predicate = fact[0]
            if predicate in ("receptacletype", "objecttype"):
                self.type[fact[1]] = fact[2]
            elif predicate == "receptacleatlocation":
                self.place[fact[1]] = fact[2]
            elif predicate == "cancontain":
                self.holds.add((fact[1], fact[2]))
            elif predicate == "inreceptacleobject":
                self.within.setdefault(fact[2], []).append(fact[1])
            elif len(fact) == 2:
                self.able.setdefault(predicate, set()).add(fact[1])
        self.place = dict(sorted(self.place.items()))
        for inside in self.within.values():
            inside.sort()
        for id, kind in game.kinds:
            if kind in of and id in known:
                of[kind][id] = ""
        self.receptacles = tuple(of["receptacle"])
        """The ids with this type, sorted like all lists of ids here: TextWorld's order."""
        self.objects = tuple(of["object"])
        self.at: dict[str, tuple[str, ...]] = {}
        """For each location, the receptacles that are used from there."""
        for receptacle, location in self.place.items():
            self.at[location] = (*self.at.get(location, ()), receptacle)
        self.kinds = {self.type.get(each, "") for each in self.place}
        """Types of the receptacles that can be used."""
        self.openable = self.able.get("openable", set())
        self.ways = {f"go to {self.name[each]}": (each, location) for each, location in self.place.items()}
        """For each "go to" command, the receptacle and its location."""
        self._ways_from: dict[str, tuple[str, ...]] = {}
        self.id = {name: id for id, name in self.name.items()}
        """The id of each name."""

    def able_to(self, predicate: str) -> set[str]:
        """The ids for which a static predicate of one argument is true."""
        return self.able.get(predicate, set())

    def ways_from(self, location: str) -> tuple[str, ...]:
        """The "go to" commands from a location, sorted."""
        ways = self._ways_from.get(location)
        if ways is None:
            ways = tuple(sorted(way for way, (_, there) in self.ways.items() if there != location))
            self._ways_from[location] = ways
        return ways


@lru_cache(maxsize=4)
def house_of(game: Game) -> House:
    """The house of a game, shared by the engines that play it."""
    return House(game)
