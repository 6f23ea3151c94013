"""Facts that have nothing to do with any task."""

from collections.abc import Sequence
from typing import Any

from teachers.atoms import Claim, FeedbackType, Moment, claim
from worlds.world import World

FACTS = (
    "ice melts",
    "rain falls",
    "fire burns",
    "time passes",
    "ice is cold",
    "a week has seven days",
    "the sun rises in the east",
    "bread is often made from wheat flour",
    "a triangle has three sides and three corners",
    "most cats sleep for many hours of the day",
    "letters are sorted into the alphabet from a to z",
    "a bicycle has two wheels and a car usually has four",
    "rain falls from clouds and rivers carry the water to the sea",
    "the moon goes around the earth about once in every twenty-seven days",
    "an orchestra has strings, woodwinds, brass and percussion, and a conductor who leads them",
    "paper is made from wood, and wood comes from trees, which need light and water to grow",
)
"""True, useless sentences of 2 to 17 words, by length."""


@claim
class Truism(Claim[Any]):
    """True always: a fact that has nothing to do with the task, from the list of the placebo personality."""

    kind: FeedbackType | None  # type: ignore[misc]  # other claims are filed by their class
    """The kind of the claim that it replaces: a truism has none of its own."""
    placebo = True
    fact: str

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Look the fact up."""
        return self.fact in FACTS

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """The denial of the fact."""
        return (Truism(kind=self.kind, fact=f"it is wrong that {self.fact}"),)
