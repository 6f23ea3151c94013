"""The exact engine: ALFWorld's rules and texts in plain Python, equal to TextWorld's word for word.

The rules are those of `alfred.pddl` as the planner grounds them, oddities included: only held objects can be examined
(a comma in the domain prevents the other case from being grounded), "go to" needs another location, and a lamp counts
as turned on each time. As in TextWorld, facts that have become false are kept as `not_...`; the grammar uses them to
list objects beside a receptacle.
"""

from bisect import insort
from collections.abc import Callable
from typing import Any

from worlds.alfworld.games import Fact, Game
from worlds.alfworld.house import house_of

__all__ = ["AGENT", "KNIVES", "NOTHING", "USES", "ExactEngine"]

_Do = tuple[Callable[..., str], tuple[str, ...]]  # the method of a command, and its arguments

AGENT = "agent1"
NOTHING = "Nothing happens."
"""The answer to a command that cannot be carried out."""
USES = {
    "clean": ("sinkbasintype", "cleanable", "isclean", ""),
    "heat": ("microwavetype", "heatable", "ishot", "cool"),
    "cool": ("fridgetype", "coolable", "iscool", "heat"),
}
"""For each verb: type of appliance, predicate of its objects, predicate that it makes true, verb that it undoes."""
KNIVES = ("knifetype", "butterknifetype")
"""The types of objects that can slice others."""
_HELP = (
    "Available commands:\n"
    "  look:                             look around your current location\n"
    "  inventory:                        check your current inventory\n"
    "  go to (receptacle):               move to a receptacle\n"
    "  open (receptacle):                open a receptacle\n"
    "  close (receptacle):               close a receptacle\n"
    "  take (object) from (receptacle):  take an object from a receptacle\n"
    "  move (object) to (receptacle):  place an object in or on a receptacle\n"
    "  examine (something):              examine a receptacle or an object\n"
    "  use (object):                     use an object\n"
    "  heat (object) with (receptacle):  heat an object using a receptacle\n"
    "  clean (object) with (receptacle): clean an object using a receptacle\n"
    "  cool (object) with (receptacle):  cool an object using a receptacle\n"
    "  slice (object) with (object):     slice an object using a sharp object\n"
)
_LOOKS = (  # descriptions of an object in the hand, each with the predicates that it requires; the first match counts
    (("isclean", "ishot", "issliced"), "This is a hot and clean sliced {}."),
    (("isclean", "iscool", "issliced"), "This is a cool and clean sliced {}."),
    (("isclean", "issliced"), "This is a clean sliced {}."),
    (("ishot", "issliced"), "This is a hot sliced {}."),
    (("iscool", "issliced"), "This is a cool sliced {}."),
    (("isclean", "ishot"), "This is a hot and clean {}."),
    (("isclean", "iscool"), "This is a cool and clean {}."),
    (("ishot",), "This is a hot {}."),
    (("isclean",), "This is a clean {}."),
    (("iscool",), "This is a cold {}."),
    (("toggleable", "istoggled"), "This {} is on."),
    (("toggleable", "not_istoggled"), "This {} is off."),
    (("sliceable", "issliced"), "This is a sliced {}."),
)


