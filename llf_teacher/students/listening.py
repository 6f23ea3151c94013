"""Base of policies that hear claims, also claims that they read in the words of people and models."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from llf_teacher.students.student import Policy, S_co
from teachers.atoms import Atom
from teachers.schema import without

if TYPE_CHECKING:
    from pz_envs.text.claims import ClaimReader


class ListeningPolicy(Policy[S_co]):
    """Reads words without claims if its student `follows_words`, by the rules of the world; it has no truth."""

    _reader: "ClaimReader | None" = None
    _turn = 0

    def begin(self) -> None:
        """Begin an episode."""
        super().begin()
        if getattr(self.spec, "follows_words", False):
            from pz_envs.text.claims import ClaimReader

            self._reader = ClaimReader(self.family, self.world)
            self._reader.did(None, 0)

    def heard(self, observation: dict[str, Any], info: dict[str, Any], turn: int) -> Sequence[Atom]:
        """The atoms of a turn, followed by the claims that are read in its other words."""
        atoms: Sequence[Atom] = info["atoms"]
        if self._reader is None:
            return atoms
        self._turn = turn
        said = self._reader.read(without(observation["feedback"], (atom.text for atom in atoms)))
        return (*atoms, *(Atom(each.claim, each.text, each.about_turn) for each in said if each.claim is not None))

    def did(self, action: Any) -> None:
        """Note the present action, since verdicts may be about it."""
        if self._reader is not None:
            self._reader.did(self.world.legal(action), self._turn + 1)
