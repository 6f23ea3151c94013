"""What a teacher may still say in an episode, and what saying it costs."""

import sys
from collections.abc import Sequence
from typing import Any

from teachers.atoms import atoms_of
from teachers.spec import check_cost, is_count

__all__ = ["Budget", "price", "within"]


class Budget:
    """The atoms of feedback that a teacher may say in an episode, and their cost.

    Args:
        cost: paid per atom of feedback, or per text without atoms, at least 0.
        limit: atoms of feedback that may be said; what exceeds it is not said. None: any number.

    Raises:
        ValueError: an argument is not allowed.
    """

    def __init__(self, cost: float = 0.01, limit: int | None = None) -> None:
        check_cost("cost", cost)
        if limit is not None and not is_count(limit):
            raise ValueError(f"budget must be None or an integer of at least 1, got {limit!r}")
        self.cost, self.limit, self.spent = cost, limit, 0

    @property
    def left(self) -> int:
        """Atoms that can still be said; without a limit, more than any turn has."""
        return sys.maxsize if self.limit is None else max(self.limit - self.spent, 0)

    @property
    def share(self) -> float:
        """Share of the limit that is left, 0 to 1; 1 without a limit."""
        return self.left / self.limit if self.limit else 1.0

    def pay(self, atoms: int) -> float:
        """Spend this many atoms; returns the teacher's reward, which is the negative cost."""
        self.spent += atoms
        return -self.cost * atoms


def price(said: str) -> int:
    """The number of atoms that a teacher pays for: those of feedback; 1 for a text without atoms, 0 for silence."""
    atoms = atoms_of(said)
    return sum([atom.claim.kind is not None for atom in atoms]) if atoms else int(said != "")


def within(left: int, items: Sequence[Any]) -> list[Any]:
    """The first `left` claims or atoms of feedback, and all others."""
    kept = []
    for item in items:
        if item.kind is None or left > 0:
            kept.append(item)
            left -= item.kind is not None
    return kept
