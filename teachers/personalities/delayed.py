"""delayed(turns): claims arrive some turns late (TAMER's credit assignment problem)."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import Claim
from teachers.common import Late
from teachers.personality import Personality, Stage, View
from teachers.spec import check_range


@dataclass(frozen=True)
class Delayed(Personality):
    """Says at each turn what it would have said some turns ago; what is not yet said at the end is lost."""

    turns: int = 1
    """How late a claim is, at least 0."""

    source = "TAMER: Knox & Stone 2009"

    def __post_init__(self) -> None:
        check_range("turns", self.turns, 0, 10_000, int)

    class Stage(Stage):
        """Keeps the claims that are under way."""

        def begin(self) -> None:
            """Nothing is under way."""
            self._queue: deque[tuple[Claim, ...]] = deque()

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """The claims of an earlier turn."""
            late = [c if isinstance(c, Late) else Late(claim=c, turn=view.turn) for c in claims]
            self._queue.append(tuple(late) if self.spec.turns else claims)
            return self._queue.popleft() if len(self._queue) > self.spec.turns else ()
