"""What is said about commands, each checked by carrying them out and searching from there."""

from collections.abc import Callable, Sequence

from teachers.atoms import FN, FP, HN, HP, Claim, Moment, claim
from teachers.oracles.alfworld.search import IDLE, distance, thing_of, verb_of
from worlds.alfworld import Truth
from worlds.alfworld.exact import AGENT, NOTHING, ExactEngine
from worlds.alfworld.games import Game
from worlds.alfworld.house import House
from worlds.world import World


@claim
class Task(Claim):
    """True if the task is what `goal` says."""

    goal: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Read what the house itself says at the start, and win by dealing with what is named."""
        game = moment.after.game
        if not ExactEngine(game).intro().endswith(f"Your task is to: {self.goal}."):
            return False
        return all(each in self.goal for each in (game.target, game.destination, game.lamp))


@claim
class Commands(Claim):
    """True if these are the forms of all commands that the house knows."""

    listing: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Ask for help in the house itself."""
        lab.restore(moment.after)
        lab.advance("help")
        forms = [line.split(":")[0].strip() for line in lab.truth.feedback.splitlines()[1:]]
        return sorted(self.listing.split(", ")) == sorted(["help", *forms])


@claim
class Listed(Claim):
    """True if the observation lists the commands that can be carried out, and others come to nothing."""

    def holds(self, moment: Moment, lab: World) -> bool:
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
class TriedWell(Claim):
    """True if `action`, as the first command, brings the task nearer."""

    kind = HP
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out and search from there."""
        return _gain(lab, _begin(moment.after.game), self.action) > 0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedInVain(action=self.action),)


@claim
class TriedInVain(Claim):
    """True if `action`, as the first command, brings the task no nearer."""

    kind = HN
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out and search from there."""
        return _gain(lab, _begin(moment.after.game), self.action) <= 0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedWell(action=self.action),)


