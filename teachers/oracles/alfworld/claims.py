"""The claims about commands, each checked by carrying them out in the lab and searching from there."""

from collections.abc import Callable, Sequence, Set
from functools import lru_cache
from typing import Annotated, Any, ClassVar

from typing_extensions import override

from teachers.atoms import (
    FN,
    FP,
    HN,
    HP,
    ActionClaim,
    Claim,
    HintClaim,
    Moment,
    PlanClaim,
    Scope,
    Verdict,
    claim,
    opposed,
    slot,
)
from teachers.oracles.alfworld.search import IDLE, distance, thing_of, verb_of
from teachers.rules import TownRule
from teachers.words import article
from worlds.alfworld import Alfworld, Truth
from worlds.alfworld.exact import AGENT, NOTHING, USES, ExactEngine
from worlds.alfworld.games import Game
from worlds.alfworld.generated import keepers
from worlds.alfworld.house import House, house_of
from worlds.alfworld.plans import APPLIANCES


@claim
class Task(Claim[Truth, Alfworld]):
    """True if the task is what `goal` says."""

    goal: str

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Read the house's own words at the start, and win by treating the named things."""
        game = moment.after.game
        if not ExactEngine(game).intro().endswith(f"Your task is to: {self.goal}."):
            return False
        return all(each in self.goal for each in (game.target, game.destination, game.lamp))


@claim
class Commands(Claim[Truth, Alfworld]):
    """True if these are the forms of all commands that the house knows."""

    forms: tuple[str, ...]
    listing = slot(", ".join, "forms")

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Ask for help in the house itself."""
        lab.restore(moment.after)
        lab.advance("help")
        forms = [line.split(":")[0].strip() for line in lab.truth.feedback.splitlines()[1:]]
        return sorted(self.forms) == sorted(["help", *forms])


@claim
class Listed(Claim[Truth, Alfworld]):
    """True if the observation lists the commands that can be carried out, and others come to nothing."""

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Try them all."""
        lab.restore(moment.after)
        observation, _, _, _, info = lab.advance("help")
        commands = info["admissible_commands"]
        return (
            observation.endswith(", ".join(commands))
            and all(_answer(lab, moment.after, command) != NOTHING for command in commands)
            and _answer(lab, moment.after, "go nowhere") == NOTHING
        )


@claim
class _Command(ActionClaim[Truth, Alfworld]):
    action: str


