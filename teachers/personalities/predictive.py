"""predictive(budget, threshold): as importance, and only if the student is expected to do what is not optimal."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from teachers.atoms import Claim
from teachers.personalities import importance
from teachers.personalities.mistake_correcting import TOLERANCE
from teachers.personality import Personality, View


@dataclass(frozen=True)
class Predictive(Personality):
    """Speaks iff much is at stake in the next action and the one that it expects is not optimal.

    It expects what the student did most often in this state, or where it has not been, most often of all; of equally
    frequent actions the one taken first. Before the first action it expects nothing and is silent.
    """

    budget: int = 10
    """Turns in which it may speak, at least 0."""
    threshold: float = 0.5
    """Least importance of the next action, at least 0."""

    source = "Torrey & Taylor 2013"
    needs = frozenset(("importance", "regret"))

    __post_init__ = importance.Importance.__post_init__

    class Stage(importance.Importance.Stage):
        """Counts what the student does where."""

        def begin(self) -> None:
            """Nothing was done."""
            super().begin()
            self._done: dict[int | None, Counter[int]] = {None: Counter()}
            self._actions: dict[int, Any] = {}

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """Learn from the last action first."""
            moment = view.moment
            if moment.before is not None:
                action = view.fingerprint(moment.action)
                self._actions.setdefault(action, moment.action)
                for state in (view.fingerprint(moment.before), None):
                    self._done.setdefault(state, Counter())[action] += 1
            return super().speak(claims, view)

        def wants(self, view: View) -> bool:
            """Whether a mistake is expected that matters."""
            if not super().wants(view):
                return False
            here = self._done.get(view.fingerprint(view.moment.after)) or self._done[None]
            return bool(here) and view.loss(self._actions[here.most_common(1)[0][0]]) > TOLERANCE
