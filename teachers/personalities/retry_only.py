"""retry_only: "that was not it, try again" while the task is unsolved, no information beyond success.

A control: what a student gains from it, it gains from being told to try again (arXiv 2606.30774).
"""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import Claim
from teachers.common import TryAgain
from teachers.personality import Personality, Stage, View

_TRY_AGAIN = (TryAgain(),)


@dataclass(frozen=True)
class RetryOnly(Personality):
    """Tells the student to try again after each action that did not solve the task."""

    source = "arXiv 2606.30774"
    reveals = False

    class Stage(Stage):
        """Has nothing to remember."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """The one sentence, or nothing."""
            moment = view.moment
            return () if moment.success or moment.action is None else _TRY_AGAIN