@claim
class _Tried(Verdict[Truth, Alfworld], _Command):
    tried = True

    def applies(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Any first command can be judged."""
        return True

    def good(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Carry it out and search from there."""
        game = moment.after.game
        return _gain(lab, Truth(game.start, "", False, game), self.action) > 0


@claim
class TriedWell(_Tried):
    """True if `action`, as the first command, brings the task nearer."""

    kind = HP


@claim
class TriedInVain(_Tried):
    """True if `action`, as the first command, brings the task no nearer."""

    kind = HN


opposed(TriedWell, TriedInVain)


@claim
class Route(PlanClaim[Truth, Alfworld]):
    """True if these commands, in this order, do the task from here, and no shorter sequence does."""

    actions: tuple[str, ...]
    listing = slot(PlanClaim.separator.join, "actions")

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Carry them out, and search for the length of a shortest plan."""
        if len(self.actions) != distance(moment.after):
            return False
        lab.restore(moment.after)
        successes = [lab.advance(action)[4]["success"] for action in self.actions]
        return successes[-1:] == [True] and True not in successes[:-1]


@claim
class Done(_Command):
    """True if this command has done the task."""

    kind = HP

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Carry it out again."""
        if not _made(self.action, moment):
            return False
        lab.restore(moment.past)
        return bool(lab.advance(self.action)[4]["success"])

    def counterparts(self, moment: Moment[Truth], lab: Alfworld) -> Sequence[Claim]:
        """Deny it."""
        return (NoNearer(action=self.action),)


@claim
class Nearer(_Command):
    """True if this command has brought the task nearer: fewer commands than before are needed, namely `left`."""

    kind = HP
    left: int
    """Commands that are still needed."""

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Carry it out again and search from there."""
        nearer = _made(self.action, moment) and _gain(lab, moment.past, self.action) > 0
        return nearer and distance(moment.after) == self.left

    def counterparts(self, moment: Moment[Truth], lab: Alfworld) -> Sequence[Claim]:
        """The opposite verdict, or another number."""
        return (NoNearer(action=self.action), Nearer(action=self.action, left=self.left + 1))


@claim
class NoNearer(_Command):
    """True if this command has not brought the task nearer: as many commands as before are needed, or more."""

    kind = HN

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Carry it out again and search from there."""
        return _made(self.action, moment) and _gain(lab, moment.past, self.action) <= 0

    def counterparts(self, moment: Moment[Truth], lab: Alfworld) -> Sequence[Claim]:
        """The opposite verdict."""
        return (Nearer(action=self.action, left=distance(moment.after)),)


@claim
class Refused(_Command):
    """True if this command could not be carried out, so that nothing happened."""

    kind = HN

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Try it again."""
        before = moment.before
        if before is None or moment.action != self.action:
            return False
        lab.restore(before)
        listed = self.action in lab.commands()
        lab.advance(self.action)
        return not listed and lab.truth.facts == before.facts and lab.truth.feedback == NOTHING

    def counterparts(self, moment: Moment[Truth], lab: Alfworld) -> Sequence[Claim]:
        """Praise it."""
        return (Nearer(action=self.action, left=distance(moment.after)),)


@claim
class Do(_Command):
    """True if `action` begins a shortest plan for a task not yet done; every tied plan counts."""

    kind = FP

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Carry it out and search from there."""
        return not moment.after.won and _gain(lab, moment.after, self.action) > 0

    def counterparts(self, moment: Moment[Truth], lab: Alfworld) -> Sequence[Claim]:
        """Recommend other commands."""
        others = [each for each in _commands(lab, moment.after) if each != self.action]
        return tuple(Do(action=each) for each in others[:: max(1, len(others) // _OTHERS)])

    def coarser(self, moment: Moment[Truth], lab: Alfworld) -> Sequence[Claim]:
        """The command's verb, then what it is about."""
        thing = thing_of(self.action)
        return (DoVerb(verb=verb_of(self.action)), *((DoAbout(thing=thing),) if thing else ()))


@claim
class DoVerb(HintClaim[Truth, Alfworld]):
    """True if a shortest plan begins with a command that starts with `verb`."""

    kind = FP
    verb: str
    counterparts = Claim.varied("verb", ("go", "open", "take", "move"))

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Carry all such commands out and search from there."""
        return _some(lab, moment.after, lambda command: verb_of(command) == self.verb)

    @override
    def leaves(self, action: str) -> bool:
        return verb_of(action) == self.verb


@claim
class DoAbout(HintClaim[Truth, Alfworld]):
    """True if a shortest plan begins with a command that names `thing`."""

    kind = FP
    thing: str

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Carry all such commands out and search from there."""
        return _some(lab, moment.after, lambda command: thing_of(command) == self.thing)

    @override
    def leaves(self, action: str) -> bool:
        return thing_of(action) == self.thing

    def counterparts(self, moment: Moment[Truth], lab: Alfworld) -> Sequence[Claim]:
        """Something else."""
        things = {thing_of(each): None for each in _commands(lab, moment.after)}
        return tuple(DoAbout(thing=thing) for thing in things if thing not in ("", self.thing))[:_OTHERS]


@claim
class Avoid(_Command):
    """True if `action` can be carried out, and does not begin a shortest plan for a task not yet done."""

    kind = FN

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Carry it out and search from there."""
        if moment.after.won or _answer(lab, moment.after, self.action) == NOTHING:
            return False
        return _gain(lab, moment.after, self.action) <= 0

    def counterparts(self, moment: Moment[Truth], lab: Alfworld) -> Sequence[Claim]:
        """Warn of what is right."""
        wanted = (each for each in _commands(lab, moment.after) if verb_of(each) not in IDLE)
        return tuple(Avoid(action=each) for each in wanted if _gain(lab, moment.after, each) > 0)[:1]


@claim
class Try(_Command):
    """True if, going by what has been seen, `action` is a step forward, as `_forward` says."""

    kind = FP

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Carry it out and look, or search the part of the house that has been seen."""
        return not moment.after.won and _forward(lab, moment.after, self.action)

    def counterparts(self, moment: Moment[Truth], lab: Alfworld) -> Sequence[Claim]:
        """Recommend commands that show nothing."""
        return tuple(Try(action=action) for action in ("inventory", "look", "help"))


@claim
class Needless(_Command):
    """True if `action` can be carried out and, going by what has been seen, is no step forward."""

    kind = FN

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Carry it out and look, or search the part of the house that has been seen."""
        truth = moment.after
        return not (truth.won or _answer(lab, truth, self.action) == NOTHING or _forward(lab, truth, self.action))

    def counterparts(self, moment: Moment[Truth], lab: Alfworld) -> Sequence[Claim]:
        """Warn of what is right."""
        wanted = (each for each in _commands(lab, moment.after) if verb_of(each) not in IDLE)
        return tuple(Needless(action=each) for each in wanted if _forward(lab, moment.after, each))[:1]


@claim
class _Sighted(Verdict[Truth, Alfworld], _Command):
    def applies(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """The student gave the command, and the task was not yet done."""
        return _made(self.action, moment)

    def good(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Carry it out again and look, or search the part of the house that had been seen."""
        return _forward(lab, moment.past, self.action)


@claim
class Forward(_Sighted):
    """True if, going by what had been seen, this command was a step forward."""

    kind = HP


@claim
class NotForward(_Sighted):
    """True if, going by what had been seen, this command was no step forward."""

    kind = HN


opposed(Forward, NotForward)


@claim
class Treat(Claim[Truth, Alfworld]):
    """True if a `thing` counts where the task wants it put only if this was done to it before, such as `heat`."""

    kind = FP
    scope = Scope.WORLD
    thing: str
    verb: Annotated[str, (*USES,)]
    counterparts = Claim.varied("verb", USES)

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Put one there untreated, and treated."""
        game = moment.after.game
        engine, fact = ExactEngine(game), USES[self.verb][2]
        house = engine.house
        things = [each for each in house.objects if house.type[each] == f"{self.thing}type" and each in _lying(engine)]
        ends = [each for each in house.receptacles if house.type[each] == f"{game.destination}type"]
        if not things or not ends:
            return False
        put = {each for each in game.start if each[0] != "inreceptacle" or each[1] != things[0]}
        put.add(("inreceptacle", things[0], ends[0]))
        engine.load(frozenset(put))
        before = engine.won()
        engine.load(frozenset(put | {(fact, things[0])}))
        return engine.won() and not before

    def excludes(self, other: Claim) -> bool:
        """Another treatment."""
        return isinstance(other, Treat) and other.verb != self.verb


@claim
class _Kept(Claim[Truth, Alfworld]):
    """Base of claims about where a kind of thing lay when the task was given."""

    scope = Scope.WORLD
    thing: str
    place: str
    """Kind of receptacle, such as `drawer`."""
    counterparts = Claim.varied(
        "place", lambda _, moment, __: sorted({name.rpartition(" ")[0] for name in _contents(moment.after)})
    )

    def _found(self, moment: Moment[Truth]) -> list[bool]:
        """Whether a `thing` lay there, for each `place` of the house."""
        places = _contents(moment.after).items()
        return [self.thing in things for name, things in places if name.rpartition(" ")[0] == self.place]


@claim
class NotKept(_Kept):
    """True if no `thing` lay in or on a `place`, of which the house has some, when the task was given."""

    kind = FN

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Look into all of them."""
        found = self._found(moment)
        return bool(found) and not any(found)


@claim
class Kept(_Kept):
    """True if a `thing` lay in or on a `place` when the task was given."""

    kind = FP
    one, place_one = slot(article, "thing"), slot(article, "place")

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Look into all of them."""
        return any(self._found(moment))

    def excludes(self, other: Claim) -> bool:
        """That there was none."""
        return isinstance(other, NotKept) and (other.thing, other.place) == (self.thing, self.place)


@claim
class _Shut(Claim[Truth, Alfworld]):
    """Base of claims about whether a kind of thing lay in something that has to be opened."""

    scope = Scope.WORLD
    kind = FP
    thing: str
    one = slot(article, "thing")
    opens: ClassVar[bool]

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Look into all that can be opened, or into all else."""
        house = house_of(moment.after.game)
        able = {house.name[each] for each in house.able_to("openable")}
        return any(
            self.thing in things and (name in able) == self.opens for name, things in _contents(moment.after).items()
        )

    def counterparts(self, moment: Moment[Truth], lab: Alfworld) -> Sequence[Claim]:
        """The opposite claim."""
        return ((InTheOpen if self.opens else ShutIn)(thing=self.thing),)


@claim
class ShutIn(_Shut):
    """True if a `thing` lay in something that can be opened when the task was given."""

    opens = True


@claim
class InTheOpen(_Shut):
    """True if a `thing` lay where nothing has to be opened when the task was given."""

    opens = False


def _contents(truth: Truth) -> dict[str, list[str]]:
    """The kinds of things in each place, by its name, when the task was given."""
    engine = ExactEngine(truth.game)
    name = engine.house.name
    return {name[place]: [name[each].rpartition(" ")[0] for each in inside] for place, inside in engine.inside.items()}


def _lying(engine: ExactEngine) -> set[str]:
    return {each for inside in engine.inside.values() for each in inside}


_OTHERS = 6


def _made(action: str, moment: Moment[Truth]) -> bool:
    return moment.before is not None and not moment.before.won and moment.action == action


def _commands(lab: Alfworld, truth: Truth) -> list[str]:
    lab.restore(truth)
    return lab.commands()


def _answer(lab: Alfworld, truth: Truth, command: str) -> str:
    lab.restore(truth)
    lab.advance(command)
    return str(lab.truth.feedback)


def _gain(lab: Alfworld, truth: Truth, command: str) -> int:
    """By how many commands a command shortens a shortest plan, found by search."""
    lab.restore(truth)
    lab.advance(command)
    after = lab.truth
    return distance(truth) - distance(after)


def seen(truth: Truth, house: House) -> frozenset[str]:
    """The receptacles whose contents the student must have seen, by the facts.

    At a location with several receptacles an arrival shows only one of them; there, the opened or examined ones count.
    """
    facts = truth.facts
    visited = {fact[2] for fact in facts if fact[0] in ("atlocation", "not_atlocation")}
    shown = []
    for receptacle, location in house.place.items():
        if location in visited:
            if receptacle in house.openable:
                known = ("opened", receptacle) in facts or ("not_opened", receptacle) in facts
            else:
                known = len(house.at[location]) == 1 or ("checked", receptacle) in facts
            if known:
                shown.append(receptacle)
    return frozenset(shown)


def visible_part(truth: Truth, house: House) -> Truth:
    """The truth without the contents of receptacles that the student has not looked into."""
    known = seen(truth, house)
    facts = (fact for fact in truth.facts if fact[0] != "inreceptacle" or fact[2] in known)
    return truth._replace(facts=frozenset(facts))


def _forward(lab: Alfworld, truth: Truth, command: str) -> bool:
    """Whether a command begins a shortest plan in the part of the house that the student has seen.

    If that part is not enough for the task: whether the command shows the content of a new receptacle, or leads to one.
    """
    house = house_of(truth.game)
    visible = visible_part(truth, house)
    try:
        left = distance(visible)
    except ValueError:
        lab.restore(truth)
        here = lab.truth
        lab.advance(command)
        there = lab.truth
        if seen(there, house) > seen(here, house):
            return True
        place = next(fact[2] for fact in there.facts if fact[0] == "atlocation")
        moved = ("atlocation", AGENT, place) not in here.facts
        return moved and not seen(there, house).issuperset(house.at.get(place, ()))
    lab.restore(visible)
    lab.advance(command)
    return distance(lab.truth) < left


def _some(lab: Alfworld, truth: Truth, fits: Callable[[str], bool]) -> bool:
    return not truth.won and any(fits(each) and _gain(lab, truth, each) > 0 for each in _commands(lab, truth))


@claim
class _Keeping(TownRule[Truth, Alfworld]):
    """Base of rules about where objects of a type are kept."""

    thing: str
    """Type of object, such as `mug`."""
    place: str
    """Type of receptacle, such as `cabinet`."""
    place_one = slot(article, "place")

    def fits(self, truth: Truth) -> bool | None:
        """Look where these objects are at the start."""
        game = truth.game
        places, lying = _strewn(game)
        own = lying.get(self.thing)
        if not own or self.place not in places or (self.thing == game.target and self.place in _barred(game)):
            return None
        return own == {self.place}

    def means(self, moment: Moment[Truth], oracle: Any) -> bool:
        """Read the law."""
        law = moment.after.game.law
        return bool(law) and ((self.thing, self.place) in law) == (self.kind is FP)

    def counterparts(self, moment: Moment[Truth], lab: Alfworld) -> Sequence[Claim]:
        """Another type of receptacle, of which houses of the town can tell."""
        others = (type(self)(thing=self.thing, place=place) for place in keepers()[self.thing] if place != self.place)
        return tuple(each for each in others if each.shown(moment, lab) - {None})


@claim
class AlwaysKept(_Keeping):
    """True if in each house of the town that has a `place`, each `thing` is there at the start.

    A `thing` that the task takes to such a place is excepted.
    """

    kind = FP

    def excludes(self, other: Claim) -> bool:
        """Another place, or the contrary."""
        return (
            isinstance(other, _Keeping)
            and other.thing == self.thing
            and isinstance(other, AlwaysKept) == (other.place != self.place)
        )


@claim
class NotAlwaysKept(_Keeping):
    """True if in some house of the town that has a `place`, a `thing` is not there at the start.

    A `thing` that the task takes to such a place does not count.
    """

    kind = FN

    def holds(self, moment: Moment[Truth], lab: Alfworld) -> bool:
        """Look for such a house."""
        return False in self.shown(moment, lab)


def _barred(game: Game) -> tuple[str, str]:
    """The types of receptacles where the task puts its objects; at the start the objects are elsewhere."""
    return game.destination, APPLIANCES.get(game.task, ("",))[0].lower()


@lru_cache(maxsize=2048)
def _strewn(game: Game) -> tuple[Set[str], dict[str, set[str]]]:
    """A house's types of receptacles, and for each type of object the types that hold one at the start."""
    types = {fact[1]: fact[2].removesuffix("type") for fact in game.static if fact[0] in _TYPED}
    lying: dict[str, set[str]] = {}
    for fact in game.start:
        if fact[0] == "inreceptacle":
            lying.setdefault(types[fact[1]], set()).add(types[fact[2]])
    return {types[fact[1]] for fact in game.static if fact[0] == "receptacletype"}, lying


_TYPED = ("receptacletype", "objecttype")
