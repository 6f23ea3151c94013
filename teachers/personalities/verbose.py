"""verbose(k): says the same claims among useless sentences."""

from dataclasses import dataclass
from typing import Annotated

from teachers.common import FACTS, Truism
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Range


class _Chatter(Stage["Verbose"]):
    """Keeps the facts that it has not said."""

    def begin(self) -> None:
        self._facts: list[str] = []

    def speak(self, claims: Claims, view: View) -> Claims:
        said, facts = list(claims), list[str]()
        for _ in range(self.spec.k if claims else 0):
            kind = claims[int(self.rng.integers(len(claims)))].kind
            place = self.rng.integers(len(said) + 1)
            self._facts = self._facts or [fact for fact in FACTS if fact not in facts] or list(FACTS)
            facts.append(self._facts.pop(int(self.rng.integers(len(self._facts)))))
            said.insert(int(place), Truism(kind=kind, fact=facts[-1]))
        return said


@dataclass(frozen=True)
class Verbose(Personality):
    """Inserts k truisms a turn at random places among the claims; without claims it is silent.

    It says no truism twice before it has said them all. A truism has the kind of one of the claims, so that it is
    withheld if that kind is.
    """

    k: Annotated[int, Range(0, 100)] = 3
    """Truisms a turn, at least 0."""

    source = "Shute 2008"
    stage = _Chatter
