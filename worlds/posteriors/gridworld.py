"""Posterior of gridworld: exact, where the student has the plan of the house."""

from collections.abc import Iterator, Sequence

import numpy as np

from worlds.gridworld import Gridworld, Truth, distances_from
from worlds.posteriors import NoWorldError, Posterior
from worlds.world import WorldTurn

__all__ = ["GridworldPosterior"]


class GridworldPosterior(Posterior[Truth, Gridworld]):
    """The treasure is as likely in any room that is far enough from the start, until one of them is entered."""

    needs = {"map": True}  # noqa: RUF012 (a ClassVar in the base)

    def __init__(self, lab: Gridworld) -> None:
        super().__init__(lab)
        if not lab.options["map"]:
            raise ValueError(
                "a gridworld has a posterior only where the student knows the plan of the house: without it, none of "
                "many thousand houses that its generator draws agrees with a few rooms; pass map=True"
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
        return [(start._replace(layout=layout._replace(treasure=room)), 1 / len(rooms)) for room in rooms]

    def quantities(self, turns: Sequence[WorldTurn[Truth]]) -> dict[str, float]:
        """Where the treasure is, and how far from the way that was gone."""
        start, now = turns[0].truth, turns[-1].truth
        away = distances_from(now.layout.treasure, now.layout.doors)
        return {
            "room of the treasure": now.layout.treasure,
            "moves from the start": away[start.room],
            "moves from the last room": away[now.room],
            "least moves from the way": min(away[turn.truth.room] for turn in turns),
        }