@claim
class Route(Claim):
    """True if these commands, in this order, do the task from here, and no shorter sequence does."""

    actions: tuple[str, ...]
    listing: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry them out, and search for the length of a shortest plan."""
        if self.listing != ", ".join(self.actions) or len(self.actions) != distance(moment.after):
            return False
        lab.restore(moment.after)
        successes = [lab.advance(action)[4]["success"] for action in self.actions]
        return successes.index(True) == len(successes) - 1


@claim
class Done(Claim):
    """True if this command has done the task."""

    kind = HP
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out again."""
        before = moment.before
        if before is None or before.won or moment.action != self.action:
            return False
        lab.restore(before)
        return lab.advance(self.action)[4]["success"]

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Deny it."""
        return (NoNearer(action=self.action),)


@claim
class Nearer(Claim):
    """True if this command has brought the task nearer: fewer commands than before are needed, namely `left`."""

    kind = HP
    action: str
    left: int
    """Commands that are still needed."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out again and search from there."""
        return (
            _made(self.action, moment)
            and _gain(lab, moment.before, self.action) > 0
            and distance(moment.after) == self.left
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict, or another number."""
        return (NoNearer(action=self.action), Nearer(action=self.action, left=self.left + 1))


@claim
class NoNearer(Claim):
    """True if this command has not brought the task nearer: as many commands as before are needed, or more."""

    kind = HN
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out again and search from there."""
        return _made(self.action, moment) and _gain(lab, moment.before, self.action) <= 0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (Nearer(action=self.action, left=distance(moment.after)),)


@claim
class Refused(Claim):
    """True if this command could not be carried out, so that nothing happened."""

    kind = HN
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Try it again."""
        before = moment.before
        if before is None or moment.action != self.action:
            return False
        lab.restore(before)
        listed = self.action in lab.commands()  # type: ignore[attr-defined]
        lab.advance(self.action)
        return not listed and lab.truth.facts == before.facts and lab.truth.feedback == NOTHING

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Praise it."""
        return (Nearer(action=self.action, left=distance(moment.after)),)


@claim
class Do(Claim):
    """True if `action` begins a shortest plan for a task not yet done; every tied plan counts."""

    kind = FP
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out and search from there."""
        return not moment.after.won and _gain(lab, moment.after, self.action) > 0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Recommend other commands."""
        lab.restore(moment.after)
        others = [each for each in lab.commands() if each != self.action]  # type: ignore[attr-defined]
        return tuple(Do(action=each) for each in others[:: max(1, len(others) // _OTHERS)])

    def coarser(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The command's verb, then what it is about."""
        thing = thing_of(self.action)
        return (DoVerb(verb=verb_of(self.action)), *((DoAbout(thing=thing),) if thing else ()))


@claim
class DoVerb(Claim):
    """True if a shortest plan begins with a command that starts with `verb`."""

    kind = FP
    verb: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry all such commands out and search from there."""
        return _some(lab, moment.after, lambda command: verb_of(command) == self.verb)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Another verb."""
        return tuple(DoVerb(verb=verb) for verb in ("go", "open", "take", "move") if verb != self.verb)


@claim
class DoAbout(Claim):
    """True if a shortest plan begins with a command that names `thing`."""

    kind = FP
    thing: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry all such commands out and search from there."""
        return _some(lab, moment.after, lambda command: thing_of(command) == self.thing)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Something else."""
        lab.restore(moment.after)
        things = {thing_of(each): None for each in lab.commands()}  # type: ignore[attr-defined]
        return tuple(DoAbout(thing=thing) for thing in things if thing not in ("", self.thing))[:_OTHERS]


@claim
class Avoid(Claim):
    """True if `action` can be carried out, and does not begin a shortest plan for a task not yet done."""

    kind = FN
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out and search from there."""
        if moment.after.won or _answer(lab, moment.after, self.action) == NOTHING:
            return False
        return _gain(lab, moment.after, self.action) <= 0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Warn of what is right."""
        lab.restore(moment.after)
        wanted = [each for each in lab.commands() if each.split()[0] not in IDLE]  # type: ignore[attr-defined]
        return tuple(Avoid(action=each) for each in wanted if _gain(lab, moment.after, each) > 0)[:1]


@claim
class Try(Claim):
    """True if, going by what has been seen, `action` is a step forward, as `_forward` says."""

    kind = FP
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out and look, or search the part of the house that has been seen."""
        return not moment.after.won and _forward(lab, moment.after, self.action)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Recommend commands that show nothing."""
        return tuple(Try(action=action) for action in ("inventory", "look", "help"))


@claim
class Needless(Claim):
    """True if `action` can be carried out and, going by what has been seen, is no step forward."""

    kind = FN
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out and look, or search the part of the house that has been seen."""
        truth = moment.after
        return not (truth.won or _answer(lab, truth, self.action) == NOTHING or _forward(lab, truth, self.action))

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Warn of what is right."""
        lab.restore(moment.after)
        wanted = [each for each in lab.commands() if each.split()[0] not in IDLE]  # type: ignore[attr-defined]
        return tuple(Needless(action=each) for each in wanted if _forward(lab, moment.after, each))[:1]


@claim
class Forward(Claim):
    """True if, going by what had been seen, this command was a step forward."""

    kind = HP
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out again and look, or search the part of the house that had been seen."""
        return _made(self.action, moment) and _forward(lab, moment.before, self.action)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (NotForward(action=self.action),)


@claim
class NotForward(Claim):
    """True if, going by what had been seen, this command was no step forward."""

    kind = HN
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out again and look, or search the part of the house that had been seen."""
        return _made(self.action, moment) and not _forward(lab, moment.before, self.action)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (Forward(action=self.action),)


_OTHERS = 6


def _made(action: str, moment: Moment) -> bool:
    return moment.before is not None and not moment.before.won and moment.action == action


def _begin(game: Game) -> Truth:
    return Truth(game.start, "", False, game)


def _answer(lab: World, truth: Truth, command: str) -> str:
    lab.restore(truth)
    lab.advance(command)
    return str(lab.truth.feedback)


def _gain(lab: World, truth: Truth, command: str) -> int:
    """By how many commands a command shortens what is left, found by search."""
    lab.restore(truth)
    lab.advance(command)
    after = lab.truth
    return distance(truth) - distance(after)


def seen(truth: Truth, house: House) -> frozenset[str]:
    """The receptacles whose contents the student must have seen, to judge by the facts.

    Of several receptacles at one location, of which an arrival shows but one, those that were opened or examined.
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
    """The truth without what lies in receptacles that have not been looked into."""
    known = seen(truth, house)
    facts = (fact for fact in truth.facts if fact[0] != "inreceptacle" or fact[2] in known)
    return truth._replace(facts=frozenset(facts))


def _forward(lab: World, truth: Truth, command: str) -> bool:
    """Whether a command begins a shortest plan for the part of the house that has been seen.

    If the task cannot be done with that: whether it shows what lies in a receptacle that had not been looked into, or
    leads to one.
    """
    house = House(truth.game)
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


def _some(lab: World, truth: Truth, fits: Callable[[str], bool]) -> bool:
    if truth.won:
        return False
    lab.restore(truth)
    return any(fits(each) and _gain(lab, truth, each) > 0 for each in lab.commands())  # type: ignore[attr-defined]
