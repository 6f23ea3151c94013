"""A witness of an episode: it sees and hears what the student does, and measures claims for it."""

from collections.abc import Sequence
from typing import Any, Generic, TypeVar

from teachers.atoms import Atom, Claim, Moment
from teachers.information import Bits, Information
from teachers.oracle import EXACT, POSTERIOR
from worlds.posteriors import Posterior

__all__ = ["InformationT", "Note", "Witness", "abilities_of"]

Note = Moment[Any] | tuple[Atom, ...]
"""A turn that a student has seen, or what it has heard about the last turn."""


InformationT = TypeVar("InformationT", bound=Information)


def abilities_of(posterior: Posterior[Any] | type[Posterior[Any]]) -> frozenset[str]:
    """The `teachers.oracle.ABILITIES` that a posterior adds to an oracle."""
    return frozenset((POSTERIOR, EXACT) if posterior.exact else (POSTERIOR,))


class Witness(Generic[InformationT]):
    """Lets information about a student follow an episode.

    Args:
        information: fresh, and not the object with which an audit measures the same claims.
        notes: what the student sees and hears; the caller appends to it.
    """

    def __init__(self, information: InformationT, notes: Sequence[Note]) -> None:
        self.information, self._notes = information, notes
        self._noted = 0  # number of notes that are known
        self._first = self._next = 0  # turns: an episode may be followed from a later one than its opening

    def follow(self) -> None:
        """See and hear the new notes."""
        for note in self._notes[self._noted :]:
            if isinstance(note, Moment):
                self.see(note)
            else:
                self.hear(note)
        self._noted = len(self._notes)

    def weigh(self, claim: Claim[Any], about_turn: int) -> Bits:
        """How much a claim about a turn would say now."""
        self.follow()
        found = self.information.weigh(Atom(claim, "", about_turn - self._first))
        self.information.rest()
        return found

    def see(self, moment: Moment[Any]) -> None:
        """Note a turn. If earlier turns are missing, this one becomes the opening."""
        if moment.turn > self._next:
            self._first = moment.turn
            moment = Moment.opening(moment.after, moment.turn)
        self._next = moment.turn + 1
        self.information.see(moment._replace(turn=moment.turn - self._first))

    def hear(self, atoms: Sequence[Atom]) -> None:
        """Note what was said about turns that were seen."""
        known = [atom._replace(about_turn=atom.about_turn - self._first) for atom in atoms]
        self.information.hear([atom for atom in known if atom.about_turn >= 0])