class ExactEngine:
    """The state of a house, and the effects of commands.

    Args:
        game: the game to play, from its start.
    """

    def __init__(self, game: Game) -> None:
        self.game = game
        self.house = house_of(game)
        self.location = ""
        self.held: list[str] = []
        self.inside: dict[str, list[str]] = {each: [] for each in self.house.receptacles}
        """For each receptacle, its contents, sorted."""
        self._facts: set[Fact] = set()
        self._near: dict[str, set[str]] = {}
        self._here: dict[str, _Do] | None = None  # possible commands except "go to"; None: not computed yet
        self.load(game.start)

    @property
    def facts(self) -> frozenset[Fact]:
        """The true facts of `CHANGING` predicates, and those that have become false, as `not_...`."""
        return frozenset(self._facts)

    def load(self, facts: frozenset[Fact]) -> None:
        """Load a state; the time depends on its differences to the current one."""
        gone, new = self._facts - facts, facts - self._facts
        for fact in gone:
            predicate = fact[0]
            if predicate == "inreceptacle":
                self.inside[fact[2]].remove(fact[1])
            elif predicate == "objectatlocation":
                self._near[fact[2]].remove(fact[1])
            elif predicate == "atlocation":
                self.location = ""
            elif predicate == "holds":
                self.held.remove(fact[2])
        for fact in new:
            predicate = fact[0]
            if predicate == "inreceptacle":
                insort(self.inside[fact[2]], fact[1])
            elif predicate == "objectatlocation":
                self._near.setdefault(fact[2], set()).add(fact[1])
            elif predicate == "atlocation":
                self.location = fact[2]
            elif predicate == "holds":
                self.held.append(fact[2])
        self._facts -= gone
        self._facts |= new
        self._here = None

    def intro(self) -> str:
        """The introduction to the game."""
        seen = self._look(self.location)
        if self.location not in self.house.at:
            seen = f"{_MIDDLE}{self._listed(self.house.place)}."
        return f"-= Welcome to TextWorld, ALFRED! =-\n\n{seen}\n\nYour task is to: {self.game.goal}."

    def commands(self) -> list[str]:
        """The commands that can be carried out, sorted."""
        return sorted([*self.house.ways_from(self.location), *(self._here or self._offer())])

    def do(self, command: str) -> str:
        """Carry out a command; returns the answer."""
        way = self.house.ways.get(command)
        if way is None:
            offer = (self._here or self._offer()).get(command)
        else:
            offer = (self._go, way) if way[1] != self.location else None
        if offer is None:
            return NOTHING
        act, arguments = offer
        self._here = None
        return act(*arguments)

    def won(self) -> bool:
        """Whether the goal is reached in the current state."""
        return _GOALS[self.game.task](self)

    def has(self, predicate: str, id: str) -> bool:
        """Whether a predicate of one argument, static or not, is true of something."""
        return (predicate, id) in self._facts or id in self.house.able_to(predicate)

    def open(self, receptacle: str) -> bool:
        """Whether a receptacle is open, or cannot be closed."""
        return receptacle not in self.house.openable or ("opened", receptacle) in self._facts

    def _offer(self) -> dict[str, _Do]:
        """Compute the possible commands except "go to"."""
        house, name, location = self.house, self.house.name, self.location
        offers: dict[str, _Do] = {
            "help": (self._help, ()),
            "inventory": (self._inventory, ()),
            "look": (self._look_around, ()),
        }
        hand = self.held[0] if self.held else ""
        pickupable, toggleable = house.able_to("pickupable"), house.able_to("toggleable")
        for receptacle in house.at.get(location, ()):
            there = name[receptacle]
            offers[f"examine {there}"] = self._examine_receptacle, (receptacle,)
            within_reach = True
            if receptacle in house.openable:
                within_reach = ("opened", receptacle) in self._facts
                if within_reach:
                    offers[f"close {there}"] = self._close, (receptacle,)
                else:
                    offers[f"open {there}"] = self._open, (receptacle,)
            for each in self.inside[receptacle]:
                if each in toggleable:
                    offers[f"use {name[each]}"] = self._use, (each,)
                if within_reach and not hand and each in pickupable:
                    offers[f"take {name[each]} from {there}"] = self._take, (each, receptacle)
            if hand:
                kind = house.type.get(receptacle, "")
                if within_reach and (kind, house.type.get(hand, "")) in house.holds:
                    offers[f"move {name[hand]} to {there}"] = self._move, (hand, receptacle)
                for verb, (appliance, able, _, _) in USES.items():
                    if kind == appliance and hand in house.able_to(able):
                        offers[f"{verb} {name[hand]} with {there}"] = self._treat, (verb, hand, receptacle)
        if hand:
            offers[f"examine {name[hand]}"] = self._examine_object, (hand,)
            if house.type.get(hand) in KNIVES:
                sliceable = house.able_to("sliceable")
                for each in self._near.get(location, ()):
                    if each in sliceable:
                        offers[f"slice {name[each]} with {name[hand]}"] = self._slice, (each, hand)
        self._here = offers
        return offers

    def _add(self, *fact: str) -> None:
        self._facts.add(fact)
        self._facts.discard((f"not_{fact[0]}", *fact[1:]))

    def _delete(self, *fact: str) -> None:
        self._facts.discard(fact)
        self._facts.add((f"not_{fact[0]}", *fact[1:]))

    def _help(self) -> str:
        self._add("checked", AGENT)
        return _HELP

    def _inventory(self) -> str:
        self._add("checked", AGENT)
        return f"You are carrying: {self._listed(self.held)}." if self.held else "You are not carrying anything."

    def _look_around(self) -> str:
        self._add("checked", self.location)
        return self._look(self.location)

    def _look(self, location: str) -> str:
        here = self.house.at.get(location, ())
        if not here:
            return f"{_MIDDLE}nothing."
        beside = [
            each
            for each in sorted(self._near.get(location, ()))
            for receptacle in here
            if ("not_inreceptacle", each, receptacle) in self._facts
        ]
        facing = _enumerated([self.house.name[each] for each in here])
        return f"You are facing the {facing}. Next to it, you see {self._listed(beside)}."

    def _go(self, receptacle: str, location: str) -> str:
        self._delete("atlocation", AGENT, self.location)
        self._add("atlocation", AGENT, location)
        self.location = location
        return f"You arrive at {self.house.name[receptacle]}. {self._seen(receptacle)}"

    def _open(self, receptacle: str) -> str:
        self._add("opened", receptacle)
        self._add("checked", receptacle)
        return f"You open the {self.house.name[receptacle]}. {self._seen(receptacle)}"

    def _close(self, receptacle: str) -> str:
        self._delete("opened", receptacle)
        return f"You close the {self.house.name[receptacle]}."

    def _examine_receptacle(self, receptacle: str) -> str:
        self._add("checked", receptacle)
        return self._seen(receptacle)

    def _seen(self, receptacle: str) -> str:
        name = self.house.name[receptacle]
        if receptacle not in self.house.openable:
            return f"On the {name}, you see {self._listed(self.inside[receptacle])}."
        if not self.open(receptacle):
            return f"The {name} is closed."
        return f"The {name} is open. In it, you see {self._listed(self.inside[receptacle])}."

    def _examine_object(self, each: str) -> str:
        self._add("checked", each)
        name = self.house.name[each]
        if self.has("isreceptacleobject", each):
            return f"This is a normal {name}. In it, you see {self._listed(self.house.within.get(each, []))}."
        for predicates, text in _LOOKS:
            if all(self.has(predicate, each) for predicate in predicates):
                return text.format(name)
        return f"There's nothing special about {name}."

    def _take(self, each: str, receptacle: str) -> str:
        self._delete("inreceptacle", each, receptacle)
        self._add("holds", AGENT, each)
        self._add("holdsany", AGENT)
        self._delete("objectatlocation", each, self.location)
        self.held.append(each)
        self.inside[receptacle].remove(each)
        self._near.get(self.location, set()).discard(each)
        return f"You pick up the {self.house.name[each]} from the {self.house.name[receptacle]}."

    def _move(self, each: str, receptacle: str) -> str:
        self._add("inreceptacle", each, receptacle)
        self._add("objectatlocation", each, self.location)
        self._delete("holds", AGENT, each)
        self._delete("holdsany", AGENT)
        self.held.remove(each)
        self.inside[receptacle] = sorted({*self.inside[receptacle], each})
        self._near.setdefault(self.location, set()).add(each)
        return f"You move the {self.house.name[each]} to the {self.house.name[receptacle]}."

    def _treat(self, verb: str, each: str, receptacle: str) -> str:
        _, _, made, undone = USES[verb]
        self._add(made, each)
        if undone:
            appliance, able, unmade, _ = USES[undone]
            # The planner drops facts that can never become true, so that they do not become false either.
            if (each in self.house.able_to(able) and appliance in self.house.kinds) or (
                unmade,
                each,
            ) in self.game.start:
                self._delete(unmade, each)
        return f"You {verb} the {self.house.name[each]} using the {self.house.name[receptacle]}."

    def _use(self, each: str) -> str:
        self._delete("ison", each)  # TextWorld applies both cases of the effect, this one last
        self._add("istoggled", each)
        return f"You turn on the {self.house.name[each]}."

    def _slice(self, each: str, knife: str) -> str:
        self._add("issliced", each)
        return f"You sliced the {self.house.name[each]} with the {self.house.name[knife]}."

    def _listed(self, ids: Any) -> str:
        return _enumerated([f"a {self.house.name[each]}" for each in ids])

    def _goal_objects(self) -> list[str]:
        target = f"{self.game.target}type"
        return [each for each in self.house.objects if self.house.type.get(each) == target]

    def _stored(self) -> list[list[str]]:
        """For each receptacle of the destination's type, the objects of the target's type in it."""
        kind, target = f"{self.game.destination}type", f"{self.game.target}type"
        types = self.house.type
        return [
            [each for each in inside if types.get(each) == target]
            for receptacle, inside in self.inside.items()
            if types.get(receptacle) == kind
        ]

    def _placed(self, *predicates: str) -> bool:
        return any(all(self.has(p, each) for p in predicates) for inside in self._stored() for each in inside)

    def _lit(self) -> bool:
        house, lamp = self.house, f"{self.game.lamp}type"
        return any(house.type.get(each) == f"{self.game.target}type" for each in self.held) and any(
            house.type.get(each) == lamp and self.has("toggleable", each) and self.has("istoggled", each)
            for receptacle in house.at.get(self.location, ())
            for each in self.inside[receptacle]
        )


_MIDDLE = "You are in the middle of a room. Looking quickly around you, you see "
_GOALS: dict[str, Callable[[ExactEngine], bool]] = {
    "pick_and_place_simple": lambda engine: engine._placed(),
    "look_at_obj_in_light": ExactEngine._lit,
    "pick_clean_then_place_in_recep": lambda engine: engine._placed("cleanable", "isclean"),
    "pick_heat_then_place_in_recep": lambda engine: engine._placed("heatable", "ishot"),
    "pick_cool_then_place_in_recep": lambda engine: engine._placed("coolable", "iscool"),
    "pick_two_obj_and_place": lambda engine: any(len(inside) > 1 for inside in engine._stored()),
}


def _enumerated(words: list[str]) -> str:
    """A list as text, with a comma before `and` even for two items."""
    if len(words) < 2:
        return words[0] if words else "nothing"
    return f"{', '.join(words[:-1])}, and {words[-1]}"
