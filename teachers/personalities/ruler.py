"""ruler: says only what carries over to other moments or worlds, one new clue at a time, from little to much."""

from dataclasses import dataclass
from typing import Any

from teachers.atoms import Claim
from teachers.personality import Claims, Personality, Stage, View


class _Rules(Stage["Ruler"]):
    """Keeps what was said."""

    def begin(self) -> None:
        self._said: set[Claim[Any]] = set()

    def speak(self, claims: Claims, view: View) -> Claims:
        for clue in view.clues():
            if clue.scope.lasts and clue.kind in view.kinds and clue not in self._said:
                self._said.add(clue)
                return (clue,)
        return ()


@dataclass(frozen=True)
class Ruler(Personality):
    """Says in each turn the first of the oracle's clues that it has not yet said in the episode, and nothing else.

    It uses only clues that stay true for the whole episode or in every world of a town.
    """

    source = "ours"
    reveals = False
    needs = frozenset(("clues",))
    stage = _Rules
