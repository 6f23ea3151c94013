"""misaligned: true words of another moment in another world, of the same kinds and number, and about as long.

A control: it measures the gain from hearing words of the task that are not about one's own task. The moment elsewhere
depends on the lesson only by the kinds, classes and lengths of the claims to replace. arXiv 2605.12748 compares
feedback on a student's misconception with feedback on another one, arXiv 2606.21409 tool results with shuffled ones.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Any, NamedTuple

from teachers.atoms import Claim, Moment, unhedged
from teachers.common import Late
from teachers.elsewhere import Elsewhere, MomentElsewhere
from teachers.personality import Claims, Personality, Stage, View

_AHEAD = 6  # moments elsewhere before the first turn, to choose from
_TRIES = 24  # further moments, if there are too few claims of a kind


class _Wanted(NamedTuple):
    """What a claim elsewhere must resemble."""

    claim: Claim[Any]
    bare: Claim[Any]
    """The claim, neither late nor hedged."""
    words: float


class _Found(NamedTuple):
    claim: Claim[Any]
    moment: Moment[Any]
    other: bool
    """Whether it is of another class."""
    words: float


class _Swap(Stage["Misaligned"]):
    """Follows lessons elsewhere, and counts by how many words it is behind the oracle."""

    def begin(self) -> None:
        self._elsewhere: Elsewhere | None = None
        self._owed = 0.0

    def speak(self, claims: Claims, view: View) -> Claims:
        if not claims:
            return ()
        wanted = [_Wanted(claim, _bare(claim), view.words(claim)) for claim in claims]
        clues = any(each.bare.scope.lasts for each in wanted)
        elsewhere = self._elsewhere
        if elsewhere is None or clues > elsewhere.clues:
            elsewhere = self._elsewhere = view.elsewhere(self.rng, clues=clues)
            for _ in range(_AHEAD):
                elsewhere.go_on()
        self._owed += sum(each.words for each in wanted)
        found = self._found(wanted, elsewhere)
        self._owed -= sum(each.words for each in found if each)
        return [
            view.displace(here.claim, there.claim, there.moment)
            for here, there in zip(wanted, found, strict=True)
            if there
        ]

    def _found(self, wanted: list[_Wanted], elsewhere: Elsewhere) -> list[_Found | None]:
        """A claim elsewhere for each of these: of one moment, which is not used again, or else of several."""
        kinds = Counter(each.claim.kind for each in wanted)
        found: list[_Found | None] = []
        for _ in range(_TRIES):
            elsewhere.go_on()
            if able := [said for said in elsewhere.moments if kinds <= said.kinds]:
                sets = [(_matches(wanted, [said]), said) for said in able]
                found, said = min(sets, key=lambda each: self._distance(each[0]))
                elsewhere.moments.remove(said)
                return found
            found = _matches(wanted, [*elsewhere.moments, *chain.from_iterable(elsewhere.reserve.values())])
            if all(found):
                break
        return found

    def _distance(self, found: list[_Found | None]) -> tuple[int, float]:
        """Number of claims of other classes, then how far the words are from those that are owed."""
        return sum(each.other for each in found if each), abs(self._owed - sum(each.words for each in found if each))


def _bare(claim: Claim[Any]) -> Claim[Any]:
    return unhedged(claim.claim if isinstance(claim, Late) else claim)


def _matches(wanted: list[_Wanted], said: list[MomentElsewhere]) -> list[_Found | None]:
    """For each claim the most similar one of its kind elsewhere; none twice, and none that excludes another."""
    found: list[_Found | None] = []
    for each in wanted:
        taken = [one.claim for one in found if one]
        free = [one for one in _of_kind(each, said) if not any(_clash(one.claim, other) for other in taken)]
        found.append(min(free, key=lambda one: (one.other, abs(one.words - each.words)), default=None))
    return found


def _of_kind(wanted: _Wanted, said: list[MomentElsewhere]) -> Iterator[_Found]:
    for moment, claims, _, words in said:
        for claim, number in zip(claims, words, strict=True):
            if claim.kind is wanted.claim.kind:
                yield _Found(claim, moment, type(claim) is not type(wanted.bare), number)


def _clash(one: Claim[Any], other: Claim[Any]) -> bool:
    return one == other or one.excludes(other) or other.excludes(one)


@dataclass(frozen=True)
class Misaligned(Personality):
    """Replaces each claim by a true one of another world, of the same kind and, on average, the same length.

    The claims of a turn are those of one moment elsewhere, if one has enough claims of each kind; claims of the same
    classes as the replaced ones come first. A claim for whose kind none is found elsewhere is withheld.
    """

    source = "arXiv 2605.12748; arXiv 2606.21409"
    honest = False
    elsewhere = True
    stage = _Swap
