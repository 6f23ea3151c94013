"""Posterior of gridworld: exact, where the student has the plan of the house."""

from collections.abc import Iterator, Sequence

import numpy as np

from worlds.gridworld import Gridworld, Layout, Truth, distances_from, kind_of
from worlds.posteriors import NoWorldError, Posterior
from worlds.world import WorldTurn

__all__ = ["GridworldPosterior"]


class GridworldPosterior(Posterior[Truth, Gridworld]):
    """The treasure is equally likely in every room that is far enough from the start and was not entered.

    This also holds in a town, whose law a student does not know: every type of room is equally likely to have the
    treasures, and each room's type is drawn uniformly, so that its type tells nothing about a room.
    """

    needs = {"map": True}  # noqa: RUF012 (a ClassVar in the base)

    def __init__(self, lab: Gridworld) -> None:
        super().__init__(lab)
        if not lab.options["map"]:
            raise ValueError(
                "a gridworld has a posterior only where the student knows the plan of the house: without it, none of "
                "many thousand houses that its generator draws agrees with a few rooms; set the option map=True"
            )

    def openings(self, turns: Sequence[WorldTurn[Truth]], rng: np.random.Generator) -> Iterator[Truth]:
        """Move the treasure."""
        truths = [truth for truth, _ in self.odds(turns)]
        while True:
            yield truths[rng.integers(len(truths))]

    def odds(self, turns: Sequence[WorldTurn[Truth]]) -> list[tuple[Truth, float]]:
        """Every place of the treasure."""
        start = turns[0].truth
        been = {turn.truth.room for turn in turns}
        layout, least = start.layout, self.lab.options["min_goal_dist"]
        far = [room for room, steps in enumerate(distances_from(start.room, layout.doors)) if steps >= least]
        # A room that was entered has shown whether the treasure is in it.
        rooms = [room for room in far if room == layout.treasure] if layout.treasure in been else []
        rooms = rooms or [room for room in far if room not in been]
        if not rooms:
            raise NoWorldError("the treasure is in none of the rooms where it may be")
        return [(start._replace(layout=_moved(layout, room)), 1 / len(rooms)) for room in rooms]

    def quantities(self, turns: Sequence[WorldTurn[Truth]]) -> dict[str, float]:
        """Where the treasure is, and its distance from the student's path."""
        start, now = turns[0].truth, turns[-1].truth
        away, law = distances_from(now.layout.treasure, now.layout.doors), now.layout.law
        types, kinds = self.lab.options["room_types"], [kind_of(name) for name in now.layout.names]
        return {
            **({"law": types.index(law), "rooms of its type": kinds.count(law)} if law else {}),
            "room of the treasure": now.layout.treasure,
            "moves from the start": away[start.room],
            "moves from the last room": away[now.room],
            "least moves from the way": min(away[turn.truth.room] for turn in turns),
        }


def _moved(layout: Layout, room: int) -> Layout:
    """The house with the treasure in another room, and the law of a town where it can lie there."""
    return layout._replace(treasure=room, law=layout.law and kind_of(layout.names[room]))
