"""early(budget): speaks in the first turns and is silent from then on (early advising)."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import Claim
from teachers.personality import Personality, Stage, View
from teachers.spec import check_range


@dataclass(frozen=True)
class Early(Personality):
    """Spends its budget as soon as it can. The budget counts turns of an episode in which something is said."""

    budget: int = 10
    """Turns in which it may speak, at least 0."""

    source = "Torrey & Taylor 2013"

    def __post_init__(self) -> None:
        check_range("budget", self.budget, 0, 1_000_000, int)

    class Stage(Stage):
        """Counts turns of advice."""

        def begin(self) -> None:
            """Nothing is spent."""
            self._left = self.spec.budget

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """Everything, as long as the budget lasts."""
            if not claims or not self._left or not self.wants(view):
                return ()
            self._left -= 1
            return claims

        def wants(self, view: View) -> bool:
            """Whether this turn is worth a turn of the budget."""
            return True
