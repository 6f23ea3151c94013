"""Picture of ALFWorld: the places of the house, their contents as far as seen, and the inventory."""

from collections.abc import Iterable, Sequence

import numpy as np

from worlds.alfworld.exact import AGENT
from worlds.alfworld.games import Fact
from worlds.alfworld.house import House, house_of
from worlds.alfworld.world import Alfworld, Truth
from worlds.pictures import Picture, Sight, Text
from worlds.pictures.canvas import Canvas, height_of, listed, measure, wrap
from worlds.pictures.themes import MEDIUM, SMALL
from worlds.world import WorldTurn

__all__ = ["AlfworldPicture"]

_STATES = ("isclean", "ishot", "iscool", "issliced", "istoggled")
_BELOW = 46
_PLAN = 2 * 1.32 * SMALL  # height of two lines


class AlfworldPicture(Picture[Truth, Alfworld]):
    """A card per place, the current one framed; if privileged, with all contents and the next commands."""

    reach = 3

    def draw(self, canvas: Canvas, sight: Sight[Truth]) -> None:
        """Draw the task, the places in the order of their names, and the inventory."""
        theme, truth = canvas.theme, sight.now
        house = house_of(truth.game)
        found = _inside(truth.facts, house) if sight.privileged else _remembered(sight.turns, house)
        task = wrap(truth.game.goal, MEDIUM, canvas.width - 28)
        for i, line in enumerate(task[:2]):
            canvas.text((14, 18 + 20 * i), line, MEDIUM, bold=True, most=canvas.width - 28)
        places = sorted(house.place, key=lambda each: _order(house.name[each]))
        columns = 2 if len(places) <= 16 else 3
        rows = -(-len(places) // columns)
        plan = f"next: {' · '.join(sight.plan)}" if sight.plan else ""
        planned = min(height_of(plan, SMALL, canvas.width - 28), _PLAN) if plan else 0
        top = 20 * min(len(task), 2) + 16
        floor = canvas.height - _BELOW - planned
        width, step = (canvas.width - 28 + 6) / columns, min((floor - top) / rows, 46)
        here = _location(truth.facts)
        for i, place in enumerate(places):
            column, row = divmod(i, rows)
            x, y = 14 + column * width, top + row * step
            at = house.place[place] == here
            held = found.get(place)
            fill = theme.card if held is not None else theme.ground
            outline = theme.blue if at else theme.faint
            canvas.box((x, y), (width - 6, step - 4), fill, outline, 2.5 if at else 1, 5)
            state = "" if place not in house.openable else "open" if ("opened", place) in truth.facts else "closed"
            size = min(step * 0.32, SMALL)
            ink = theme.ink if held is not None or at else theme.muted
            called, most = house.name[place], width - 18
            size = next((each for each in (size, size - 1, size - 2) if measure(called, each, at) <= most), size - 3)
            name = canvas.text((x + 6, y + step * 0.26), called, size, ink, bold=at, most=most)
            if state and held is not None and name + measure(state, size - 1) + 6 <= most:
                canvas.text((x + width - 12, y + step * 0.26), state, size - 1, theme.muted, anchor="rm")
            if held is not None:
                names = [house.name[each] for each in held] or ["nothing"]
                sizes = (each for each in (size, 10.0, 9.0) if listed(names, each, most).startswith(names[0]))
                size = next(sizes, 9.0)
                colour = theme.purple if held else theme.muted
                canvas.text((x + 6, y + step * 0.64), listed(names, size, most), size, colour, most=most)
        if plan:
            canvas.paragraph((14, floor + 2), plan, canvas.width - 28, _PLAN, SMALL, theme.green)
        carried = [_called(each, truth.facts, house) for each in _held(truth.facts)]
        canvas.line([(14, canvas.height - 38), (canvas.width - 14, canvas.height - 38)], theme.faint)
        label = canvas.text((14, canvas.height - 18), "in hand", SMALL, theme.muted)
        inventory = listed(carried, MEDIUM, canvas.width - 36 - label, bold=True) or "nothing"
        canvas.text((22 + label, canvas.height - 18), inventory, MEDIUM, theme.purple, bold=True)

    def text(self, sight: Sight[Truth]) -> Text:
        """The contents of the places as far as seen, above the world's description."""
        house = house_of(sight.now.game)
        here = _location(sight.now.facts)
        found = _remembered(sight.turns, house)
        lines = [
            (
                f"{house.name[place]}: {', '.join(house.name[each] for each in found[place]) or 'nothing'}\n",
                "here" if house.place[place] == here else "",
            )
            for place in sorted(found, key=lambda each: _order(house.name[each]))
        ]
        return (*lines, (sight.seen, ""))

    def alike(self, turns: Sequence[WorldTurn[Truth]], rng: np.random.Generator) -> Sequence[WorldTurn[Truth]]:
        """Empties the places that were not visited."""
        house = house_of(turns[0].truth.game)
        been = {_location(turn.truth.facts) for turn in turns}
        looked = {place for place, location in house.place.items() if location in been}
        touched = {fact[1] for turn in turns for fact in turn.truth.facts if fact[0] == "holds"}

        def hidden(fact: Fact) -> bool:
            return fact[0] == "inreceptacle" and fact[2] not in looked and fact[1] not in touched

        return [
            turn._replace(
                truth=turn.truth._replace(facts=frozenset(fact for fact in turn.truth.facts if not hidden(fact)))
            )
            for turn in turns
        ]


def _order(name: str) -> tuple[str, int]:
    """The type, then the number."""
    kind, _, number = name.rpartition(" ")
    return kind, int(number) if number.isdecimal() else 0


def _location(facts: Iterable[Fact]) -> str:
    return next((fact[2] for fact in facts if fact[0] == "atlocation" and fact[1] == AGENT), "")


def _held(facts: Iterable[Fact]) -> list[str]:
    return sorted(fact[2] for fact in facts if fact[0] == "holds")


def _called(each: str, facts: frozenset[Fact], house: House) -> str:
    """The name of an object, with its states."""
    states = [state.removeprefix("is") for state in _STATES if (state, each) in facts]
    return " ".join([*states, house.name[each]])


def _inside(facts: Iterable[Fact], house: House) -> dict[str, list[str]]:
    """The contents of each place."""
    inside: dict[str, list[str]] = {place: [] for place in house.place}
    for fact in sorted(facts):
        if fact[0] == "inreceptacle" and fact[2] in inside:
            inside[fact[2]].append(fact[1])
    return inside


def _remembered(turns: Sequence[WorldTurn[Truth]], house: House) -> dict[str, list[str]]:
    """The contents of the places that the student has looked into.

    To look into a place is to go there or examine it while it is not closed, or to open it. Only the student's own
    actions change the contents.
    """
    looked: set[str] = set()
    for turn in turns:
        verb, _, name = str(turn.action or "").partition(" ")
        place = house.id.get(name.removeprefix("to "))
        if verb not in ("go", "open", "examine") or place not in house.place:
            continue
        facts = turn.truth.facts
        if _location(facts) == house.place[place] and (place not in house.openable or ("opened", place) in facts):
            looked.add(place)
    inside = _inside(turns[-1].truth.facts, house)
    return {place: inside[place] for place in house.place if place in looked}
