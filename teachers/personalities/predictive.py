"""predictive(budget, threshold): as importance, and only if the student is expected to do what is not optimal."""

from collections import Counter
from dataclasses import dataclass
from typing import Any

from teachers.personalities.importance import Importance, Weighing
from teachers.personalities.mistake_correcting import TOLERANCE
from teachers.personality import Claims, View


class _Expecting(Weighing):
    """Counts the student's actions by state."""

    def begin(self) -> None:
        super().begin()
        self._done: dict[int | None, Counter[int]] = {None: Counter()}
        self._actions: dict[int, Any] = {}

    def speak(self, claims: Claims, view: View) -> Claims:
        moment = view.moment
        if moment.before is not None:
            action = view.action_fingerprint(moment.action)
            self._actions.setdefault(action, moment.action)
            for state in (view.fingerprint(moment.before), None):
                self._done.setdefault(state, Counter())[action] += 1
        return super().speak(claims, view)

    def wants(self, view: View) -> bool:
        if not super().wants(view):
            return False
        here = self._done.get(view.fingerprint(view.moment.after)) or self._done[None]
        return bool(here) and view.loss(self._actions[here.most_common(1)[0][0]]) > TOLERANCE


@dataclass(frozen=True)
class Predictive(Importance):
    """Speaks if much is at stake in the next action and the expected action is not optimal.

    The expected action is the student's most frequent one in this state, or, in a new state, in all states; the first
    of equally frequent ones. Before the first action it expects none and is silent.
    """

    needs = frozenset(("importance", "regret"))
    stage = _Expecting
